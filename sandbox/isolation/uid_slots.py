"""A uid of its own for each box if the worker is root: the program owns nothing outside its box.

Started by root, bubblewrap keeps the host's uid 0 inside, whatever it displays; therefore the uid
is changed before bubblewrap starts. A slot is held by a file lock, which ends with its process.
"""

import fcntl
import os
import pwd
import stat
from pathlib import Path

from seamark.sandbox.outcome import SandboxBroken

FIRST_UID = 23400  # below the uids of containers (100000), above those of people
SLOTS = 128
FOLDER = Path("/run/seamark-slots")


class UidSlot:
    """A uid that no other box of this host is using."""

    def __init__(self) -> None:
        folder = os.open(_folder(), os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
        try:
            self.uid, self._lock = _free(folder)
        finally:
            os.close(folder)

    def release(self) -> None:
        """Release the uid."""
        if self._lock >= 0:
            os.close(self._lock)
            self._lock = -1


def _folder() -> Path:
    """Return the folder of the locks: accessible to root only, or others could take all slots."""
    FOLDER.mkdir(mode=0o700, exist_ok=True)
    status = FOLDER.lstat()
    if not stat.S_ISDIR(status.st_mode) or status.st_uid != 0 or status.st_mode & 0o077:
        raise SandboxBroken(f"{FOLDER} is not accessible to root only")
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
        if _is_an_account(uid):
            os.close(lock)
            continue
        return uid, lock
    raise SandboxBroken(f"all {SLOTS} uids for boxes are in use")


def _is_an_account(uid: int) -> bool:
    try:
        pwd.getpwuid(uid)
    except KeyError:
        return False
    return True
