"""What a simulator child has to know to evaluate one run. No secret, no database, no broker."""

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Self

from sandbox.level import Level


@dataclass(frozen=True, slots=True, kw_only=True)
class Job:
    """One evaluation: `seeds[i]` is the seed of trial i."""

    benchmark: str
    config: dict[str, Any]
    seeds: tuple[int, ...]
    shown_seed: int | None  # None: the seeds are hidden
    controller: str
    program: Path | None = None  # the source's file; None: the built-in `controller`
    filename: str = ""  # as the user named it
    language: str = "python"

    def to_json(self) -> bytes:
        """Return the job as it travels."""
        values = asdict(self) | {"program": str(self.program) if self.program else None}
        return json.dumps(values).encode()

    @classmethod
    def from_json(cls, text: bytes) -> Self:
        """Read what `to_json` wrote."""
        values = json.loads(text)
        program = Path(values.pop("program")) if values["program"] else values.pop("program")
        return cls(program=program, seeds=tuple(values.pop("seeds")), **values)


@dataclass(frozen=True, slots=True)
class Place:
    """Where evaluations run on this host."""

    level: Level  # of isolation
    core: int | None  # simulator and box share it; None: not pinned
