"""Terrain: a flat bottom or mounds around the target, and the range of a DVL's beams to it.

The mounds are a sum of a few waves with random direction, length and phase, between 0 and
`height_m` above the flat bottom. They begin `flat_m` away from the target, rise to full height over
RISE_M and end REACH_M away. They are a smooth function of the position in IEEE arithmetic: the
altimeter acts on the vehicle's motion, so its bits must not depend on the processor, unlike those
of a contact engine's ray casts.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit

from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.lanes import like, select, some, sqrt
from seamark.sim.numerics.libm import PI, cos, sin, sincos
from seamark.sim.physics import constants

WAVES = 5
WAVELENGTHS_M = constants.MOUND_LENGTHS_M.value
RISE_M = constants.MOUND_RISE_M.scalar
REACH_M = constants.MOUND_REACH_M.scalar
BEAM_RANGE_M = constants.DVL_RANGE_M.value[1]
_BEAM_RAD = constants.DVL_BEAM_RAD.scalar
_TOLERANCE_M = 1e-7  # a ray this close to the bottom has hit it
_MAX_STEPS = 200


class Mounds(NamedTuple):
    """Mounds as the compiled code reads them."""

    depth: float
    height: float
    flat: float
    north: float
    east: float
    steepest: float
    waves: Array
    beam_side: float  # unit vector of a beam: component along the body's x and y axes, and along z
    beam_down: float
    flattest: float  # cosine of the largest angle of incidence with an echo


class Sounding(NamedTuple):
    """Result of four beams: height of the body's origin above the hits [m], number of echoes."""

    altitude: float
    echoes: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Relief:
    """Mounds of one trial. `waves` is (k, 4): share, wave number north and east [rad/m], phase."""

    height_m: float
    flat_m: float
    waves: Array


def draw_relief(rng: np.random.Generator, *, height_m: float, flat_m: float) -> Relief:
    """Return mounds drawn from a stream.

    Parameters
    ----------
    height_m : float
        Upper limit of the mounds; the highest come close to it.
    flat_m : float
        Radius of the flat patch around the target.
    """
    if not (height_m >= 0.0 and 0.0 <= flat_m <= REACH_M - 2.0 * RISE_M):
        raise ValueError(f"mounds of {height_m} m beyond {flat_m} m are not possible")
    waves = np.empty((WAVES, 4))
    shortest, longest = WAVELENGTHS_M
    for i, (heading, length, phase) in enumerate(rng.random((WAVES, 3)).tolist()):
        s, c = sincos(2.0 * PI * heading)
        number = 2.0 * PI / (shortest + (longest - shortest) * length)
        waves[i] = 1.0 / WAVES, number * c, number * s, 2.0 * PI * phase
    return Relief(height_m=height_m, flat_m=flat_m, waves=waves)


class Bottom:
    """The bottom under and around the target."""

    def __init__(
        self, depth_m: float, relief: Relief | None = None, *, centre: tuple[float, float] = (0, 0)
    ) -> None:
        """Set up a bottom at a depth; `centre` is north and east of the flat patch's centre [m]."""
        self.depth_m = depth_m
        self.relief = relief
        self.centre = (float(centre[0]), float(centre[1]))
        self._mounds: Mounds | None = None
        if relief is not None:
            numbers = [math.sqrt(north * north + east * east) for _, north, east, _ in relief.waves]
            steepest = 0.5 * max(numbers) + 1.5 / RISE_M
            self._mounds = Mounds(
                depth=float(depth_m),
                height=float(relief.height_m),
                flat=float(relief.flat_m),
                north=self.centre[0],
                east=self.centre[1],
                steepest=relief.height_m * steepest,
                waves=relief.waves,
                beam_side=sin(_BEAM_RAD)
                * sin(0.25 * PI),  # E: all beams at 45 degrees between the axes
                beam_down=cos(_BEAM_RAD),
                # That of a beam on a flat bottom at the largest tilt with bottom lock.
                flattest=cos(_BEAM_RAD + constants.DVL_MOST_TILT_RAD.scalar),
            )

    @property
    def top_m(self) -> float:
        """Return the least depth [m] of the bottom anywhere."""
        return self.depth_m - (self.relief.height_m if self.relief is not None else 0.0)

    def ground(self) -> Mounds:
        """Return the bottom for compiled code; a flat one has mounds of no height."""
        if self._mounds is not None:
            return self._mounds
        return Mounds(
            depth=float(self.depth_m),
            height=0.0,
            flat=REACH_M,
            north=self.centre[0],
            east=self.centre[1],
            steepest=0.0,
            waves=np.zeros((WAVES, 4)),
            beam_side=0.0,
            beam_down=1.0,
            flattest=0.0,
        )

    def sound(self, pose: Array | Sequence[float]) -> Sounding:
        """Return the result of the DVL's four beams at a pose, (6,) [m, rad].

        On a flat bottom it is the height above it. The beams start at the body's origin; the target
        is too small to matter.
        """
        if self._mounds is None:
            return Sounding(self.depth_m - float(pose[2]), 4)
        altitude, echoes = sounding(np.array(pose), self._mounds)
        return Sounding(altitude, echoes)

    def grid(self, cell_m: float) -> Array:
        """Return the depth (k, k) [m] on a square grid out to REACH_M: north, then east."""
        count = 2 * round(REACH_M / cell_m) + 1
        along = np.array([(i - (count - 1) / 2) * cell_m for i in range(count)])
        if self._mounds is None:
            return np.full((count, count), self.depth_m)
        depths = np.empty((count, count))
        write_depth_grid(
            along + self._mounds.north, along + self._mounds.east, self._mounds, depths
        )
        return depths


