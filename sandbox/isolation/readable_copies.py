"""Copies of what boxes need where their uid cannot reach the original, made once.

A checkout under a home of mode 0700 cannot be entered by the uid of a box, and bubblewrap resolves
even an open descriptor by its path. Plain users' boxes run under their own uid: nothing to copy.
"""

import fcntl
import hashlib
import os
import shutil
import stat
from pathlib import Path

from seamark.sandbox.outcome import SandboxBroken

SHELF = Path("/var/cache/seamark")  # root's; everybody may read
LEFT_OUT = shutil.ignore_patterns("tests", "test", "idlelib", "turtledemo", "site-packages")


def shelved(source: Path) -> Path:
    """Return a path with the same content that every uid can read."""
    if os.geteuid() != 0 or reachable(source):
        return source
    target = _shelf() / _key(source)
    with (SHELF / "lock").open("w") as lock:  # several workers may start at once
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not target.exists():
            _copy(source, target)
    return target


def reachable(path: Path) -> bool:
    """Tell whether others may enter every folder above and read the file or folder itself."""
    inside = path / "__init__.py" if (path / "__init__.py").exists() else path
    above = all(folder.stat().st_mode & stat.S_IXOTH for folder in inside.resolve().parents)
    return above and bool(inside.stat().st_mode & stat.S_IROTH)


def _shelf() -> Path:
    """Return the folder of the copies; SandboxBroken if others could write into it."""
    SHELF.mkdir(mode=0o755, parents=True, exist_ok=True)
    status = SHELF.lstat()
    if not stat.S_ISDIR(status.st_mode) or status.st_uid != 0 or status.st_mode & 0o022:
        raise SandboxBroken(f"{SHELF} is not a folder that root alone may write")
    SHELF.chmod(0o755)
    return SHELF


def _key(source: Path) -> str:
    """Return a name that changes with the path and with what was installed there."""
    marks = [source, *sorted(source.glob("*.py")), *sorted(source.glob("*.so*"))]
    text = "\n".join(f"{mark} {mark.stat().st_mtime_ns} {mark.stat().st_size}" for mark in marks)
    return f"{source.name}-{hashlib.sha256(text.encode()).hexdigest()[:16]}"


def _copy(source: Path, target: Path) -> None:
    """Copy under another name first, so that half a copy is never used."""
    partial = target.with_name(target.name + ".partial")
    shutil.rmtree(partial, ignore_errors=True)
    if source.is_dir():
        shutil.copytree(source, partial, ignore=LEFT_OUT)
    else:
        shutil.copy(source, partial)
    for path in (partial, *partial.rglob("*")):
        path.chmod(0o755 if path.is_dir() or os.access(path, os.X_OK) else 0o644)
    partial.rename(target)
