"""What a simulator child has to know to evaluate one run. No secret, no database, no broker."""

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Self

from seamark.sandbox.isolation.level import IsolationLevel
from seamark.worker.evaluation.cores import NO_LOCKS, Cores


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
    check: bool = False  # two simulated seconds only (worker/evaluation/check.py)

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

    isolation: IsolationLevel
    core: int | None  # where simulator and box of a single trial are; None: not pinned
    share: tuple[int, ...] = ()  # cores on which the trials of one run may be side by side
    locks: int = NO_LOCKS  # descriptor of what says which of them are in use
    warm: tuple[str, ...] = ()  # languages of which boxes wait between runs
    warm_boxes: int = 0  # of each

    def cores(self) -> Cores:
        """Return the cores of one run."""
        return Cores(self.core, self.share, locks=self.locks)

    def cores_for(self, trials: int) -> Cores | None:
        """Return the cores for trials side by side; None if they come one after the other."""
        return self.cores() if min(trials, self.cores().count) > 1 else None

    def descriptors(self) -> tuple[int, ...]:
        """Return what a process that works here has to inherit."""
        return () if self.locks == NO_LOCKS else (self.locks,)

    def to_text(self) -> str:
        """Return the place as it travels; the descriptor keeps its number."""
        return json.dumps(asdict(self) | {"isolation": self.isolation.name})

    @classmethod
    def from_text(cls, text: str) -> Self:
        """Read what `to_text` wrote."""
        values = json.loads(text)
        share, warm = tuple(values.pop("share")), tuple(values.pop("warm"))
        return cls(
            isolation=IsolationLevel[values.pop("isolation")], share=share, warm=warm, **values
        )
