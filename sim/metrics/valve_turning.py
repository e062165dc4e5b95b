"""Turning a valve: stages, and what an attempt costs.

Rotation counts while the arm bears on the handle from two sides, its tool is at the handle, and
nothing of the vehicle's hull touches handle or panel. So a handle that is spun by the hull, or
swept along by a hand that passes, gives nothing. What turns back counts always.
"""

import math

import numpy as np

from seamark.sim.metrics.attempts import (
    END,
    NEAR_S,
    REACH_M,
    START,
    STRIKE_N,
    STRUCK,
    StagedAttempt,
    stage_metrics,
)
from seamark.sim.metrics.metric import SUM, LevelMetric, MetricGroup
from seamark.sim.metrics.stages import Progress, Stage
from seamark.sim.numerics.arrays import Array
from seamark.sim.recording.telemetry import Rows

GRASP_M = 0.06  # [m] E: of the tool from the handle's middle, as far as jaws are open to each side
GOALS_DEG = (30.0, 90.0, 170.0)  # S, the last: success in WasserMan's RotateValve
HELD_S = 1.0  # [s] for which an angle must be held
ONE_SIDED = 0.95  # share of the arm's forces from which it turns the handle with one side

STAGES = (
    Stage(name="reached", label="Reached the handle", credit=0.05),
    Stage(name="touched", label="Touched it", credit=0.1),
    Stage(name="started", label="Turned by 30°", credit=0.25),
    Stage(name="halved", label="Turned by 90°", credit=0.5),
    Stage(name="completed", label="Turned by 170°", credit=1.0),
)
_TOUCHED = 2  # stages up to there


class Turning(StagedAttempt):
    """The rows of a level in which a valve is to be turned."""

    stages = STAGES

    def __init__(self, rows: Rows, dt: float) -> None:
        super().__init__(rows, dt)
        self.angle_deg = self._angle_deg()
        self.progress = self._progress()

    def _angle_deg(self) -> Array:
        """Return how far the handle was turned in the way that counts, (k,) [degrees]."""
        reach, hull = self.column("reach"), self.column("work_hull_n")
        turned = np.diff(self.column("workpiece_joint"), prepend=self.column("workpiece_joint")[:1])
        counts = self.touched & (reach <= GRASP_M) & (hull == 0.0) & self.from_two_sides(ONE_SIDED)
        turned[(turned > 0.0) & ~counts] = 0.0
        angle: Array = np.cumsum(turned) * (180.0 / math.pi)
        return angle

    def _progress(self) -> Progress:
        """Return how far the attempt got."""
        near = self.column("reach") <= REACH_M
        held = [(self.angle_deg >= goal, HELD_S) for goal in GOALS_DEG]
        goals = ((near, NEAR_S), (near & self.touched, self.dt), *held)
        reached = self.reach_in_order(goals)
        credit = STAGES[len(reached) - 1].credit if reached else 0.0
        if _TOUCHED <= len(reached) < len(STAGES):
            credit += self._beyond(reached)
        return Progress(tuple(reached), credit * (STRUCK if self.strikes else 1.0))

    def _beyond(self, reached: list[int]) -> float:
        """Return the credit for a part of the way to the next angle."""
        done = len(reached) - _TOUCHED
        start, goal = (0.0, *GOALS_DEG)[done], GOALS_DEG[done]
        share = (self.held_deg(reached[_TOUCHED - 1]) - start) / (goal - start)
        step = STAGES[len(reached)].credit - STAGES[len(reached) - 1].credit
        return step * min(max(share, 0.0), 1.0)

    def held_deg(self, start: int = 0) -> float:
        """Return the largest angle that was held for as long as it must be, from a step on."""
        window, angle = self.steps(HELD_S), self.angle_deg[start:]
        if len(angle) < window:
            return 0.0
        least = np.lib.stride_tricks.sliding_window_view(angle, window).min(axis=1)
        return float(least.max(initial=0.0))

    @property
    def strikes(self) -> int:
        """How often the arm struck valve or panel, or the hull anything."""
        return self.strikes_of(self.column("work_push_n"))


def reached(rows: Rows, dt: float) -> tuple[int, ...]:
    """Return the row at which each stage was reached, as far as they were."""
    return Turning(rows, dt).progress.steps


_OWN: tuple[LevelMetric[Turning], ...] = (
    *stage_metrics(STAGES),
    LevelMetric(
        name="turned_deg",
        label="Turned",
        unit="°",
        better="higher",
        meaning="largest angle that was held for 1 s; counted while the tool is at the handle, the "
        "arm bears on it from two sides, and the hull touches neither valve nor panel",
        formula="max over time of min over 1 s of the counted rotation",
        compute=lambda attempt: attempt.held_deg(),
    ),
    LevelMetric(
        name="strikes",
        label="Strikes",
        unit="",
        better="lower",
        meaning=f"pushes of the arm on the valve and blows of the hull of over {STRIKE_N:g} N",
        formula="how often max(work_push_n, contact_n) rises above it",
        compute=lambda attempt: float(attempt.strikes),
        over=SUM,
    ),
)
GROUP = MetricGroup("Valve", _OWN)
METRICS = (*START, *_OWN, *END)
