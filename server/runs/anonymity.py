"""What everybody sees in place of who has published a run for review."""

from pathlib import PurePath

NAME = "Anonymous author"  # no account can have it: names have no spaces

_SUFFIXES = frozenset((".py", ".c", ".cpp", ".m", ".fmu", ".zip", ".gz", ".tar", ".tgz"))


def file_name(name: str | None) -> str | None:
    """Return the name of a program without what its author called it."""
    if name is None:
        return None
    suffix = PurePath(name).suffix
    return f"program{suffix}" if suffix in _SUFFIXES else "program"
