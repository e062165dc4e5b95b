"""A mission: find the right box, recover it, and bring it to where the vehicle started.

The box counts as carried as in `recovery`. Nothing that a program says is part of a stage: it has
found the box when its hand is above it or nearly so, which has the box in view of its camera, and
recognised it when the hand stays there. The wrong box, once carried, counts against it.
"""

from typing import Any

import numpy as np

from seamark.sim.metrics import recovery
from seamark.sim.metrics.attempts import (
    CREDIT,
    END,
    NEAR_S,
    REACH_M,
    REACHED,
    STRUCK,
    stage_metric,
)
from seamark.sim.metrics.metric import LevelMetric, MetricGroup
from seamark.sim.metrics.recovery import FREE_S, LIFT_M, Carrying
from seamark.sim.metrics.stages import Progress, Stage, first_run
from seamark.sim.numerics.arrays import Array
from seamark.sim.recording.telemetry import Rows

# From the tool to the box, level. E: so the box is in view from the height of the search.
FOUND_M, FOUND_S = 1.0, 1.0
ABOVE_M, ABOVE_S = 0.6, 6.0  # E: longer than a passage takes at 0.2 m/s
MARK_M, MARK_S = 1.5, 2.0  # E: the buoy above the start, and for how long the box must be there
WRONG = 0.3  # credit that carrying the wrong box costs, E: as much as coming to the right one gives

STAGES = (
    Stage(name="found", label="Found the box", credit=0.1),
    Stage(name="recognised", label="Held station above it", credit=0.2),
    Stage(name="reached", label="Reached the handle", credit=0.3),
    Stage(name="taken", label="Taken off the seabed", credit=0.5),
    Stage(name="lifted", label="Lifted by 0.5 m", credit=0.7),
    Stage(name="completed", label="Brought to the start", credit=1.0),
)
FOUND, TAKEN, LIFTED = 0, 3, 4  # numbers of stages


class Mission(Carrying):
    """The rows of a level in which a box is to be found and brought back."""

    stages = STAGES

    def __init__(self, rows: Rows, dt: float) -> None:
        super().__init__(rows, dt)
        north, east = (self.column(f"workpiece_{axis}") for axis in "xy")
        start_x, start_y = self.column("x")[0], self.column("y")[0]
        tool_x, tool_y = self.column("tool_x"), self.column("tool_y")
        self.off_m: Array = np.sqrt((north - tool_x) ** 2 + (east - tool_y) ** 2)
        self.home_m: Array = np.sqrt((north - start_x) ** 2 + (east - start_y) ** 2)
        self.wrong = first_run(self.is_carried("decoy"), self.steps(FREE_S)) is not None
        self.progress = self._progress()

    @property
    def search_s(self) -> float:
        """Time until the box was found; the whole level, if it was not [s]."""
        steps = self.progress.steps
        return (steps[FOUND] if steps else len(self.rows)) * self.dt

    def _progress(self) -> Progress:
        """Return how far the mission got."""
        high = self.carried & (self.lift_m >= LIFT_M)
        goals = (
            (self.off_m <= FOUND_M, FOUND_S),
            (self.off_m <= ABOVE_M, ABOVE_S),
            (self.column("reach") <= REACH_M, NEAR_S),
            (self.carried, FREE_S),
            (high, FREE_S),
            (high & (self.home_m <= MARK_M), MARK_S),
        )
        reached = self.reach_in_order(goals)
        credit = STAGES[len(reached) - 1].credit if reached else 0.0
        if len(reached) == LIFTED + 1:
            credit += self._share_of_the_way(reached[LIFTED]) * (
                STAGES[LIFTED + 1].credit - STAGES[LIFTED].credit
            )
        if self.struck(reached[TAKEN] if len(reached) > TAKEN else None):
            credit *= STRUCK
        return Progress(tuple(reached), credit - (WRONG if self.wrong else 0.0))

    def _share_of_the_way(self, lifted: int) -> float:
        """Return how much of the way home the box was carried, from 0 to 1."""
        way = self.home_m[lifted:][self.carried[lifted:]]
        left = float(way.min(initial=self.home_m[lifted]))
        whole = float(self.home_m[lifted]) - MARK_M
        gone = float(self.home_m[lifted]) - left
        return min(max(gone / whole, 0.0), 1.0) if whole > 0.0 else 0.0


def reached(rows: Rows, dt: float) -> tuple[int, ...]:
    """Return the row at which each stage was reached, as far as they were."""
    return Mission(rows, dt).progress.steps


SEARCH_METRICS: tuple[LevelMetric[Any], ...] = (
    *(stage_metric(stage.name, stage.label) for stage in STAGES[: FOUND + 2]),
    LevelMetric(
        name="search_s",
        label="Time to find it",
        unit="s",
        better="lower",
        meaning="the whole level, if it was not found",
        formula="time at which the first stage was reached",
        compute=lambda attempt: attempt.search_s,
    ),
    LevelMetric(
        name="wrong",
        label="Wrong box",
        unit="",
        better="lower",
        meaning=f"1 if the wrong box was carried for {FREE_S:g} s, which costs {WRONG:g} credit",
        formula="1 or 0",
        compute=lambda attempt: float(attempt.wrong),
    ),
)
GROUP = MetricGroup("Missions", SEARCH_METRICS)
METRICS = (CREDIT, *SEARCH_METRICS, REACHED, *recovery.GROUP.metrics, *END)
