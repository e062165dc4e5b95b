"""The file of a backup: a tar archive that ends with the SHA-256 of each of its members.

An archive without that end is not complete, whatever else it has. `sha256sum --check` reads the
list of sums. Writing and reading take the memory of one member of the database, however large the
archive is.
"""

import hashlib
import io
import os
import secrets
import tarfile
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

from seamark.drafts import sync_folder

SUMS = "sha256sums.txt"
MODE = 0o600  # of all that is written: it has the hashes of passwords and the keys
COPY_BYTES = 1024 * 1024
OnBytes = Callable[[int], None]  # told how many more bytes have been copied


class ArchiveRejected(Exception):
    """The file is not a complete, unchanged backup. The text says what is wrong with it."""


class Content:
    """The content of a member, read once from its start to its end."""

    def __init__(self, file: IO[bytes], on_bytes: OnBytes) -> None:
        self._file, self._on_bytes = file, on_bytes
        self._sum = hashlib.sha256()

    def read(self, size: int = -1) -> bytes:
        """Return the next bytes, all of them without `size`; raises ArchiveRejected."""
        try:
            part = self._file.read(size)
        except tarfile.ReadError:
            raise ArchiveRejected("The backup is not complete: it ends too early") from None
        self._sum.update(part)
        self._on_bytes(len(part))
        return part

    def parts(self) -> Iterator[bytes]:
        """Yield all that has not been read, in parts."""
        while part := self.read(COPY_BYTES):
            yield part

    def lines(self) -> Iterator[bytes]:
        """Yield the lines, each with its end; raises ArchiveRejected."""
        rest = b""
        for part in self.parts():
            *lines, rest = (rest + part).split(b"\n")
            yield from (line + b"\n" for line in lines)

    def sha256(self) -> str:
        """Return the sum of what has been read."""
        return self._sum.hexdigest()


class ArchiveWriter:
    """Adds members to an archive, and at the end their sums."""

    def __init__(self, tar: tarfile.TarFile, sums: IO[bytes], on_bytes: OnBytes) -> None:
        self._tar, self._sums, self._on_bytes = tar, sums, on_bytes
        self.bytes = 0  # of all members

    def add_bytes(self, name: str, content: bytes) -> None:
        """Add a member that is in memory."""
        self._add(name, io.BytesIO(content), len(content))

    def add_file(self, name: str, path: Path) -> None:
        """Add as much of a file as there is now; raises FileNotFoundError."""
        with path.open("rb") as file:
            self._add(name, file, os.fstat(file.fileno()).st_size)

    def end(self) -> None:
        """Add the sums; the archive is complete then."""
        size = self._sums.tell()
        self._sums.seek(0)
        self._tar.addfile(_member(SUMS, size), self._sums)

    def _add(self, name: str, file: IO[bytes], size: int) -> None:
        content = Content(file, self._on_bytes)
        self._tar.addfile(_member(name, size), content)
        _forget_members(self._tar)
        self._sums.write(_line(content.sha256(), name))
        self.bytes += size


@contextmanager
def writing(target: Path, on_bytes: OnBytes) -> Iterator[ArchiveWriter]:
    """Yield the writer of an archive that takes its name only when it is complete and on the disk.

    Raises
    ------
    FileExistsError
        There is a file of this name.
    """
    if target.exists():
        raise FileExistsError
    draft = target.with_name(f".{target.name}.{secrets.token_hex(4)}.partial")
    try:
        opened = os.open(draft, os.O_WRONLY | os.O_CREAT | os.O_EXCL, MODE)
        with open(opened, "wb") as file, tempfile.TemporaryFile(dir=target.parent) as sums:
            with tarfile.open(fileobj=file, mode="w", format=tarfile.PAX_FORMAT) as tar:
                writer = ArchiveWriter(tar, sums, on_bytes)
                yield writer
                writer.end()
            file.flush()
            os.fsync(file.fileno())
        os.link(draft, target)  # fails if the name was taken meanwhile
    finally:
        draft.unlink(missing_ok=True)
    sync_folder(target.parent)


def members(archive: Path, on_bytes: OnBytes) -> Iterator[tuple[str, Content]]:
    """Yield the members in their order; each has to be read before the next one.

    Raises
    ------
    ArchiveRejected
        The file is no archive, is damaged, or has anything but plain files.
    """
    try:
        with tarfile.open(archive, mode="r|") as tar:
            for member in tar:
                file = tar.extractfile(member) if member.isreg() else None
                if file is None:
                    raise ArchiveRejected(f"{archive} is not a backup of Seamark")
                yield member.name, Content(file, on_bytes)
                _forget_members(tar)
    except (tarfile.TarError, EOFError):
        raise ArchiveRejected(f"{archive} is not a complete backup of Seamark") from None


def verify(archive: Path, on_bytes: OnBytes) -> None:
    """Read the whole archive and compare all sums; raises ArchiveRejected."""
    with tempfile.TemporaryFile() as file:
        is_complete = False
        for name, content in members(archive, on_bytes):
            if is_complete:
                raise ArchiveRejected(f"{archive} is damaged: it goes on after its end")
            if name == SUMS:
                _compare(archive, file, content)
                is_complete = True
            else:
                for _ in content.parts():
                    pass
                file.write(_line(content.sha256(), name))
    if not is_complete:
        raise ArchiveRejected(f"{archive} is not a complete backup: its end is missing")


def _compare(archive: Path, member: IO[bytes], listed: Content) -> None:
    """Compare the sums that were computed with those that the archive lists."""
    member.seek(0)
    stated = listed.lines()
    for line in member:
        if next(stated, b"") != line:
            name = line.decode().partition("  ")[2].strip()
            raise ArchiveRejected(f"{archive} is damaged: the SHA-256 of {name} differs")
    if next(stated, b""):
        raise ArchiveRejected(f"{archive} is damaged: members are missing")


def _member(name: str, size: int) -> tarfile.TarInfo:
    member = tarfile.TarInfo(name)
    member.size, member.mode = size, MODE
    return member


def _line(sha256: str, name: str) -> bytes:
    return f"{sha256}  {name}\n".encode()


def _forget_members(tar: tarfile.TarFile) -> None:
    """Empty the list of members, which tarfile keeps: there may be millions."""
    tar.members = []  # type: ignore[attr-defined]  # not in the stubs
