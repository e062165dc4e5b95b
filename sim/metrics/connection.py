"""Plugging a connector: stages, and what an attempt costs.

The connector starts with its tip on the face of a panel and its axis across that, and the mouth of
the receptacle is on the face, too, on the vertical through the world's origin. So the first row
tells the axis of the bore, however the panel is tilted, and the others how deep the tip is along
it. It is held while the arm bears on it from two sides, its handle is in the hand, and nothing of
the vehicle's hull touches it. Up to the half, depth counts as far as it was gained while the
connector was held; what comes out again counts always. So one that is dropped or thrown, or pressed
down from above, gives nothing.
"""

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
from seamark.sim.numerics.arrays import Array, Flags
from seamark.sim.numerics.elementwise import sincos
from seamark.sim.recording.telemetry import Rows

TIP_M = 0.19  # [m] of the connector below the middle of its handle, as its file has it
CLEAR_M = 0.08  # [m] of the tip above the panel's face: out of the parking place
MOUTH_M = 0.045  # [m] of the tip's middle from the axis of the receptacle, and above its face
GRASP_M = 0.1  # [m] E: of the tool from the handle's middle, as far as jaws reach along and across
HALF_M, SEATED_M = 0.045, 0.08  # [m] of the tip below the face; the hole is 90 mm deep
HOLDS_S = 0.25  # [s] for which what a stage asks for must last
STAYS_S = 1.0  # [s] for which a seated connector must stay without the hand
AWAY_M, AWAY_S = 0.3, 3.0  # [m] of the tool from the handle; [s] for which it must be away
ONE_SIDED = 0.8  # share of the arm's forces from which one side pushes, and no hand grips

STAGES = (
    Stage(name="reached", label="Reached the handle", credit=0.05),
    Stage(name="touched", label="Touched the connector", credit=0.1),
    Stage(name="unparked", label="Taken from its parking place", credit=0.25),
    Stage(name="entered", label="Tip at the mouth", credit=0.4),
    Stage(name="halfway", label="Inserted by half", credit=0.55),
    Stage(name="seated", label="Seated", credit=0.75),
    Stage(name="released", label="Released, and stays", credit=0.9),
    Stage(name="completed", label="Withdrawn", credit=1.0),
)


class Connection(StagedAttempt):
    """The rows of a level in which a connector is to be plugged."""

    stages = STAGES

    def __init__(self, rows: Rows, dt: float) -> None:
        super().__init__(rows, dt)
        self.held = self._held()
        self.depth_m, self.off_m = self._tip()
        self.inserted_m = self._inserted()
        self.progress = self._progress()

    def _held(self) -> Flags:
        """Return whether the hand, and no hull, holds the connector, (k,)."""
        near, hull = self.column("reach") <= GRASP_M, self.column("work_hull_n")
        flags: Flags = self.touched & near & (hull == 0.0) & self.from_two_sides(ONE_SIDED)
        return flags

    def _tip(self) -> tuple[Array, Array]:
        """Return how far the tip is below the face, and from the receptacle's axis, (k,) [m]."""
        x, y, z = (self.column(f"workpiece_{axis}") for axis in "xyz")
        (sr, cr), (sp, cp), (sy, cy) = (
            sincos(self.column(f"workpiece_{angle}")) for angle in ("roll", "pitch", "yaw")
        )
        along = np.stack([cr * sp * cy + sr * sy, cr * sp * sy - sr * cy, cr * cp])
        tip, (north, east, down) = np.stack([x, y, z]) + TIP_M * along, along[:, 0]
        level, below = tip[0] * north + tip[1] * east, tip[2] - tip[2, 0]
        depth = level - level[0] + down * below
        # From the mouth, which is on the face where that crosses the vertical at the origin.
        below_mouth = below - level[0] / down
        across = np.stack(
            [
                east * below_mouth - down * tip[1],
                down * tip[0] - north * below_mouth,
                north * tip[1] - east * tip[0],
            ]
        )
        return depth, np.sqrt((across * across).sum(axis=0))

    def _inserted(self) -> Array:
        """Return how deep the tip was brought into the receptacle by the hand, (k,) [m]."""
        inside = np.where(self.off_m <= MOUTH_M, np.maximum(self.depth_m, 0.0), 0.0)
        gained = np.diff(inside, prepend=0.0)
        gained[(gained > 0.0) & ~self.held] = 0.0
        deep = np.zeros(len(gained))
        so_far = 0.0
        for step, gain in enumerate(gained.tolist()):
            so_far = deep[step] = max(so_far + gain, 0.0)
        return deep

    def _progress(self) -> Progress:
        """Return how far the attempt got."""
        free = self.column("work_rest_n") == 0.0
        seated = (self.depth_m >= SEATED_M) & (self.column("work_hull_n") == 0.0)
        alone = seated & (self.column("work_arm_n") == 0.0)
        goals = (
            (self.column("reach") <= REACH_M, NEAR_S),
            (self.touched & (self.column("reach") <= REACH_M), self.dt),
            (self.held & free & (self.depth_m <= -CLEAR_M), HOLDS_S),
            (self.held & (self.off_m <= MOUTH_M) & (self.depth_m >= -MOUTH_M), HOLDS_S),
            (self.held & (self.inserted_m >= HALF_M), HOLDS_S),
            (seated, HOLDS_S),
            (alone, STAYS_S),
            (alone & (self.column("reach") >= AWAY_M), AWAY_S),
        )
        reached = self.reach_in_order(goals)
        credit = STAGES[len(reached) - 1].credit if reached else 0.0
        return Progress(tuple(reached), credit * (STRUCK if self.strikes else 1.0))

    @property
    def strikes(self) -> int:
        """How often the hand struck something, or the hull anything."""
        force = np.stack([self.column(f"wrist_f{axis}") for axis in "xyz"])
        return self.strikes_of(np.sqrt((force * force).sum(axis=0)))


def reached(rows: Rows, dt: float) -> tuple[int, ...]:
    """Return the row at which each stage was reached, as far as they were."""
    return Connection(rows, dt).progress.steps


_OWN: tuple[LevelMetric[Connection], ...] = (
    *stage_metrics(STAGES),
    LevelMetric(
        name="inserted_mm",
        label="Inserted",
        unit="mm",
        better="higher",
        meaning="largest depth of the tip in the receptacle, as far as the hand that held the "
        "connector brought it there",
        formula="max over time of the counted depth",
        compute=lambda attempt: 1000.0 * float(attempt.inserted_m.max(initial=0.0)),
    ),
    LevelMetric(
        name="hard_contacts",
        label="Strikes",
        unit="",
        better="lower",
        meaning=f"forces through the wrist, and blows of the hull, of over {STRIKE_N:g} N",
        formula="how often the magnitude of wrist_f, or contact_n, rises above it",
        compute=lambda attempt: float(attempt.strikes),
        over=SUM,
    ),
)
GROUP = MetricGroup("Connector", _OWN)
METRICS = (*START, *_OWN, *END)
