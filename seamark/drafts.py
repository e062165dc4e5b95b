"""Files that are complete or not there: what was there stays until its successor is on the disk."""

from __future__ import annotations

import errno
import os
import secrets
import shutil
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO


@contextmanager
def draft_of(out: str | Path) -> Iterator[BinaryIO]:
    """Provide a file that takes the place of `out` at the end, and leaves no trace of a failure.

    A link stays a link, and a file keeps its permissions. What is no file, such as a pipe or
    /dev/stdout, gets the whole content at the end.

    Raises
    ------
    OSError
        `out` is a folder or may not be written, or there is no room.
    """
    target = Path(os.path.realpath(out))
    mode = target.stat().st_mode if target.exists() else None
    if mode is not None and not (stat.S_ISREG(mode) or stat.S_ISDIR(mode)):
        with _copied_to(Path(out)) as file:
            yield file
        return
    _check(target, mode)
    draft = target.with_name(f".{secrets.token_hex(8)}.part")
    try:
        with draft.open("w+b") as file:
            yield file
            file.flush()
            os.fsync(file.fileno())  # else a crash could leave an empty file in place of the old
        if mode is not None:
            draft.chmod(stat.S_IMODE(mode))
        os.replace(draft, target)
    finally:
        draft.unlink(missing_ok=True)
    sync_folder(target.parent)


def replace_file(out: Path, content: bytes) -> None:
    """Have this content in a file, or leave the file as it is; raises OSError."""
    with draft_of(out) as file:
        file.write(content)


def sync_folder(folder: Path) -> None:
    """Have the names in a folder on the disk, where the system can do that."""
    with suppress(OSError):  # Windows opens no folders
        opened = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(opened)
        finally:
            os.close(opened)


def _check(target: Path, mode: int | None) -> None:
    """Refuse what opening the file for writing would refuse: a replacement would not."""
    if mode is None:
        return
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(target))
    if not os.access(target, os.W_OK):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(target))


@contextmanager
def _copied_to(out: Path) -> Iterator[BinaryIO]:
    with tempfile.TemporaryFile() as whole:
        yield whole
        whole.seek(0)
        with out.open("wb") as file:
            shutil.copyfileobj(whole, file)
