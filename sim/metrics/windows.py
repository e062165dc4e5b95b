"""The rows of a level as the station-keeping metrics read them."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from seamark.sim.metrics.metric import Absent
from seamark.sim.numerics.arrays import Array
from seamark.sim.recording.telemetry import (
    COMMON_THRUSTERS,
    INDEX,
    Rows,
    thrust_names,
    thrusts,
)

LOST_PX = 15.0  # [px] E: half of the target's shorter side at 2.27 m
# What a metric reads, by what it is computed from.
THRUST_COLUMNS = thrust_names(COMMON_THRUSTERS)
LOST_COLUMNS = ("tracker_error", "tracker_ok")


@dataclass(frozen=True, slots=True, kw_only=True)
class LevelFacts:
    """What the metrics need beside the rows of one level."""

    level: int
    speed: float  # [m/s]
    dt: float  # [s]
    settle_s: float
    limits_n: tuple[float, float]  # maximum thrust forward, reverse
    heading: float = 0.0  # [rad] reference
    thrusters: int = 0  # of the vehicle
    absent: Absent = frozenset()  # columns that were not measured


class Window:
    """The rows of a part of a level, and what several metrics need of them."""

    def __init__(self, rows: Rows, facts: LevelFacts) -> None:
        self.rows, self.facts, self.dt = rows, facts, facts.dt

    def values(self, name: str) -> Array:
        """Return a column of the telemetry, (N,)."""
        column: Array = self.rows[:, INDEX[name]]
        return column

    def column(self, name: str) -> list[float]:
        """Return it as a list."""
        values: list[float] = self.values(name).tolist()
        return values

    @cached_property
    def distance_m(self) -> list[float]:
        """True distance from the station, (N,) [m]."""
        return self.column("distance")

    @cached_property
    def heading_error(self) -> Array:
        """Size of the heading error, (N,) [rad] in [0, pi]."""
        turned = (self.values("yaw") - self.facts.heading + math.pi) % (2.0 * math.pi)
        size: Array = np.abs(turned - math.pi)
        return size

    @cached_property
    def thrust(self) -> NDArray[np.float64]:
        """Thrust of every thruster, (N, thrusters) [N]."""
        return thrusts(self.rows)

    @cached_property
    def lost_percent(self) -> float:
        """Share of the rows at which the target is lost [%]."""
        return percent(lost(self.rows).tolist())


class Level:
    """A level after its settle window, and as a whole."""

    def __init__(self, rows: Rows, facts: LevelFacts) -> None:
        first = min(round(facts.settle_s / facts.dt), len(rows))
        self.settled, self.whole = Window(rows[first:], facts), Window(rows, facts)


def lost(rows: Rows) -> NDArray[np.bool_]:
    """Return at which rows the target is lost, (k,): by the tracker's report or by ground truth."""
    by_truth = ~(rows[:, INDEX["tracker_error"]] <= LOST_PX)  # nan counts as lost
    result: NDArray[np.bool_] = by_truth | (rows[:, INDEX["tracker_ok"]] == 0.0)
    return result


def percent(flags: Sequence[bool]) -> float:
    """Return the share of the flags that are set [%]; nan of nothing."""
    return 100.0 * sum(flags) / len(flags) if flags else math.nan
