"""Visual station keeping: from the target's corners in the image to the position error.

The station is directly above the centre of the target's top face, at the height at which the level
started.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import njit

from seamark.sim.camera.geometry import diagonal_intersection
from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.libm import sincos

HOLD_S = 1.0  # [s] how long the last error is kept after the target was lost; E
SMALLEST_SIDE_PX = 2.0  # [px] a shorter side gives no usable distance
RANGES = ("start", "altitude", "size")  # sources of the distance to the target
_START, _ALTITUDE, _SIZE = range(len(RANGES))
Record = Any  # a record of KEEPER; Numba reads its fields as attributes

KEEPER = np.dtype(
    [
        ("focal", "f8"),  # [px]
        ("centre", "f8", 2),  # [px]
        ("height", "f8"),  # [m] desired height of the camera above the target's top
        ("size", "f8", 2),  # [m] the target's length (image X) and width (image Y)
        ("range_from", "i8"),  # index in RANGES
        ("error", "f8", 3),  # [m] body frame
        ("error_px", "f8", 2),
        ("age_s", "f8"),  # since the target was last seen
        ("visible", "?"),
        ("level_out", "?"),  # whether the direction is corrected for tilt
    ]
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Geometry:
    """What the station keeper knows in advance."""

    focal_px: float
    centre_px: tuple[float, float]
    height_m: float  # desired height of the camera above the target's top
    size_m: tuple[float, float]  # the target's length (image X) and width (image Y)


class StationKeeper:
    """The station keeper of one level: its settings and last result in `record`, (1,) `KEEPER`."""

    def __init__(self, geometry: Geometry, *, range_from: str, level_out_tilt: bool) -> None:
        self.record = np.zeros(1, KEEPER)
        self.record["focal"], self.record["centre"] = geometry.focal_px, geometry.centre_px
        self.record["height"], self.record["size"] = geometry.height_m, geometry.size_m
        self.record["range_from"] = RANGES.index(range_from)
        self.record["level_out"] = level_out_tilt


@njit(cache=True, error_model="numpy")
def update_position_error(
    keeper: Record,
    corners: Array,
    visible: bool,
    height: float,
    tilt: tuple[float, float],
    dt: float,
) -> None:
    """Update the position error in the record of the station keeper.

    Parameters
    ----------
    corners : (8,) [px]
        x0 y0 to x3 y3: upper left, upper right, lower right, lower left.
    visible : bool
        False while the tracker has lost the target: the last error is kept for `HOLD_S`, then the
        error is zero, so the vehicle stays where it is.
    height : float [m]
        Measured height of the camera above the target.
    tilt : (2,) [rad]
        Measured roll and pitch.
    dt : float [s]
        Control period.
    """
    keeper.visible = visible
    if not visible:
        keeper.age_s += dt
        if keeper.age_s > HOLD_S:
            keeper.error[:] = 0.0
            keeper.error_px[:] = 0.0
        return
    keeper.age_s = 0.0
    u, v = diagonal_intersection(corners)
    keeper.error_px[0] = u - keeper.centre[0]
    keeper.error_px[1] = v - keeper.centre[1]
    distance = _distance(keeper, corners, height)
    right, aft, down = _direction(keeper, tilt)
    keeper.error[0] = -distance * aft / down
    keeper.error[1] = distance * right / down
    keeper.error[2] = distance - keeper.height


@njit(cache=True, error_model="numpy")
def _distance(keeper: Record, corners: Array, height: float) -> float:
    if keeper.range_from == _START:
        desired: float = keeper.height
        return desired
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
    """Return the ray to the target: starboard, aft, down."""
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
    """Return the distance between two corners [px]."""
    x, y = corners[2 * b] - corners[2 * a], corners[2 * b + 1] - corners[2 * a + 1]
    return math.sqrt(x * x + y * y)
