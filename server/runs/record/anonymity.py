"""What everybody sees in place of who has published a run for review."""

from pathlib import PurePath
from typing import Any

from seamark.programs import archives
from seamark.sandbox.languages import language_of

NAME = "Anonymous author"  # no account can have it: names have no spaces


def file_name(name: str | None) -> str | None:
    """Return the name of a program without what its author called it."""
    if name is None:
        return None
    suffix = PurePath(name).suffix
    known = language_of(name) is not None or archives.is_archive(name)
    return f"program{suffix}" if known else "program"


def replaced(value: Any, name: str, by: str) -> Any:
    """Return a text, or a list of texts, with another name of the program."""
    if isinstance(value, list):
        return [replaced(item, name, by) for item in value]
    return value.replace(name, by) if name and isinstance(value, str) else value
