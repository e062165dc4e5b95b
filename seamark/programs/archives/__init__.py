"""Uploaded archives: untrusted, read strictly, and never unpacked to disk by the server.

`files_of` reads .zip and .tar.gz in memory; `normal_form` writes the files to a new zip archive
without compression, links or dates, so that equal contents give equal bytes. This archive is stored
under its SHA-256, and unpacked inside the sandbox.
"""

import io
import os
import zipfile
from collections.abc import Iterator, Mapping
from pathlib import Path

from seamark.programs.archives.names import NameRefused, Names
from seamark.programs.archives.reading import ArchiveRefused, Member
from seamark.programs.archives.tar import members_of_tar_gz
from seamark.programs.archives.zip import members_of_zip
from seamark.sandbox.limits import Limits

__all__ = [
    "SUFFIXES",
    "ArchiveRefused",
    "files_of",
    "is_archive",
    "normal_form",
    "of_folder",
    "read_normal",
]

SUFFIXES = (".zip", ".tar.gz", ".tgz")
DROPPED = ("__MACOSX", "__pycache__", ".git", ".DS_Store", "Thumbs.db", "desktop.ini")
NESTED = {  # magic bytes -> format
    b"PK\x03\x04": "zip",
    b"PK\x05\x06": "zip",
    b"\x1f\x8b": "gzip",
    b"BZh": "bzip2",
    b"\xfd7zXZ\x00": "xz",
    b"7z\xbc\xaf\x27\x1c": "7z",
    b"Rar!\x1a\x07": "rar",
    b"\x28\xb5\x2f\xfd": "zstd",
}
_TAR_MAGIC = slice(257, 262)  # "ustar"
_DATE = (1980, 1, 1, 0, 0, 0)


def is_archive(name: str) -> bool:
    """Return whether the name is that of an archive."""
    return name.lower().endswith(SUFFIXES)


def files_of(data: bytes, name: str, *, limits: Limits) -> dict[str, bytes]:
    """Return path -> content of the files in an archive, sorted by path.

    Drops files added by operating systems and tools (`DROPPED`) and a single enclosing folder.

    Raises
    ------
    ArchiveRefused
        The archive breaks a rule; the text is for the user.
    """
    read = members_of_zip if name.lower().endswith((".zip", ".fmu")) else members_of_tar_gz
    names, files = Names(limits.archive_files), dict[str, bytes]()
    try:
        for member in read(data, size_max=limits.source_kib << 10):
            name_inside = member.name.removeprefix("./")  # as `tar -c .` writes
            if member.content is None and name_inside.rstrip("/") in {"", "."}:
                continue
            path = names.add(name_inside, is_folder=member.content is None)
            if member.content is not None and not _dropped(path):
                _refuse_nested(member)
                files[path] = member.content
    except NameRefused as reason:
        raise ArchiveRefused(str(reason)) from None
    if not files:
        raise ArchiveRefused("The archive contains no files.")
    return _without_wrapper(dict(sorted(files.items())))


def normal_form(files: Mapping[str, bytes], *, limits: Limits) -> bytes:
    """Return a zip archive that depends only on the paths and contents of the files."""
    target = io.BytesIO()
    with zipfile.ZipFile(target, "w", zipfile.ZIP_STORED) as archive:
        for path in sorted(files):
            entry = zipfile.ZipInfo(path, _DATE)
            entry.create_system, entry.external_attr = 3, 0o100644 << 16
            archive.writestr(entry, files[path])
    data = target.getvalue()
    if len(data) > limits.source_kib << 10:
        raise ArchiveRefused(_too_large(limits))
    return data


def of_folder(folder: Path, *, limits: Limits) -> bytes:
    """Return the files in a folder as `normal_form`, without what nobody would upload.

    That is `DROPPED` and hidden files and folders. Reads no more than an archive may have.

    Raises
    ------
    ArchiveRefused
        There are no files, or too many or too large ones.
    OSError
        A file cannot be read.
    """
    files, size = dict[str, bytes](), 0
    for path in _upload_of(folder):
        if len(files) == limits.archive_files:
            raise ArchiveRefused(f"The folder has more than {limits.archive_files} files.")
        size += path.stat().st_size
        if size > limits.source_kib << 10:
            raise ArchiveRefused(f"The folder is larger than {limits.source_kib / 1024:g} MiB.")
        files[path.relative_to(folder).as_posix()] = path.read_bytes()
    if not files:
        raise ArchiveRefused("The folder contains no files.")
    return normal_form(files, limits=limits)


def _upload_of(folder: Path) -> Iterator[Path]:
    for parent, folders, names in os.walk(folder):
        folders[:] = [name for name in folders if not _left_at_home(name)]
        paths = (Path(parent, name) for name in names if not _left_at_home(name))
        yield from (path for path in paths if path.is_file())


def _left_at_home(name: str) -> bool:
    return name.startswith(".") or name in DROPPED


def read_normal(data: bytes) -> dict[str, bytes]:
    """Return path -> content of an archive written by `normal_form`, which can be trusted."""
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        return {entry.filename: archive.read(entry) for entry in archive.infolist()}


def _too_large(limits: Limits) -> str:
    return f"The unpacked archive is larger than {limits.source_kib / 1024:g} MiB."


def _dropped(path: str) -> bool:
    return any(part in DROPPED for part in path.split("/"))


def _refuse_nested(member: Member) -> None:
    content = member.content or b""
    kind = next((name for magic, name in NESTED.items() if content.startswith(magic)), None)
    if content[_TAR_MAGIC] == b"ustar":
        kind = "tar"
    if kind is not None:
        raise ArchiveRefused(
            f"{member.shown} is a nested archive ({kind}). Unpack it first; store NumPy arrays as "
            ".npy instead of .npz."
        )


def _without_wrapper(files: dict[str, bytes]) -> dict[str, bytes]:
    """Return the files without a single folder that encloses all of them."""
    first = {path.partition("/")[0] for path in files}
    if len(first) > 1 or any("/" not in path for path in files):
        return files
    return {path.partition("/")[2]: content for path, content in files.items()}
