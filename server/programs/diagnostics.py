"""What is wrong with a program, with the place of it: for the form, the API and `check`."""

from dataclasses import asdict, dataclass
from enum import StrEnum
from typing import Any


class Stage(StrEnum):
    """When a flaw showed."""

    READ = "read"  # in the text, without running anything
    COMPILE = "compile"
    START = "start"  # import and __init__, or the native program's start
    RUN = "run"  # reset and step, in a real simulation


@dataclass(frozen=True, slots=True, kw_only=True)
class Flaw:
    """One thing that is wrong, in a sentence that says what to do."""

    sentence: str
    stage: Stage = Stage.READ
    file: str | None = None
    line: int | None = None  # from 1
    column: int | None = None  # from 1
    warning: bool = False  # worth a look, but the program runs

    def to_json(self) -> dict[str, Any]:
        """Return it as the API shows it."""
        return asdict(self)

    def text(self) -> str:
        """Return one line for a terminal, as compilers write them."""
        place = ":".join(str(part) for part in (self.file, self.line, self.column) if part)
        kind = "warning: " if self.warning else ""
        return f"{place}: {kind}{self.sentence}" if place else f"{kind}{self.sentence}"
