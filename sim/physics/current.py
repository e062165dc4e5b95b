"""The current: a mean speed, two slow sinusoids and a seeded gust.

World frame NED. `azimuth_rad` is the direction that the water comes from, clockwise from north:
zero is ahead of a vehicle that heads north, pi/2 to starboard of it. Two laws:

relative
    The water moves with v = -V (cos a, sin a, 0), V = level + 0.005 sin(2 pi t / 4) + gust,
    a = azimuth + 0.7 sin(2 pi t / 30); forces follow the velocity relative to it. Both sinusoids
    may have a phase, and the current may change for good at given times (`Change`).
force
    The model of the published experiment's simulator: the water rests, and a force acts in the body
    frame: 410 k V² on sway, 410 k (V sin(a - azimuth))² on surge. It never changes sign and does
    not depend on the azimuth.
table
    The water moves as a table has it, for each instant and depth: what `physics.water_motion` makes
    of a place, a record and waves. There is no sinusoid, no gust and no `Shear`.

Near the bottom the water may be slower (`Shear`): V (h/h0)^n at the height h of the vehicle. The
level then gives the speed at h0. The whole pattern scales with it, including gusts.

A level of zero is still water: no gust, which is proportional to the level, and no sinusoid (the
published law would leave 5 mm/s, or 0.001 N), so the first level shows the control loop alone.
"""

from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from numba import njit

from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.lanes import like, select, some
from seamark.sim.numerics.libm import PI, exp, log, sin, sincos
from seamark.sim.physics import constants

GUST_GRID_S = constants.GUST_GRID_S.scalar  # independent of the integration step

CHANGE_S = constants.CURRENT_CHANGE_S.scalar

MIN_HEIGHT_M = constants.MIN_HEIGHT_M.scalar

TABLE_GRID_S = constants.TABLE_GRID_S.scalar

