"""The processes that a test has started and not ended."""

import os

from seamark.sandbox.isolation.proc_stats import parent_of, tree


def children() -> list[int]:
    """Return the children of this process; those of its database server come and go by themselves.

    An orphan below a child that ended is no descendant any more, so a deeper look finds no more.
    """
    return sorted(pid for pid in tree(os.getpid()) if parent_of(pid) == os.getpid())
