"""Diagnostics of a program, as the form, the API and `seamark check` show them."""

from dataclasses import asdict, dataclass
from enum import StrEnum
from typing import Any

from seamark.sandbox.printable_text import printable_text


class Stage(StrEnum):
    """When the problem was found."""

    READ = "read"  # in the source, without running anything
    COMPILE = "compile"
    START = "start"  # import and __init__, or the start of a native program
    RUN = "run"  # reset and step, in a real simulation


@dataclass(frozen=True, slots=True, kw_only=True)
class Diagnostic:
    """One problem of a program: where it is, and a sentence that says how to fix it."""

    sentence: str
    stage: Stage = Stage.READ
    file: str | None = None
    line: int | None = None  # from 1
    column: int | None = None  # from 1
    warning: bool = False  # the program runs nevertheless

    def to_json(self) -> dict[str, Any]:
        """Return the JSON object of the API."""
        return asdict(self)

    def text(self) -> str:
        """Return one line for a terminal, in the format of compilers."""
        location = ":".join(str(part) for part in (self.file, self.line, self.column) if part)
        message = f"warning: {self.sentence}" if self.warning else self.sentence
        return printable_text(f"{location}: {message}" if location else message)
