"""Recovering a box from the seabed: stages, and what an attempt costs.

The box counts as carried while nothing but the arm touches it: not the seabed, no stone, not the
vehicle's hull. So a push, a throw and a box on the hull give nothing.
"""

from seamark.sim.metrics.attempts import (
    END,
    NEAR_S,
    REACH_M,
    START,
    STRIKE_N,
    STRUCK,
    TOUCH_N,
    StagedAttempt,
    stage_metrics,
)
from seamark.sim.metrics.metric import MetricGroup
from seamark.sim.metrics.stages import Progress, Stage, longest_run
from seamark.sim.numerics.arrays import Flags
from seamark.sim.recording.telemetry import Rows

LIFT_M = 0.5  # [m] E: clear of the seabed, as of a hold-down before a vehicle leaves
HOLD_S = 10.0  # [s]
FREE_S = 0.5  # [s] for which the box must be carried before it counts

STAGES = (
    Stage(name="reached", label="Reached the handle", credit=0.05),
    Stage(name="touched", label="Touched the box", credit=0.1),
    Stage(name="taken", label="Taken off the seabed", credit=0.3),
    Stage(name="lifted", label="Lifted by 0.5 m", credit=0.6),
    Stage(name="completed", label="Held for 10 s", credit=1.0),
)


class Carrying(StagedAttempt):
    """The rows of a level in which a box is to be carried."""

    def __init__(self, rows: Rows, dt: float) -> None:
        super().__init__(rows, dt)
        self.carried = self.is_carried("work")
        depth = self.column("workpiece_z")
        self.lift_m = depth[0] - depth

    def is_carried(self, what: str) -> Flags:
        """Return whether nothing but the arm touches a thing, (k,): "work", or another one."""
        arm, hull, rest = (self.column(f"{what}_{who}_n") for who in ("arm", "hull", "rest"))
        flags: Flags = (arm > TOUCH_N) & (hull == 0.0) & (rest == 0.0)
        return flags

    def struck(self, taken: int | None) -> bool:
        """Return whether the hull struck something, or the arm the box before it was carried.

        `taken` is the step by which it had been carried for `FREE_S`; None: it was not.
        """
        before = len(self.rows) if taken is None else taken - self.steps(FREE_S) + 1
        blow = float(self.column("work_push_n")[:before].max(initial=0.0))
        return max(blow, self.hull_peak_n) > STRIKE_N


class Recovery(Carrying):
    """The rows of a level in which a box is to be recovered."""

    stages = STAGES

    def __init__(self, rows: Rows, dt: float) -> None:
        super().__init__(rows, dt)
        self.progress = self._progress()

    def _progress(self) -> Progress:
        """Return how far the attempt got."""
        high = self.carried & (self.lift_m >= LIFT_M)
        goals = (
            (self.column("reach") <= REACH_M, NEAR_S),
            (self.touched, self.dt),
            (self.carried, FREE_S),
            (high, FREE_S),
            (high, HOLD_S),
        )
        reached = self.reach_in_order(goals)
        credit = STAGES[len(reached) - 1].credit if reached else 0.0
        if len(reached) == 4:  # a part of the time for which it should be held counts in part
            # By the time that it counts as lifted, it has been held for `FREE_S`.
            share = min(longest_run(high, reached[2]) / self.steps(HOLD_S), 1.0)
            credit += share * (STAGES[4].credit - STAGES[3].credit)
        struck = self.struck(reached[2] if len(reached) > 2 else None)
        return Progress(tuple(reached), credit * (STRUCK if struck else 1.0))


def reached(rows: Rows, dt: float) -> tuple[int, ...]:
    """Return the row at which each stage was reached, as far as they were."""
    return Recovery(rows, dt).progress.steps


GROUP = MetricGroup("Recovery", stage_metrics(STAGES))
METRICS = (*START, *GROUP.metrics, *END)
