"""Visual station keeper: from the target's place in the picture to how far the vehicle has to move.

The station is right above the target's top face, at the height of the level's start.
"""

import math
from dataclasses import dataclass

from sim.elementary import sincos

HOLD_S = 1.0  # [s] how long the last error counts after the target was lost; E
SMALLEST_SIDE_PX = 2.0  # [px] a shorter side tells nothing about the height
Corners = list[float]  # x0 y0 .. x3 y3 [px]: upper left, upper right, lower right, lower left


@dataclass(frozen=True, slots=True, kw_only=True)
class Geometry:
    """What the station keeper knows beforehand."""

    focal_px: float
    centre_px: tuple[float, float]
    height_m: float  # wanted height of the camera above the target's top
    size_m: tuple[float, float]  # the target's length (image X) and width (image Y)


@dataclass(slots=True)
class Aim:
    """What the program is told about the target."""

    error: tuple[float, float, float] = (0.0, 0.0, 0.0)  # [m] body frame
    error_px: tuple[float, float] = (0.0, 0.0)
    visible: bool = False
    age_s: float = 0.0


class StationKeeper:
    """Turns tracked corners into an error in metres; one instance per level."""

    def __init__(self, geometry: Geometry, *, range_from: str, level_out_tilt: bool) -> None:
        self._geometry = geometry
        self._range_from = range_from
        self._level_out_tilt = level_out_tilt
        self._aim = Aim()

    def step(
        self,
        corners: Corners | None,
        *,
        height: float,
        tilt: tuple[float, float],
        dt: float,
    ) -> Aim:
        """Return the aim for a picture.

        Parameters
        ----------
        corners : list of 8 [px] or None
            None while the tracker has lost the target: the last error counts for another
            `HOLD_S`, then the error is zero and the vehicle stays where it is.
        height : float [m]
            Measured height of the camera above the target.
        tilt : (2,) [rad]
            Measured roll and pitch.
        """
        aim = self._aim
        aim.visible = corners is not None
        if corners is None:
            aim.age_s += dt
            if aim.age_s > HOLD_S:
                aim.error, aim.error_px = (0.0, 0.0, 0.0), (0.0, 0.0)
            return aim
        aim.age_s = 0.0
        u, v = crossing(corners)
        aim.error_px = (u - self._geometry.centre_px[0], v - self._geometry.centre_px[1])
        distance = self._distance(corners, height)
        right, aft, deep = self._direction(aim.error_px, tilt)
        aim.error = (
            -distance * aft / deep,
            distance * right / deep,
            distance - self._geometry.height_m,
        )
        return aim

    def _distance(self, corners: Corners, height: float) -> float:
        if self._range_from == "start":
            return self._geometry.height_m
        if self._range_from == "altitude":
            return height
        return self._distance_by_size(corners)

    def _distance_by_size(self, corners: Corners) -> float:
        x0, y0, x1, y1, x2, y2, x3, y3 = corners
        long = 0.5 * (_length(x1 - x0, y1 - y0) + _length(x2 - x3, y2 - y3))
        short = 0.5 * (_length(x3 - x0, y3 - y0) + _length(x2 - x1, y2 - y1))
        if min(long, short) < SMALLEST_SIDE_PX:
            return self._geometry.height_m
        length, width = self._geometry.size_m
        return 0.5 * self._geometry.focal_px * (length / long + width / short)

    def _direction(
        self, error_px: tuple[float, float], tilt: tuple[float, float]
    ) -> tuple[float, float, float]:
        """Return the ray to the target: to starboard, aft, down."""
        right, aft = error_px[0] / self._geometry.focal_px, error_px[1] / self._geometry.focal_px
        if not self._level_out_tilt:
            return right, aft, 1.0
        sin_roll, cos_roll = sincos(tilt[0])
        sin_pitch, cos_pitch = sincos(tilt[1])
        side = right * cos_roll - sin_roll
        down = right * sin_roll + cos_roll
        return side, aft * cos_pitch - down * sin_pitch, down * cos_pitch + aft * sin_pitch


def crossing(corners: Corners) -> tuple[float, float]:
    """Return where the diagonals cross: the image of the face's centre under any perspective.

    For corners without a proper crossing, their mean.
    """
    x0, y0, x1, y1, x2, y2, x3, y3 = corners
    ax, ay, bx, by = x2 - x0, y2 - y0, x3 - x1, y3 - y1
    determinant = ax * by - ay * bx
    if abs(determinant) < 1e-9:
        return 0.25 * (x0 + x1 + x2 + x3), 0.25 * (y0 + y1 + y2 + y3)
    share = ((x1 - x0) * by - (y1 - y0) * bx) / determinant
    return x0 + share * ax, y0 + share * ay


def _length(x: float, y: float) -> float:
    return math.sqrt(x * x + y * y)
