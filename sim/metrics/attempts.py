"""What every intervention is measured by: credit and stages, time, forces and energy."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from seamark.sim.metrics.energy import ENERGY
from seamark.sim.metrics.metric import MAX, LevelMetric, MetricGroup
from seamark.sim.metrics.stages import Attempt, Progress, Stage, first_run
from seamark.sim.numerics.arrays import Array, Flags
from seamark.sim.recording.telemetry import Rows, thrusts

REACH_M = 0.1  # [m] E: half of a handle's length and the width of a hand
NEAR_S = 1.0  # [s] for which the tool must be so near: nothing that drifts past
TOUCH_N = 1.0  # [N]
STRIKE_N = 250.0  # [N] E: over a control step; 200 kg that stop from 6 cm/s
STRUCK = 0.5  # credit that is left after a strike
SIDES_S = 0.5  # over which a hand must bear on the work from two sides


class StagedAttempt(Attempt):
    """The rows of a level in which work has stages."""

    stages: tuple[Stage, ...]
    progress: Progress

    def __init__(self, rows: Rows, dt: float) -> None:
        super().__init__(rows, dt)
        self.touched = self.column("work_arm_n") > TOUCH_N

    def reached(self, name: str) -> bool:
        """Return whether the stage of this name was reached."""
        number = [stage.name for stage in self.stages].index(name)
        return self.progress.reached(number)

    def reach_in_order(self, goals: Iterable[tuple[Flags, float]]) -> list[int]:
        """Return the step at which each stage was reached, as far as they were.

        `goals` are those of the stages: what must hold, (k,), and for how long [s].
        """
        reached: list[int] = []
        for holds, seconds in goals:
            at = first_run(holds, self.steps(seconds), reached[-1] if reached else 0)
            if at is None:
                break
            reached.append(at)
        return reached

    def from_two_sides(self, share: float) -> Flags:
        """Return whether the arm bears on the work from two sides, (k,).

        Over `SIDES_S`, its net force is then at most this share of the sum of its contact forces:
        it is all of it for a hand that pushes with one side, and nothing for a pure couple.
        """
        net, whole = (self._lately(self.column(name)) for name in ("work_push_n", "work_arm_n"))
        flags: Flags = net <= share * whole
        return flags

    def _lately(self, values: Array) -> Array:
        """Return the sum of the last values of `SIDES_S`, (k,)."""
        steps, total = self.steps(SIDES_S), np.cumsum(values)
        total[steps:] -= total[:-steps].copy()
        return total

    def strikes_of(self, force: Array) -> int:
        """Return how often this force, (k,) [N], or that on the hull rises above `STRIKE_N`."""
        blow = np.maximum(force, self.column("contact_n")) > STRIKE_N
        return int(np.count_nonzero(np.diff(blow.astype(np.int8), prepend=0) > 0))

    @property
    def hull_peak_n(self) -> float:
        """Largest contact force on the hull [N]."""
        return float(self.column("contact_n").max(initial=0.0))

    @property
    def time_s(self) -> float:
        """Time to the last stage; the whole level, if it was not reached [s]."""
        steps = self.progress.steps
        whole = len(steps) == len(self.stages)
        return (steps[-1] if whole else len(self.rows)) * self.dt

    @property
    def thrust(self) -> Array:
        """Thrust of each thruster, (k, n) [N]."""
        return thrusts(self.rows)


def stage_metric(name: str, label: str) -> LevelMetric[StagedAttempt]:
    """Return whether the stage of this name was reached."""
    return LevelMetric(
        name=name,
        label=label,
        unit="",
        better="higher",
        meaning="1 if this stage was reached",
        formula="1 or 0",
        compute=lambda attempt: float(attempt.reached(name)),
    )


def stage_metrics(stages: Sequence[Stage]) -> tuple[LevelMetric[Any], ...]:
    """Return for each stage between the touch and the last whether it was reached."""
    return tuple(
        stage_metric(stage.name, stage.label)
        for number, stage in enumerate(stages)
        if _TOUCHED < number < len(stages) - 1
    )


_TOUCHED = 1  # number of the stage
CREDIT: LevelMetric[Any] = LevelMetric(
    name="credit",
    label="Credit",
    unit="",
    better="higher",
    meaning="of the last stage that was reached, and a part of the next one's for a part of "
    "the way; half of it after a strike",
    formula="see the benchmark's stages",
    compute=lambda attempt: attempt.progress.credit,
)
REACHED = stage_metric("reached", "Reached the handle")
START: tuple[LevelMetric[Any], ...] = (CREDIT, REACHED, stage_metric("touched", "Touched it"))
END: tuple[LevelMetric[Any], ...] = (
    stage_metric("completed", "Completed"),
    LevelMetric(
        name="time_s",
        label="Time to completion",
        unit="s",
        better="lower",
        meaning="the whole level, if it was not completed",
        formula="time at which the last stage was reached",
        compute=lambda attempt: attempt.time_s,
    ),
    LevelMetric(
        name="push_n",
        label="Largest push of the arm",
        unit="N",
        better="lower",
        formula="max work_push_n",
        compute=lambda attempt: float(attempt.column("work_push_n").max(initial=0.0)),
        over=MAX,
    ),
    LevelMetric(
        name="hull_n",
        label="Hardest blow of the hull",
        unit="N",
        better="lower",
        formula="max contact_n",
        compute=lambda attempt: attempt.hull_peak_n,
        over=MAX,
    ),
    ENERGY,
)
GROUP = MetricGroup(  # the energy is with the metrics of position controllers
    "Interventions", tuple(metric for metric in (*START, *END) if metric is not ENERGY)
)
