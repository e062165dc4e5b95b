"""Visual station keeper: from the target's place in the picture to how far the vehicle has to move.

The station is right above the target's top face, at the height of the level's start.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import njit

from seamark.sim.engine.tracking_error import crossing
from seamark.sim.numerics.libm import sincos
from seamark.sim.vehicles import Array

HOLD_S = 1.0  # [s] how long the last error counts after the target was lost; E
SMALLEST_SIDE_PX = 2.0  # [px] a shorter side tells nothing about the height
RANGES = ("start", "altitude", "size")  # from what the distance of the target is known
_START, _ALTITUDE, _SIZE = range(len(RANGES))
Record = Any  # one of KEEPER; Numba reads its fields as attributes

KEEPER = np.dtype(
    [
        ("focal", "f8"),  # [px]
        ("centre", "f8", 2),  # [px]
        ("height", "f8"),  # [m] wanted height of the camera above the target's top
        ("size", "f8", 2),  # [m] the target's length (image X) and width (image Y)
        ("range_from", "i8"),  # place in RANGES
        ("error", "f8", 3),  # [m] body frame
        ("error_px", "f8", 2),
        ("age_s", "f8"),
        ("visible", "?"),
        ("level_out", "?"),  # whether tilt is taken out of the direction
    ]
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Geometry:
    """What the station keeper knows beforehand."""

    focal_px: float
    centre_px: tuple[float, float]
    height_m: float  # wanted height of the camera above the target's top
    size_m: tuple[float, float]  # the target's length (image X) and width (image Y)


@dataclass(frozen=True, slots=True)
class Aim:
    """What the program is told about the target."""

    error: tuple[float, ...]  # (3,) [m] body frame
    error_px: tuple[float, ...]  # (2,)
    visible: bool
    age_s: float


class StationKeeper:
    """Turns tracked corners into an error in metres; one instance per level.

    `record` is (1,) `KEEPER`: what it knows, and what it last said.
    """

    def __init__(self, geometry: Geometry, *, range_from: str, level_out_tilt: bool) -> None:
        self.record = np.zeros(1, KEEPER)
        self.record["focal"], self.record["centre"] = geometry.focal_px, geometry.centre_px
        self.record["height"], self.record["size"] = geometry.height_m, geometry.size_m
        self.record["range_from"] = RANGES.index(range_from)
        self.record["level_out"] = level_out_tilt

    def step(
        self,
        corners: Sequence[float] | None,
        *,
        height: float,
        tilt: tuple[float, float],
        dt: float,
    ) -> Aim:
        """Return the aim for a picture; `corners` (8,) [px] or None, the rest as for `aim`."""
        seen = np.zeros(8) if corners is None else np.array(corners, np.float64)
        aim(self.record[0], seen, corners is not None, height, tilt, dt)
        said = self.record[0]
        return Aim(
            tuple(said["error"].tolist()),
            tuple(said["error_px"].tolist()),
            bool(said["visible"]),
            float(said["age_s"]),
        )


@njit(cache=True, error_model="numpy")
def aim(
    keeper: Record,
    corners: Array,
    visible: bool,
    height: float,
    tilt: tuple[float, float],
    dt: float,
) -> None:
    """Tell where the vehicle has to go, in the keeper's record.

    Parameters
    ----------
    corners : (8,) [px]
        x0 y0 to x3 y3: upper left, upper right, lower right, lower left.
    visible : bool
        False while the tracker has lost the target: the last error counts for another `HOLD_S`,
        then the error is zero and the vehicle stays where it is.
    height : float [m]
        Measured height of the camera above the target.
    tilt : (2,) [rad]
        Measured roll and pitch.
    """
    keeper.visible = visible
    if not visible:
        keeper.age_s += dt
        if keeper.age_s > HOLD_S:
            keeper.error[:] = 0.0
            keeper.error_px[:] = 0.0
        return
    keeper.age_s = 0.0
    u, v = crossing(corners)
    keeper.error_px[0] = u - keeper.centre[0]
    keeper.error_px[1] = v - keeper.centre[1]
    distance = _distance(keeper, corners, height)
    right, aft, deep = _direction(keeper, tilt)
    keeper.error[0] = -distance * aft / deep
    keeper.error[1] = distance * right / deep
    keeper.error[2] = distance - keeper.height


@njit(cache=True, error_model="numpy")
def _distance(keeper: Record, corners: Array, height: float) -> float:
    if keeper.range_from == _START:
        wanted: float = keeper.height
        return wanted
    return height if keeper.range_from == _ALTITUDE else _distance_by_size(keeper, corners)


@njit(cache=True, error_model="numpy")
def _distance_by_size(keeper: Record, corners: Array) -> float:
    long = 0.5 * (_side(corners, 0, 1) + _side(corners, 3, 2))
    short = 0.5 * (_side(corners, 0, 3) + _side(corners, 1, 2))
    distance: float
    if long < SMALLEST_SIDE_PX or short < SMALLEST_SIDE_PX:
        distance = keeper.height
    else:
        distance = 0.5 * keeper.focal * (keeper.size[0] / long + keeper.size[1] / short)
    return distance


@njit(cache=True, error_model="numpy")
def _direction(keeper: Record, tilt: tuple[float, float]) -> tuple[float, float, float]:
    """Return the ray to the target: to starboard, aft, down."""
    right, aft = keeper.error_px[0] / keeper.focal, keeper.error_px[1] / keeper.focal
    if not keeper.level_out:
        return right, aft, 1.0
    sin_roll, cos_roll = sincos(tilt[0])
    sin_pitch, cos_pitch = sincos(tilt[1])
    side = right * cos_roll - sin_roll
    down = right * sin_roll + cos_roll
    return side, aft * cos_pitch - down * sin_pitch, down * cos_pitch + aft * sin_pitch


@njit(cache=True, error_model="numpy")
def _side(corners: Array, a: int, b: int) -> float:
    """Return the distance of two corners [px]."""
    x, y = corners[2 * b] - corners[2 * a], corners[2 * b + 1] - corners[2 * a + 1]
    return math.sqrt(x * x + y * y)
