"""Entering a dock: stages, time, approaches, strikes and the peak force.

In the formulas f is the contact force on the hull [N], a mean over a control step, until the
vehicle is docked, and f_s the force of a strike: that which stops the vehicle, with the water that
moves with it ahead, from `STRIKE_M_S` within a control step.
"""

from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np

from seamark.sim.metrics.energy import ENERGY
from seamark.sim.metrics.metric import MAX, SUM, LevelMetric, Metric, MetricGroup
from seamark.sim.metrics.stages import Attempt, Stage, first_run
from seamark.sim.numerics.arrays import Array, Flags
from seamark.sim.recording.telemetry import DOCK_INDEX, INDEX, Rows, thrusts

# All E. The clearance between keel and tubes is 6 cm, so the pocket leaves a docked vehicle less.
SEAT_M = (0.12, 0.06)  # how far it may be off its seat when docked: level, and up or down
SEAT_RAD = 0.15  # and its heading, roll and pitch
REST_M_S = 0.05
LATCH_S = 3.0  # for which it must rest there: while a latch closes
ABOVE_M = (1.5, 2.0)  # above the dock: level distance, and height of the keel above the mouth
ARRIVED_S = 1.0
ENTERED_M = 0.1  # of the keel below the mouth
LEFT_M = 0.2  # of the keel above the mouth, or beside it, when it has left the dock again
BESIDE_M = 1.2  # level distance from the seat beyond which it is beside the dock
STRIKE_M_S = 0.25  # E: twice the speed of a gentle landing
STRUCK = 0.5  # share of the credit that each strike leaves
TIME_SHARE, FORCE_SHARE = 0.4, 0.2  # E: of the credit, for the time and for the peak force

STAGES = (
    Stage(name="arrived", label="Above the dock", credit=0.02),
    Stage(name="entered", label="Within the mouth", credit=0.05),
    Stage(name="seated", label="On the rails", credit=0.15),
    Stage(name="docked", label="Docked", credit=1.0),
)
_COLUMNS = {**INDEX, **DOCK_INDEX}


class Docking(Attempt):
    """The rows of a level in which a dock is to be entered."""

    def __init__(self, rows: Rows, dt: float, strike_n: float, *, whole: int = 0) -> None:
        """Take the rows; `whole` is how many the level has, if these are not all of them."""
        super().__init__(rows, dt)
        self._strike_n, self._whole = strike_n, whole or len(rows)
        self.reached = reached(rows, dt)

    def column(self, name: str) -> Array:
        """Return a column of the telemetry, (k,)."""
        column: Array = self.rows[:, _COLUMNS[name]]
        return column

    @property
    def docked(self) -> bool:
        """Whether the vehicle was docked."""
        return len(self.reached) == len(STAGES)

    @property
    def steps_taken(self) -> int:
        """Rows until it was docked; all, if it was not."""
        return self.reached[-1] + 1 if self.docked else len(self.rows)

    @property
    def time_s(self) -> float:
        """Time until it was docked; the whole level, if it was not [s]."""
        return self.steps_taken * self.dt

    @cached_property
    def force_n(self) -> Array:
        """Contact force on the hull until it was docked [N]."""
        return self.column("contact_n")[: self.steps_taken]

    @property
    def peak_n(self) -> float:
        """Largest contact force [N]."""
        return float(self.force_n.max(initial=0.0))

    @property
    def strikes(self) -> int:
        """Number of times that the force rose above that of a strike."""
        return _rises(self.force_n > self._strike_n)

    @cached_property
    def approaches(self) -> int:
        """Number of times that the keel came within the mouth after it had been outside of it."""
        count, inside = 0, False
        depth, away = self.column("dock_depth"), np.sqrt(_level_square(self.rows))
        for deep, off in zip(
            depth[: self.steps_taken].tolist(), away[: self.steps_taken].tolist(), strict=True
        ):
            if inside:
                inside = deep > -LEFT_M and off < BESIDE_M
            elif deep > ENTERED_M and off < BESIDE_M:
                count, inside = count + 1, True
        return count

    @property
    def quality(self) -> float:
        """Credit of the level, 0 to 1."""
        credit = STAGES[len(self.reached) - 1].credit if self.reached else 0.0
        if self.docked:
            force = min(self.peak_n / self._strike_n, 1.0)
            credit -= TIME_SHARE * self.steps_taken / self._whole + FORCE_SHARE * force
        return float(credit * STRUCK**self.strikes)

    @property
    def thrust(self) -> Array:
        """Thrust of each thruster, (k, n) [N]."""
        return thrusts(self.rows)


