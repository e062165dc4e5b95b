"""The table of a level: a place, a record and waves on one grid of time and depth.

The level's speed is the mean velocity, at the height of the start and over the level's time, of all
but the waves, and the current comes from the level's azimuth: whatever a record has, its
stretch is turned and scaled to that, and the mean of the turbulence is taken out.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit

from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.libm import sincos
from seamark.sim.numerics.random_streams import Streams
from seamark.sim.physics.constants import MIN_HEIGHT_M
from seamark.sim.physics.current import (
    TABLE_GRID_S,
    Current,
    Table,
    Water,
    moving_in,
    profile,
    table_points,
)
from seamark.sim.physics.water_motion.places import Place
from seamark.sim.physics.water_motion.record import STILL_M_S, Record, means
from seamark.sim.physics.water_motion.turbulence import fluctuation, turbulence_of
from seamark.sim.physics.water_motion.waves import Waves, orbital_velocity

# The depths of a table, from the bottom up: half a metre is less than any of our vehicles, and more
# where a vehicle starts higher above the bottom.
DEPTHS = 10
SPACING_M = 0.5  # [m] at least
ABOVE_M = 2.0  # [m] above the start, to which depths reach at least; E
ROWS = 3 * DEPTHS
# S: DNV-RP-C205 (2010) 4.1.4; below the lowest height of a record, and for one of a single height.
_EXPONENT = 1.0 / 7.0
_LIKE = 1.1  # stretches whose factor is at most so much further from 1 than the best one's; E


@dataclass(frozen=True, slots=True, kw_only=True)
class Motion:
    """How the water of a run moves, but for its speed."""

    place: Place | None = None
    record: Record | None = None  # instead of a steady current
    waves: Waves | None = None
    base: Current | None = None  # instead of a place and a record: of the level, as it stands


@dataclass(frozen=True, slots=True, kw_only=True)
class Site:
    """Where the vehicle is, and for how long."""

    bottom_m: float  # [m] depth of the bottom
    start_m: float  # [m] depth of the start
    azimuth_rad: float  # where the current and the waves come from
    duration_s: float

    @property
    def height_m(self) -> float:
        """Height of the start above the bottom."""
        return self.bottom_m - self.start_m

    @property
    def spacing_m(self) -> float:
        """Distance between two depths of the table."""
        highest = min(self.height_m + ABOVE_M, self.bottom_m)
        return max(SPACING_M, highest / (DEPTHS - 1))

    def heights(self) -> Array:
        """Return the heights above the bottom of a table's depths, (DEPTHS,) [m]."""
        return self.spacing_m * np.arange(DEPTHS - 1, -1, -1.0)


class Stretch(NamedTuple):
    """The part of a record that a level gets."""

    at_s: float  # [s] since the record began
    factor: float  # by which its velocity is multiplied
    speed: float  # [m/s] its own mean at the height of the start
    azimuth_rad: float  # where its own mean comes from


def current_of(level: float, motion: Motion, site: Site, random: Streams) -> Current:
    """Return the current of a level [m/s]."""
    return Current(level, table=tabulated(level, motion, site, random))


def tabulated(level: float, motion: Motion, site: Site, random: Streams) -> Table:
    """Return how the water of a level moves."""
    count = table_points(site.duration_s)
    velocity = np.zeros((DEPTHS, 3, count))
    if motion.base is not None:
        depths = site.bottom_m - site.heights()
        _sample(motion.base.water, depths, velocity)
    elif level > 0.0:
        velocity += _turned(_stream(level, motion, site, random, count), site.azimuth_rad)
    if motion.waves is not None:
        heights = np.minimum(site.heights(), site.bottom_m)
        orbits = np.zeros_like(velocity)
        orbits[:, ::2] = orbital_velocity(motion.waves, heights, site.bottom_m, random.waves, count)
        velocity += _turned(orbits, site.azimuth_rad)
    top = site.bottom_m - (DEPTHS - 1) * site.spacing_m
    return Table(velocity=velocity, top_m=top, spacing_m=site.spacing_m)


def stretch_of(level: float, record: Record, site: Site, rng: np.random.Generator) -> Stretch:
    """Return the stretch of a record whose mean lies nearest to a level, or one about as near.

    It is drawn among those whose scaling is within 10 % of the least.
    """
    mean = means(_at_height(record, site.height_m), record.step_s, site.duration_s)
    speeds = np.sqrt(mean[0] * mean[0] + mean[1] * mean[1])
    moving = np.maximum(speeds, 1e-6 * STILL_M_S)
    factors = np.maximum(level / moving, moving / level)
    best = np.flatnonzero(factors <= _LIKE * factors.min())
    at = int(best[int(rng.random() * best.size)])
    north, east = float(mean[0, at]), float(mean[1, at])
    speed = math.sqrt(north * north + east * east)
    azimuth = math.atan2(-east, -north)  # only told: what is computed turns by the vector itself
    return Stretch(at * record.step_s, level / speed, speed, azimuth)


