"""The processes that a test has started."""

import os
from pathlib import Path

from seamark.sandbox.isolation.proc_stats import parent_of, tree


def children() -> list[int]:
    """Return the children of this process; those of its database server come and go by themselves.

    Orphans of a child that ended are no descendants of this process, so that it suffices.
    """
    return sorted(pid for pid in tree(os.getpid()) if parent_of(pid) == os.getpid())


def command_line(pid: int) -> bytes:
    """Return the arguments of a process, each ended by NUL; empty if it is gone."""
    try:
        return Path(f"/proc/{pid}/cmdline").read_bytes()
    except OSError:
        return b""