def _rises(flags: Flags) -> int:
    return int(np.count_nonzero(np.diff(flags.astype(np.int8), prepend=0) > 0))


def _level_square(rows: Rows) -> Array:
    """Return the square of the level distance from the seat, (k,) [m²]."""
    ahead, side = rows[:, DOCK_INDEX["dock_ahead"]], rows[:, DOCK_INDEX["dock_side"]]
    square: Array = ahead * ahead + side * side
    return square


def reached(rows: Rows, dt: float) -> tuple[int, ...]:
    """Return the row at which each stage was reached, as far as they were."""
    square, depth = _level_square(rows), rows[:, DOCK_INDEX["dock_depth"]]
    level_m, height_m = ABOVE_M
    above = (square <= level_m * level_m) & (depth >= -height_m)
    entered = (square <= BESIDE_M * BESIDE_M) & (depth >= ENTERED_M)
    seated = _is_seated(rows, square)
    goals = (
        (above, ARRIVED_S),
        (entered, dt),
        (seated, dt),
        (seated & (_speed_square(rows) <= REST_M_S * REST_M_S), LATCH_S),
    )
    found: list[int] = []
    for holds, seconds in goals:
        steps = max(1, round(seconds / dt))
        at = first_run(holds, steps, found[-1] if found else 0)
        if at is None:
            break
        found.append(at)
    return tuple(found)


def _is_seated(rows: Rows, square: Array) -> Flags:
    level_m, down_m = SEAT_M
    angles = np.abs(rows[:, [DOCK_INDEX["dock_turn"], INDEX["roll"], INDEX["pitch"]]])
    flags: Flags = (square <= level_m * level_m) & (
        np.abs(rows[:, DOCK_INDEX["dock_below"]]) <= down_m
    )
    flags &= (angles <= SEAT_RAD).all(axis=1)
    return flags


def _speed_square(rows: Rows) -> Array:
    u, v, w = (rows[:, INDEX[name]] for name in ("u", "v", "w"))
    square: Array = u * u + v * v + w * w
    return square


def _metric(
    name: str,
    label: str,
    unit: str,
    formula: str,
    compute: Callable[[Docking], float],
    **more: Any,
) -> LevelMetric[Docking]:
    options: dict[str, Any] = {"better": "lower", **more}
    return LevelMetric(
        **options,
        name=name,
        label=label,
        unit=unit,
        formula=formula,
        compute=compute,
    )


QUALITY = _metric(
    "docking",
    "Docking",
    "",
    f"{STAGES[0].credit:g}, {STAGES[1].credit:g} and {STAGES[2].credit:g} for the stages before; "
    f"docked: 1 - {TIME_SHARE:g} t / T - {FORCE_SHARE:g} min(max f / f_s, 1) with the time t of T; "
    f"times {STRUCK:g} for each strike",
    lambda level: level.quality,
    better="higher",
    meaning="how far it got, how soon and how gently",
)
DOCKED = _metric(
    "docked",
    "Docked",
    "",
    f"1 if it was at most {SEAT_M[0]:g} m beside and {SEAT_M[1]:g} m above or below its seat, "
    f"turned by at most {SEAT_RAD:g} rad about each axis and no faster than {REST_M_S:g} m/s for "
    f"{LATCH_S:g} s, else 0",
    lambda level: float(level.docked),
    better="higher",
    meaning="1 if the vehicle rested in the dock until it was latched",
)
TIME = _metric(
    "docking_s",
    "Time to dock",
    "s",
    "time at which it was docked; the whole level, if it was not",
    lambda level: level.time_s,
)
RETRIES = _metric(
    "reattempts",
    "Re-attempts",
    "",
    "number of times that the keel came within the mouth, less 1, at least 0",
    lambda level: float(max(level.approaches - 1, 0)),
    over=SUM,
    meaning="approaches after the first one",
)
STRIKES = _metric(
    "dock_strikes",
    "Strikes",
    "",
    "number of times that f rose above f_s",
    lambda level: float(level.strikes),
    over=SUM,
    meaning=f"contacts harder than a stop from {STRIKE_M_S:g} m/s",
)
PEAK = _metric(
    "docking_peak_n",
    "Peak force",
    "N",
    "max f",
    lambda level: level.peak_n,
    over=MAX,
    meaning="of the contact on the hull",
)
GROUP = MetricGroup("Docking", (QUALITY, DOCKED, TIME, RETRIES, STRIKES, PEAK))
METRICS = (*GROUP.metrics, ENERGY)
HELD = Metric("held", "Held", "", "higher", meaning="docked without a strike")