@njit(cache=True, error_model="numpy")
def _smoothstep(x: float) -> tuple[float, float]:
    """Return a smooth step from 0 to 1 over 0 <= x <= 1, and its slope."""
    before, after = x <= 0.0, x >= 1.0
    return (
        select(before, 0.0, select(after, 1.0, x * x * (3.0 - 2.0 * x))),
        select(before, 0.0, select(after, 0.0, 6.0 * x * (1.0 - x))),
    )


@njit(cache=True, error_model="numpy")
def height_and_slope(north: float, east: float, mounds: Mounds) -> tuple[float, float, float]:
    """Return the height over the flat bottom at a position [m], and its slopes north and east."""
    x, y = north - mounds.north, east - mounds.east
    away = sqrt(x * x + y * y)
    inner, inner_slope = _smoothstep((away - mounds.flat) / RISE_M)
    outer, outer_slope = _smoothstep((REACH_M - away) / RISE_M)
    share = inner * outer
    raised = share != 0.0
    zero = like(x, 0.0)
    if not some(raised):
        return zero, zero, zero
    wave, wave_x, wave_y = 0.5, 0.0, 0.0
    for i in range(mounds.waves.shape[0]):
        part, kx, ky = 0.5 * mounds.waves[i, 0], mounds.waves[i, 1], mounds.waves[i, 2]
        s, c = sincos(kx * x + ky * y + mounds.waves[i, 3])
        wave += part * s
        wave_x += part * kx * c
        wave_y += part * ky * c
    outwards = (inner_slope * outer - inner * outer_slope) / (RISE_M * away)
    height = mounds.height
    return (
        select(raised, height * share * wave, zero),
        select(raised, height * (share * wave_x + outwards * x * wave), zero),
        select(raised, height * (share * wave_y + outwards * y * wave), zero),
    )


@njit(cache=True, error_model="numpy")
def write_depth_grid(north: Array, east: Array, mounds: Mounds, out: Array) -> None:
    """Write the bottom's depth at (k,) times (l,) positions [m] to `out`, (k, l)."""
    for i in range(north.size):
        for j in range(east.size):
            out[i, j] = mounds.depth - height_and_slope(north[i], east[j], mounds)[0]


@njit(cache=True, error_model="numpy")
def cast_ray(
    start: tuple[float, float, float], direction: tuple[float, float, float], mounds: Mounds
) -> tuple[float, float]:
    """Return where a ray hits the bottom: range [m] and cosine of the angle of incidence.

    `direction` is a unit vector. A ray that hits nothing within BEAM_RANGE_M gives inf and 0. Each
    step is as long as the steepest slope allows without passing the bottom.
    """
    x, y, z = start
    a, b, c = direction
    closing = c + mounds.steepest * math.sqrt(a * a + b * b)
    if closing <= 0.0:
        return math.inf, 0.0
    far = 0.0
    for _ in range(_MAX_STEPS):
        height, slope_x, slope_y = height_and_slope(x + far * a, y + far * b, mounds)
        gap = mounds.depth - height - (z + far * c)
        if gap < _TOLERANCE_M:
            facing = c + slope_x * a + slope_y * b
            return far, facing / math.sqrt(1.0 + slope_x * slope_x + slope_y * slope_y)
        far += gap / closing
        if far > BEAM_RANGE_M:
            break
    return math.inf, 0.0


@njit(cache=True, error_model="numpy")
def sounding(pose: Array, mounds: Mounds) -> tuple[float, int]:
    """Return the mean height over the hits of the four beams [m], and the number of echoes."""
    sr, cr = sincos(pose[3])
    sp, cp = sincos(pose[4])
    sy, cy = sincos(pose[5])
    start = (pose[0], pose[1], pose[2])
    total, echoes = 0.0, 0
    for forward in (1.0, -1.0):
        for starboard in (1.0, -1.0):
            a, b = forward * mounds.beam_side, starboard * mounds.beam_side
            across = cr * b - sr * mounds.beam_down  # roll, then pitch, then yaw
            down = sr * b + cr * mounds.beam_down
            along, sinking = cp * a + sp * down, cp * down - sp * a
            direction = (cy * along - sy * across, sy * along + cy * across, sinking)
            far, facing = cast_ray(start, direction, mounds)
            if facing >= mounds.flattest:
                total += far * sinking
                echoes += 1
    if echoes == 0:
        return mounds.depth - pose[2], 0
    return total / echoes, echoes
