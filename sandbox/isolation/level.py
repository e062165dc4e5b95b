"""How strongly programs are isolated from the host."""

from enum import IntEnum


class IsolationLevel(IntEnum):
    """How strongly a program is isolated."""

    NONE = 0  # nothing: uploads are refused
    MEDIUM = 2  # namespaces, seccomp, limits per process
    STRONG = 3  # also limits for the whole box (cgroups) and a uid that owns nothing else
