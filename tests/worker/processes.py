"""The processes that a test has started and not ended."""

import os

from seamark.sandbox.isolation.proc_stats import parent_of, tree


def children() -> list[int]:
    """Return the children of this process; those of its database server come and go by themselves.

    Orphans of a child that ended are no descendants of this process, so that it suffices.
    """
    return sorted(pid for pid in tree(os.getpid()) if parent_of(pid) == os.getpid())
