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

RELATIVE, _FORCE = 0, 1
# Of the drift between two points of its grid: time [s] of the first, speed [m/s] there and its
# slope, turn [rad] there and its slope.
Segment = tuple[float, float, float, float, float]


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
    drift: Array  # (2, k) on the grid: gust and lasting changes of speed [m/s], turn [rad]
    shear: float = 0.0
    bottom: float = 0.0
    height: float = 1.0


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
        """
        if not level >= 0.0:
            raise ValueError(f"a current's level must not be negative, not {level}")
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
            law=RELATIVE if law.law == "relative" else _FORCE,
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

        It is zero under the force law and independent of the depth without shear.
        """
        x, y, *_rest = flow(t_s, self.water, segment_at(t_s, self.water.drift))
        water = self.water
        share, _slope = profile(depth_m, water.shear, water.bottom, water.height)
        return np.array([share * x, share * y, 0.0])


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
def segment_at(t: float, drift: Array) -> Segment:
    """Return the straight piece of the drift at time t [s]; the last one after its end."""
    at = min(max(int(t / GUST_GRID_S), 0), drift.shape[1] - 2)
    speed, turn = drift[0, at], drift[1, at]
    slope = (drift[0, at + 1] - speed) / GUST_GRID_S
    turning = (drift[1, at + 1] - turn) / GUST_GRID_S
    return at * GUST_GRID_S, speed, slope, turn, turning


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
    """
    begin, gust, slope, turned, turning = segment
    since = t - begin
    s, c = sincos(water.speed_rate * t + water.speed_phase)
    speed = water.level + water.speed_swing * s + gust + slope * since
    speed_rate = water.speed_swing * water.speed_rate * c + slope
    s, c = sincos(water.azimuth_rate * t + water.azimuth_phase)
    swing = water.azimuth_swing * s + (turned + turning * since)
    swing_rate = water.azimuth_swing * water.azimuth_rate * c + turning
    zero = like(speed, 0.0)
    if water.law == _FORCE:
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