def _stream(level: float, motion: Motion, site: Site, random: Streams, count: int) -> Array:
    """Return the velocity along the current, across it and down, (DEPTHS, 3, count) [m/s]."""
    if motion.record is not None:
        along = _of_record(level, motion.record, site, random, count)
    else:
        along = np.zeros((DEPTHS, 3, count))
        exponent = motion.place.exponent if motion.place else 0.0
        for i, height in enumerate(site.heights().tolist()):
            along[i, 0] = level * _share(height, site.height_m, exponent)
    if motion.place is not None:
        _add_turbulence(level, motion.place, site, random, along)
    return along


def _turned(along: Array, azimuth_rad: float) -> Array:
    """Return (k, 3, n) along the current, across it to the left and down as NED."""
    s, c = sincos(azimuth_rad)
    out = np.empty_like(along)
    out[:, 0] = along[:, 1] * s - along[:, 0] * c
    out[:, 1] = -along[:, 0] * s - along[:, 1] * c
    out[:, 2] = along[:, 2]
    return out


@njit(cache=True, error_model="numpy")
def _sample(water: Water, depths: Array, out: Array) -> None:
    """Write the velocity of a current at depths (k,) to a table, (k, 3, n)."""
    for at in range(out.shape[2]):
        for i in range(depths.size):
            moving = moving_in(at * TABLE_GRID_S, depths[i], water)
            out[i, 0, at], out[i, 1, at], out[i, 2, at] = moving[0], moving[1], moving[2]


def _add_turbulence(level: float, place: Place, site: Site, random: Streams, along: Array) -> None:
    """Add turbulence, the same at all depths but for its upright part, which the bottom stops."""
    turbulence = turbulence_of(place, level, site.height_m)
    parts = fluctuation(turbulence, random.turbulence, along.shape[2])
    for axis in range(3):
        parts[axis] -= _mean(parts[axis], site)
    for i, height in enumerate(site.heights().tolist()):
        along[i, :2] += parts[:2]
        along[i, 2] += min(height / site.height_m, 1.0) * parts[2]


def _of_record(level: float, record: Record, site: Site, random: Streams, count: int) -> Array:
    """Return a stretch of a record, turned and scaled, (DEPTHS, 3, count) [m/s]."""
    stretch = stretch_of(level, record, site, random.record)
    times = stretch.at_s + TABLE_GRID_S * np.arange(count)
    position = np.minimum(times / record.step_s, record.velocity.shape[2] - 1.0)
    first = np.minimum(np.floor(position).astype(np.int64), record.velocity.shape[2] - 2)
    part = position - first
    before, after = record.velocity[:, :, first], record.velocity[:, :, first + 1]
    ours = before + (after - before) * part  # (h, 3, count)
    placed = np.array([_interpolated(ours, record.heights, h) for h in site.heights().tolist()])
    there = _interpolated(ours, record.heights, site.height_m)
    north, east = _mean(there[0], site), _mean(there[1], site)
    speed = math.sqrt(north * north + east * east)
    x, y = north / speed, east / speed
    factor = level / speed
    turned = np.empty_like(placed)
    turned[:, 0] = factor * (x * placed[:, 0] + y * placed[:, 1])
    turned[:, 1] = factor * (x * placed[:, 1] - y * placed[:, 0])
    turned[:, 2] = factor * placed[:, 2]
    return turned


def _mean(values: Array, site: Site) -> float:
    """Return the mean of (n,) over the level: correctly rounded, so it has no order."""
    steps = round(site.duration_s / TABLE_GRID_S) + 1
    return math.fsum(values[:steps].tolist()) / steps


def _at_height(record: Record, height_m: float) -> Array:
    """Return north and east of a record at a height above the bottom, (2, n) [m/s]."""
    return _interpolated(record.velocity, record.heights, height_m)[:2]


def _interpolated(velocity: Array, heights: Array, height_m: float) -> Array:
    """Return (3, n) at a height: linear between those of a record, constant above them."""
    lowest = float(heights[0])
    if height_m <= lowest or heights.size == 1:
        slower: Array = velocity[0] * _share(height_m, lowest, _EXPONENT)
        return slower
    at = min(int(np.searchsorted(heights, height_m)), heights.size - 1)
    low, high = float(heights[at - 1]), float(heights[at])
    part = min((height_m - low) / (high - low), 1.0)
    between: Array = velocity[at - 1] + (velocity[at] - velocity[at - 1]) * part
    return between


def _share(height_m: float, reference_m: float, exponent: float) -> float:
    """Return the power law's speed at a height over that at another one."""
    reference = max(reference_m, MIN_HEIGHT_M.scalar)
    share, _slope = profile(-height_m, exponent, 0.0, reference)
    return float(share)
