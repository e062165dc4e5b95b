"""Copies of the files that boxes need but their uid cannot read, made once.

The uid of a box cannot enter a checkout under a home of mode 0700, and bubblewrap resolves even an
open descriptor by its path. The boxes of a plain user run under that user's uid: nothing to copy.
"""

import fcntl
import hashlib
import os
import shutil
import stat
from functools import cache
from pathlib import Path

from seamark.sandbox.outcome import SandboxBroken

COPIES = Path("/var/cache/seamark")  # owned by root, readable by all
NOT_COPIED = shutil.ignore_patterns("tests", "test", "idlelib", "turtledemo", "site-packages")


@cache
def readable_by_all(source: Path) -> Path:
    """Return a path with the same content that every uid can read."""
    if os.geteuid() != 0 or reachable(source):
        return source
    target = _folder() / _key(source)
    with (COPIES / "lock").open("w") as lock:  # several workers may start at once
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not target.exists():
            _copy(source, target)
    return target


def reachable(path: Path) -> bool:
    """Return whether all users may enter the folders above and read the file or folder itself."""
    inside = path / "__init__.py" if (path / "__init__.py").exists() else path
    above = all(folder.stat().st_mode & stat.S_IXOTH for folder in inside.resolve().parents)
    return above and bool(inside.stat().st_mode & stat.S_IROTH)


def _folder() -> Path:
    """Return the folder of the copies; SandboxBroken if others may write to it."""
    COPIES.mkdir(mode=0o755, parents=True, exist_ok=True)
    status = COPIES.lstat()
    if not stat.S_ISDIR(status.st_mode) or status.st_uid != 0 or status.st_mode & 0o022:
        raise SandboxBroken(f"{COPIES} is not a folder that only root may write to")
    COPIES.chmod(0o755)
    return COPIES


def _key(source: Path) -> str:
    """Return a name that changes with the path and with what is installed there."""
    files = [source, *sorted(source.glob("*.py")), *sorted(source.glob("*.so*"))]
    text = "\n".join(f"{file} {file.stat().st_mtime_ns} {file.stat().st_size}" for file in files)
    return f"{source.name}-{hashlib.sha256(text.encode()).hexdigest()[:16]}"


def _copy(source: Path, target: Path) -> None:
    """Copy under another name first, so that an incomplete copy is never used."""
    partial = target.with_name(target.name + ".partial")
    shutil.rmtree(partial, ignore_errors=True)
    if source.is_dir():
        shutil.copytree(source, partial, ignore=NOT_COPIED, ignore_dangling_symlinks=True)
    else:
        shutil.copy(source, partial)
    for path in (partial, *partial.rglob("*")):
        path.chmod(0o755 if path.is_dir() or os.access(path, os.X_OK) else 0o644)
    partial.rename(target)
