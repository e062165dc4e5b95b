"""One uid per box when the worker is root: a program then owns nothing outside its box.

bubblewrap started by root keeps the host's uid 0 inside, whatever it shows; so the uid changes
before bubblewrap starts. A slot is held by a lock on a file, which ends with its process.
"""

import fcntl
import os
import pwd
import stat
from pathlib import Path

from seamark.sandbox.outcome import SandboxBroken

FIRST_UID = 23400  # below the ranges of containers (100000), above those of people
SLOTS = 128
FOLDER = Path("/run/seamark-slots")


class Slot:
    """A uid that no other box of this host uses now."""

    def __init__(self) -> None:
        folder = os.open(_folder(), os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
        try:
            self.uid, self._lock = _free(folder)
        finally:
            os.close(folder)

    def release(self) -> None:
        """Give the uid back."""
        if self._lock >= 0:
            os.close(self._lock)
            self._lock = -1


def _folder() -> Path:
    """Return the folder of the locks: root's alone, or others could hold all slots."""
    FOLDER.mkdir(mode=0o700, exist_ok=True)
    status = FOLDER.lstat()
    if not stat.S_ISDIR(status.st_mode) or status.st_uid != 0 or status.st_mode & 0o077:
        raise SandboxBroken(f"{FOLDER} is not a folder of root alone")
    return FOLDER


def _free(folder: int) -> tuple[int, int]:
    for uid in range(FIRST_UID, FIRST_UID + SLOTS):
        flags = os.O_RDWR | os.O_CREAT | os.O_CLOEXEC | os.O_NOFOLLOW
        lock = os.open(str(uid), flags, 0o600, dir_fd=folder)
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(lock)
            continue
        if _belongs_to_somebody(uid):
            os.close(lock)
            continue
        return uid, lock
    raise SandboxBroken(f"all {SLOTS} uids for boxes are in use")


def _belongs_to_somebody(uid: int) -> bool:
    try:
        pwd.getpwuid(uid)
    except KeyError:
        return False
    return True