RELATIVE, FORCE, TABLE = 0, 1, 2
# Of the drift between two points of its grid: time [s] of the first, speed [m/s] there and its
# slope, turn [rad] there and its slope; then nothing. Of a table's cell: time [s] and depth [m] of
# its corner, velocity north, east, down [m/s] there, its slope in time [m/s²] and with depth [1/s],
# and how the latter changes with time [1/s²].
Segment = tuple[float, ...]
SEGMENT = 14  # numbers of one
# Velocity [m/s], acceleration [m/s²] and change with depth [1/s] of the water, each north, east,
# down; force on the body along surge and sway [N].
Moving = tuple[float, float, float, float, float, float, float, float, float, float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Change:
    """A lasting change of the current, linear over `CHANGE_S` from `at_s` on."""

    at_s: float  # [s] since the level began
    turn_rad: float  # of the direction that the water comes from
    speed_share: float  # added speed as a share of the level


@dataclass(frozen=True, slots=True, kw_only=True)
class Pattern:
    """Variation of the current around its level; the defaults are the published experiment's."""

    azimuth_rad: float = 0.0
    azimuth_swing_rad: float = 0.7  # S: uwsimbenchmarks trackingBenchmarkDynamics.xml
    azimuth_period_s: float = 30.0  # S: same
    speed_swing: float = 0.005  # [m/s] S: same
    speed_period_s: float = 4.0  # S: same
    gust_share: float = 0.05  # standard deviation as a share of the level; E
    gust_time_s: float = 10.0  # correlation time; E
    law: Literal["relative", "force"] = "relative"
    force_share: float = 0.134  # k: 18 px at 0.4 m/s, the one number published; D
    azimuth_phase_rad: float = 0.0
    speed_phase_rad: float = 0.0
    changes: tuple[Change, ...] = ()

    def __post_init__(self) -> None:
        """Refuse impossible values."""
        for name in ("azimuth_period_s", "speed_period_s", "gust_time_s"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} must be positive, not {getattr(self, name)}")
        for name in ("speed_swing", "gust_share", "force_share"):
            if not getattr(self, name) >= 0.0:
                raise ValueError(f"{name} must not be negative, not {getattr(self, name)}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Shear:
    """A power law: at the height h above the bottom the speed is (h/h0)^n times the level.

    S: DNV-RP-C205 (2010) 4.1.4, tidal current; n = 1/7 is typical.
    """

    exponent: float
    bottom_m: float  # [m] depth of the bottom
    height_m: float  # [m] h0

    def __post_init__(self) -> None:
        """Refuse impossible values."""
        if not 0.0 <= self.exponent <= 1.0:
            raise ValueError(f"the exponent must be from 0 to 1, not {self.exponent}")
        if not self.height_m > MIN_HEIGHT_M:
            raise ValueError(f"height_m must be above {MIN_HEIGHT_M} m, not {self.height_m}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """The water's velocity on a grid of time and depth, linear between its points.

    Above the first and below the last depth it is that of the first and the last.
    """

    velocity: Array  # (depths, 3, k) NED [m/s], every TABLE_GRID_S from the level's start on
    top_m: float  # [m] the first depth
    spacing_m: float  # [m] between two depths

    def __post_init__(self) -> None:
        """Refuse what is no table."""
        if self.velocity.ndim != 3 or self.velocity.shape[1] != 3 or self.velocity.shape[2] < 2:
            raise ValueError(f"a table cannot have the shape {self.velocity.shape}")
        if not np.all(np.isfinite(self.velocity)):
            raise ValueError("a table of currents must have finite numbers alone")
        if not self.spacing_m > 0.0:
            raise ValueError(f"spacing_m must be positive, not {self.spacing_m}")


class Water(NamedTuple):
    """A current as the compiled code reads it."""

    law: int
    level: float
    azimuth: float
    azimuth_swing: float
    azimuth_rate: float
    speed_swing: float
    speed_rate: float
    force: float
    azimuth_phase: float
    speed_phase: float
    # (2, k) on the grid: gust and lasting changes of speed [m/s], turn [rad]; of a table
    # (depths x 3, k): velocity north, east, down [m/s]
    drift: Array
    shear: float = 0.0
    bottom: float = 0.0
    height: float = 1.0
    top: float = 0.0  # [m] of a table
    spacing: float = 1.0  # [m]


class Current:
    """One level's current, the same for every integration step."""

    def __init__(
        self,
        level: float,
        *,
        pattern: Pattern | None = None,
        shear: Shear | None = None,
        rng: np.random.Generator | None = None,
        duration_s: float = 120.0,
        table: Table | None = None,
    ) -> None:
        """Draw the gust of a level.

        Parameters
        ----------
        level : float [m/s]
            Mean speed, not negative.
        shear : Shear, optional
            Only for the relative law; without it the speed is the same at every depth.
        rng : Generator, optional
            Random stream of the gust; without it there is no gust.
        duration_s : float
            Length of the gust; a longer one begins with the same values. Without gust and changes
            the length is unlimited.
        table : Table, optional
            How the water moves, instead of all that; `level` only names it then.
        """
        if not level >= 0.0:
            raise ValueError(f"a current's level must not be negative, not {level}")
        if table is not None:
            self.duration_s = TABLE_GRID_S * (table.velocity.shape[2] - 1)
            self.water = _tabulated(level, table)
            return
        law = pattern or Pattern()
        if shear is not None and law.law == "force":
            raise ValueError("shear needs the relative law: under the force law the water rests")
        over = shear or Shear(exponent=0.0, bottom_m=0.0, height_m=1.0)
        drawn = rng is not None or bool(law.changes)
        self.duration_s = duration_s if drawn else float("inf")
        drift = np.zeros((2, grid_points(duration_s) if drawn else 2))
        if rng is not None:
            drift[0] = _gust(rng, law.gust_share * level, law.gust_time_s, duration_s)
        for change in law.changes:
            ramp = _ramp(change.at_s, duration_s)
            drift[0] += change.speed_share * level * ramp
            drift[1] += change.turn_rad * ramp
        self.water = Water(
            law=RELATIVE if law.law == "relative" else FORCE,
            level=float(level),
            azimuth=float(law.azimuth_rad),
            azimuth_swing=float(law.azimuth_swing_rad),
            azimuth_rate=2.0 * PI / law.azimuth_period_s,
            speed_swing=float(law.speed_swing) if level > 0.0 else 0.0,
            speed_rate=2.0 * PI / law.speed_period_s,
            force=constants.FORCE_PER_SPEED_SQUARED.scalar * law.force_share,
            azimuth_phase=float(law.azimuth_phase_rad),
            speed_phase=float(law.speed_phase_rad),
            drift=drift,
            shear=float(over.exponent),
            bottom=float(over.bottom_m),
            height=float(over.height_m),
        )

    def velocity(self, t_s: float, depth_m: float = 0.0) -> Array:
        """Return the water's velocity at a time and a depth, (3,) NED [m/s].

        It is zero under the force law and, without a table, independent of the depth without shear.
        """
        x, y, z, *_rest = moving_in(t_s, depth_m, self.water)
        return np.array([x, y, z])


def _tabulated(level: float, table: Table) -> Water:
    depths, axes, points = table.velocity.shape
    return Water(
        law=TABLE,
        level=float(level),
        azimuth=0.0,
        azimuth_swing=0.0,
        azimuth_rate=0.0,
        speed_swing=0.0,
        speed_rate=0.0,
        force=0.0,
        azimuth_phase=0.0,
        speed_phase=0.0,
        drift=np.array(table.velocity, dtype=np.float64).reshape(depths * axes, points),
        top=float(table.top_m),
        spacing=float(table.spacing_m),
    )


def table_points(duration_s: float) -> int:
    """Return how many instants a table of this length has."""
    return int(duration_s / TABLE_GRID_S) + 3


def grid_points(duration_s: float) -> int:
    """Return how many points a gust of this length has."""
    return int(duration_s / GUST_GRID_S) + 3


def _ramp(at_s: float, duration_s: float) -> Array:
    """Return the share of a change that has taken place, (k,) on the grid, from 0 to 1."""
    times = GUST_GRID_S * np.arange(grid_points(duration_s))
    share: Array = np.clip((times - at_s) / CHANGE_S, 0.0, 1.0)
    return share


def _gust(rng: np.random.Generator, sigma: float, time_s: float, duration_s: float) -> Array:
    """Return an Ornstein-Uhlenbeck process on the grid, (k,) [m/s], by its exact transition."""
    count = grid_points(duration_s)
    normals = rng.standard_normal(count)
    keep = exp(-GUST_GRID_S / time_s)
    renew = sigma * float(np.sqrt(1.0 - keep * keep))
    normals[0] *= sigma
    _correlate(normals, keep, renew)
    return normals


@njit(cache=True, error_model="numpy")
def _correlate(values: Array, keep: float, renew: float) -> None:
    """Make the later ones of independent numbers (k,) depend on their predecessors, in place."""
    for i in range(1, values.size):
        values[i] = keep * values[i - 1] + renew * values[i]


@njit(cache=True, error_model="numpy")
def segment_at(
    t: float, depth: float, law: int, grid: tuple[float, float], drift: Array
) -> Segment:
    """Return the straight piece of the drift at time t [s]; the last one after its end.

    Of a table it is the cell at this depth [m]; `grid` has its top and its spacing.
    """
    if law == TABLE:
        return _cell_at(t, depth, grid, drift)
    at = min(max(int(t / GUST_GRID_S), 0), drift.shape[1] - 2)
    speed, turn = drift[0, at], drift[1, at]
    slope = (drift[0, at + 1] - speed) / GUST_GRID_S
    turning = (drift[1, at + 1] - turn) / GUST_GRID_S
    no = 0.0
    return (at * GUST_GRID_S, speed, slope, turn, turning, no, no, no, no, no, no, no, no, no)


@njit(cache=True, error_model="numpy", inline="always")
def segment_of(numbers: Array, i: int) -> Segment:
    """Return the segment in row i of numbers (k, SEGMENT), or of lanes of them."""
    return (
        *(numbers[i, 0], numbers[i, 1], numbers[i, 2], numbers[i, 3], numbers[i, 4]),
        *(numbers[i, 5], numbers[i, 6], numbers[i, 7], numbers[i, 8], numbers[i, 9]),
        *(numbers[i, 10], numbers[i, 11], numbers[i, 12], numbers[i, 13]),
    )


@njit(cache=True, error_model="numpy")
def _cell_at(t: float, depth: float, grid: tuple[float, float], table: Array) -> Segment:
    end = table.shape[1] - 1
    begin = min(max(int(t / TABLE_GRID_S), 0), end)
    instants = (begin, min(begin + 1, end))  # both the last one after the end: no change from there
    top, spacing = grid
    last = table.shape[0] // 3 - 1
    upper, lower = 0, 0
    if depth >= top + last * spacing:
        upper = lower = last
    elif depth > top:  # not so if the depth is not a number
        upper = min(int((depth - top) / spacing), last - 1)
        lower = upper + 1
    x, x_rate, x_slope, x_change = _corner(table, 3 * upper, 3 * lower, instants, spacing)
    y, y_rate, y_slope, y_change = _corner(table, 3 * upper + 1, 3 * lower + 1, instants, spacing)
    z, z_rate, z_slope, z_change = _corner(table, 3 * upper + 2, 3 * lower + 2, instants, spacing)
    return (
        begin * TABLE_GRID_S,
        top + upper * spacing,
        *(x, y, z),
        *(x_rate, y_rate, z_rate),
        *(x_slope, y_slope, z_slope),
        *(x_change, y_change, z_change),
    )


@njit(cache=True, error_model="numpy", inline="always")
def _corner(
    table: Array, row: int, below: int, instants: tuple[int, int], spacing: float
) -> tuple[float, float, float, float]:
    """Return a value of a cell's first corner, and its slopes in time, in depth and in both."""
    first, second = instants
    value, later = table[row, first], table[row, second]
    more, more_later = table[below, first] - value, table[below, second] - later
    rate, change = (later - value) / TABLE_GRID_S, (more_later - more) / TABLE_GRID_S
    return value, rate, more / spacing, change / spacing


@njit(cache=True, error_model="numpy")
def profile(depth: float, exponent: float, bottom: float, reference: float) -> tuple[float, float]:
    """Return the share of the level's speed at a depth [m], and its derivative [1/m].

    The last three arguments are shear, bottom and height of `Water`, since passing a tuple with an
    array costs a reference count per call. Below MIN_HEIGHT_M above the bottom the share is
    constant.
    """
    sheared = exponent != 0.0
    if not some(sheared):
        return like(depth, 1.0), like(depth, 0.0)
    height = bottom - depth
    above = height > MIN_HEIGHT_M
    share = exp(exponent * log(select(above, height, MIN_HEIGHT_M) / reference))
    slope = select(above, -exponent * share / height, 0.0)
    return select(sheared, share, 1.0), select(sheared, slope, 0.0)


@njit(cache=True, error_model="numpy")
def flow(
    t: float, water: Water, segment: Segment
) -> tuple[float, float, float, float, float, float]:
    """Return velocity x, y [m/s], acceleration x, y [m/s²] (NED), body force surge, sway [N].

    `segment` is chosen once per integration step, so that the flow is smooth over all its stages.
    It is that of all depths, which `at_depth` reduces; of a table it is zero.
    """
    if water.law == TABLE:
        zero = like(water.level, 0.0)
        return zero, zero, zero, zero, zero, zero
    begin, gust, slope, turned, turning = segment[0], segment[1], segment[2], segment[3], segment[4]
    since = t - begin
    s, c = sincos(water.speed_rate * t + water.speed_phase)
    speed = water.level + water.speed_swing * s + gust + slope * since
    speed_rate = water.speed_swing * water.speed_rate * c + slope
    s, c = sincos(water.azimuth_rate * t + water.azimuth_phase)
    swing = water.azimuth_swing * s + (turned + turning * since)
    swing_rate = water.azimuth_swing * water.azimuth_rate * c + turning
    zero = like(speed, 0.0)
    if water.law == FORCE:
        lateral = speed * sin(swing)
        return zero, zero, zero, zero, water.force * lateral * lateral, water.force * speed * speed
    s, c = sincos(water.azimuth + swing)
    return (
        -speed * c,
        -speed * s,
        -speed_rate * c + speed * swing_rate * s,
        -speed_rate * s - speed * swing_rate * c,
        zero,
        zero,
    )


@njit(cache=True, error_model="numpy", inline="always")
def at_depth(
    t: float,
    depth: float,
    flowing: tuple[float, float, float, float, float, float],
    law_and_shear: tuple[int, float, float, float],
    segment: Segment,
) -> Moving:
    """Return how the water moves at a depth [m]; `flowing` is what `flow` returns.

    The numbers of the law are those of `Water`, without its array, since passing a tuple with one
    costs a reference count per call.
    """
    x, y, rise_x, rise_y, surge, sway = flowing
    law, shear, bottom, height = law_and_shear
    if law == TABLE:
        since, below = t - segment[0], depth - segment[1]
        # Change with depth now; velocity; acceleration.
        s_x, s_y, s_z = (
            segment[8] + segment[11] * since,
            segment[9] + segment[12] * since,
            segment[10] + segment[13] * since,
        )
        return (
            segment[2] + segment[5] * since + s_x * below,
            segment[3] + segment[6] * since + s_y * below,
            segment[4] + segment[7] * since + s_z * below,
            segment[5] + segment[11] * below,
            segment[6] + segment[12] * below,
            segment[7] + segment[13] * below,
            *(s_x, s_y, s_z),
            *(surge, sway),
        )
    share, slope = profile(depth, shear, bottom, height)
    zero = like(x, 0.0)
    return (
        *(share * x, share * y, zero),
        *(share * rise_x, share * rise_y, zero),
        *(slope * x, slope * y, zero),
        *(surge, sway),
    )


@njit(cache=True, error_model="numpy")
def moving_in(t: float, depth: float, water: Water) -> Moving:
    """Return how the water moves at time t [s] and a depth [m]."""
    segment = segment_at(t, depth, water.law, (water.top, water.spacing), water.drift)
    flowing = flow(t, water, segment)
    law = (water.law, water.shear, water.bottom, water.height)
    return at_depth(t, depth, flowing, law, segment)
