"""What a simulator child needs to know to evaluate one run. No secret, no database, no broker."""

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Self

from seamark.sandbox.languages import DEFAULT_LANGUAGE


@dataclass(frozen=True, slots=True, kw_only=True)
class Job:
    """One evaluation: `seeds[i]` is the seed of trial i."""

    benchmark: str
    config: dict[str, Any]
    seeds: tuple[int, ...]
    ranked: bool = False  # False: one seed in all trials, chosen by the user
    controller: str
    program: Path | None = None  # file of the source; None: the built-in `controller`
    filename: str = ""  # as the user named it
    language: str = DEFAULT_LANGUAGE
    check: bool = False  # two simulated seconds only (see check.py)

    def to_json(self) -> bytes:
        """Return the job as a packet."""
        values = asdict(self) | {"program": str(self.program) if self.program else None}
        return json.dumps(values).encode()

    @classmethod
    def from_json(cls, packet: bytes) -> Self:
        """Return the job that `to_json` was given."""
        values = json.loads(packet)
        program = values.pop("program")
        return cls(
            program=Path(program) if program else None, seeds=tuple(values.pop("seeds")), **values
        )
