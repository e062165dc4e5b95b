"""Stages of an intervention: physical facts, in their order, and the credit that they give.

A stage counts only after those before it. Nothing that a program says is part of it.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seamark.sim.metrics.metric import Metric
from seamark.sim.numerics.arrays import Array, Flags
from seamark.sim.recording.telemetry import ARM_INDEX, INDEX, SEARCH_INDEX, WORK_INDEX, Rows

HELD = Metric("held", "Done", "", "higher", meaning="all stages reached, without a strike")
_COLUMNS = {**INDEX, **ARM_INDEX, **WORK_INDEX, **SEARCH_INDEX}


@dataclass(frozen=True, slots=True, kw_only=True)
class Stage:
    """A stage, and the credit of a level that got so far and no farther, from 0 to 1."""

    name: str
    label: str
    credit: float


@dataclass(frozen=True, slots=True)
class Progress:
    """How far a level got."""

    steps: tuple[int, ...]  # control step at which each stage was reached, as far as they were
    credit: float  # from 0 to 1

    def reached(self, number: int) -> bool:
        """Return whether a stage, numbered from 0, was reached."""
        return len(self.steps) > number


class Attempt:
    """The rows of a level, with columns by name."""

    def __init__(self, rows: Rows, dt: float) -> None:
        self.rows, self.dt = rows, dt

    def column(self, name: str) -> Array:
        """Return a column of the telemetry, (k,)."""
        column: Array = self.rows[:, _COLUMNS[name]]
        return column

    def steps(self, seconds: float) -> int:
        """Return how many control steps a time is, at least one."""
        return max(1, round(seconds / self.dt))


def first_run(holds: Flags, steps: int, start: int = 0) -> int | None:
    """Return the step at which something has held for as many steps in a row; None: never.

    Parameters
    ----------
    holds : (k,) of bool
    start : int
        Steps before it do not count.
    """
    enough = _lasting(holds[start:]) >= steps
    at = int(enough.argmax()) if len(enough) else 0
    return start + at if len(enough) and enough[at] else None


def longest_run(holds: Flags, start: int = 0) -> int:
    """Return for how many steps in a row something has held at most, from `start` on."""
    return int(_lasting(holds[start:]).max(initial=0))


def _lasting(holds: Flags) -> NDArray[np.intp]:
    """Return for each step for how many in a row something has held by then, (k,)."""
    numbers = np.arange(1, len(holds) + 1)
    since: NDArray[np.intp] = np.maximum.accumulate(np.where(holds, 0, numbers))
    return numbers - since
