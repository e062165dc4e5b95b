"""What a comparison needs of a run: the view of one on a server has it, and a local result."""

from collections.abc import Callable, Mapping
from typing import Any, Protocol

from seamark.server.runs.record.seeds import Seeded
from seamark.server.runs.record.solutions import HasSolution


class ComparedRun(Seeded, HasSolution, Protocol):
    """A run that is compared with others."""

    @property
    def id(self) -> int:
        """Its number."""

    @property
    def kind(self) -> str:
        """Practice or ranked."""

    @property
    def state(self) -> str:
        """How far it is."""

    @property
    def trials(self) -> int:
        """The number of trials."""

    @property
    def score(self) -> float | None:
        """The score; None before the end, and if it failed."""

    @property
    def metrics(self) -> Mapping[str, Any] | None:
        """What metrics.json has; None without a score."""


SeedsOf = Callable[[ComparedRun], Callable[[int], int]]  # run -> trial -> seed
