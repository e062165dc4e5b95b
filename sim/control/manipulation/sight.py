"""Where a rectangle is, from its corners in the image of a camera that looks down."""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

from seamark.sim.control.manipulation.arm_data import Vector
from seamark.sim.control.manipulation.kinematics import (
    Matrix,
    applied,
    cross,
    dot,
    length,
    minus,
    plus,
    times,
)
from seamark.sim.numerics.libm import atan2

Corners = list[float]  # (8,) [px] x0 y0 to x3 y3
_FLAT = 1e-9  # of a rectangle that is seen from the side
_TOLERANCE = 0.2  # E: sides of a rectangle that differ by more are not those of a tracked target


class Pinhole(NamedTuple):
    """The camera as a program is told: it looks along body z, image right is body y."""

    focal_px: float
    centre_px: tuple[float, float]
    mount_m: Vector

    @classmethod
    def told(cls, config: Mapping[str, Any]) -> "Pinhole":
        """Return the camera of the configuration that a program gets."""
        width, height = config["camera_width_px"], config["camera_height_px"]
        centre = 0.5 * (width - 1), 0.5 * (height - 1)
        return cls(config["camera_focal_px"], centre, tuple(config["camera_mount_m"]))


class Seen(NamedTuple):
    """A rectangle, in axes at the body's origin that are level and turned with its heading."""

    centre: Vector  # [m]
    yaw: float  # [rad] of its long side, from the vehicle's heading
    into: Vector = (0.0, 0.0, 1.0)  # unit vector into its face


def find(
    corners: Corners, size_m: tuple[float, float], camera: Pinhole, attitude: Matrix
) -> Seen | None:
    """Return where a level rectangle of known size is; None if these are not its corners.

    `attitude` takes body axes to level ones: of roll and pitch alone.
    """
    rays = _at_unit_depth(corners, camera, attitude)
    if rays is None:
        return None
    a, b, c, d = rays
    long, short = (_length(a, b), _length(d, c)), (_length(a, d), _length(b, c))
    total = long[0] + long[1] + short[0] + short[1]
    if total < _FLAT:
        return None
    depth = 2.0 * (size_m[0] + size_m[1]) / total
    for sides, true in ((long, size_m[0]), (short, size_m[1])):
        if any(abs(depth * side / true - 1.0) > _TOLERANCE for side in sides):
            return None
    x, y = (0.25 * depth * (a[i] + b[i] + c[i] + d[i]) for i in (0, 1))
    along = (b[0] - a[0] + c[0] - d[0], b[1] - a[1] + c[1] - d[1])
    mount = applied(attitude, camera.mount_m)
    return Seen(plus(mount, (x, y, depth)), atan2(along[1], along[0]))


def find_tilted(
    corners: Corners, size_m: tuple[float, float], camera: Pinhole, attitude: Matrix
) -> Seen | None:
    """Return where a rectangle of known size is, and how it is tilted; None as `find`.

    Its opposite sides are parallel, which tells how far its corners are in proportion to each
    other; its size tells how far that is. How it is tilted is a small difference of them: it needs
    many looks.
    """
    rays = _at_unit_depth(corners, camera, attitude)
    if rays is None:
        return None
    a, b, c, d = ((x, y, 1.0) for x, y in rays)
    # Far a - far b + far c = d, solved by Cramer's rule.
    bc, ca, ab = cross(b, c), cross(c, a), cross(a, b)
    whole = dot(a, bc)
    if abs(whole) < _FLAT:
        return None
    a, b, c = (times(v, dot(d, n) / whole) for v, n in ((a, bc), (times(b, -1.0), ca), (c, ab)))
    long, short = minus(b, a), minus(d, a)
    sides = length(long), length(short)
    if sides[0] + sides[1] < _FLAT:
        return None
    depth = (size_m[0] + size_m[1]) / (sides[0] + sides[1])
    if any(
        abs(depth * side / true - 1.0) > _TOLERANCE
        for side, true in zip(sides, size_m, strict=True)
    ):
        return None
    normal = cross(long, short)
    centre = plus(applied(attitude, camera.mount_m), times(plus(b, d), 0.5 * depth))
    return Seen(centre, atan2(long[1], long[0]), times(normal, 1.0 / length(normal)))


def _at_unit_depth(
    corners: Corners, camera: Pinhole, attitude: Matrix
) -> list[tuple[float, float]] | None:
    """Return where the rays of pixels are one metre below the camera, level axes; None if not."""
    rays = []
    for k in range(0, len(corners), 2):
        u, v = ((corners[k + i] - camera.centre_px[i]) / camera.focal_px for i in (0, 1))
        x, y, z = applied(attitude, (-v, u, 1.0))
        if not (z > 0.1 and math.isfinite(x + y)):
            return None
        rays.append((x / z, y / z))
    return rays


def _length(a: tuple[float, float], b: tuple[float, float]) -> float:
    return math.sqrt((b[0] - a[0]) * (b[0] - a[0]) + (b[1] - a[1]) * (b[1] - a[1]))
