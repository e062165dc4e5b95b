"""Projective geometry of the camera: its pose, and maps between pixels and planes.

A plane is a point P0 and two edges e1, e2. With M = [e1 e2 P0 - C] in camera axes, a pixel's ray
(x, y, 1) gives (a, b, 1) / z = M^-1 (x, y, 1): coordinates (a, b) on the plane and inverse depth.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.numerics.libm import sincos
from seamark.sim.numerics.stack import on_stack

Array = NDArray[np.float64]
RowMap = tuple[np.float32, np.float32, np.float32, np.float32, np.float32, np.float32]


@njit(cache=True, nogil=True, error_model="numpy")
def camera_pose(pose: Array, mount: Array, rotation: Array, centre: Array) -> None:
    """Write the camera axes in the world frame as rows of (3, 3) and its position (3,) [m].

    Parameters
    ----------
    pose : (6,) [m, rad]
        North, east, down, roll, pitch, yaw of the body.
    mount : (3,) [m]
        Position of the camera in the body frame; it looks along body z, image right is body y.
    """
    sr, cr = sincos(pose[3])
    sp, cp = sincos(pose[4])
    sy, cy = sincos(pose[5])
    # Columns of Rz Ry Rx are the body axes in the world; camera x = body y, y = -body x, z = z.
    rotation[0, 0] = cy * sp * sr - sy * cr
    rotation[0, 1] = sy * sp * sr + cy * cr
    rotation[0, 2] = cp * sr
    rotation[1, 0] = -(cy * cp)
    rotation[1, 1] = -(sy * cp)
    rotation[1, 2] = sp
    rotation[2, 0] = cy * sp * cr + sy * sr
    rotation[2, 1] = sy * sp * cr - cy * sr
    rotation[2, 2] = cp * cr
    for i in range(3):
        forward = -rotation[1, i] * mount[0]
        centre[i] = pose[i] + (forward + rotation[0, i] * mount[1]) + rotation[2, i] * mount[2]


@njit(cache=True, nogil=True, error_model="numpy")
def plane_homography(
    plane: Array, rotation: Array, centre: Array, intrinsics: Array, g: Array
) -> bool:
    """Write g (3, 3): pixel (u, v, 1) -> (a / z, b / z, 1 / z) for the plane's coordinates a, b.

    Returns False when the camera lies in the plane.
    """
    m = on_stack(np.float64, 3, 3)
    for i in range(3):
        e1 = 0.0
        e2 = 0.0
        p0 = 0.0
        for j in range(3):
            e1 += rotation[i, j] * plane[3 + j]
            e2 += rotation[i, j] * plane[6 + j]
            p0 += rotation[i, j] * (plane[j] - centre[j])
        m[i, 0] = e1
        m[i, 1] = e2
        m[i, 2] = p0
    f = intrinsics[0]
    determinant = 0.0
    for i in range(3):
        # Row i of the adjugate is the cross product of the two other columns.
        p = (i + 1) % 3
        q = (i + 2) % 3
        for k in range(3):
            k1 = (k + 1) % 3
            k2 = (k + 2) % 3
            g[i, k] = m[k1, p] * m[k2, q] - m[k2, p] * m[k1, q]
        if i == 0:
            determinant = g[0, 0] * m[0, 0] + g[0, 1] * m[1, 0] + g[0, 2] * m[2, 0]
    if abs(determinant) < 1e-12:
        return False
    for i in range(3):
        x = g[i, 0] / determinant
        y = g[i, 1] / determinant
        g[i, 2] = g[i, 2] / determinant - (x * intrinsics[1] + y * intrinsics[2]) / f
        g[i, 0] = x / f
        g[i, 1] = y / f
    return True


@njit(cache=True, nogil=True, error_model="numpy")
def project(points: Array, rotation: Array, centre: Array, intrinsics: Array, out: Array) -> None:
    """Write the image points (n, 2) [px] of world points (n, 3) [m].

    A point at or behind the camera's plane becomes NaN.
    """
    for k in range(points.shape[0]):
        x = 0.0
        y = 0.0
        z = 0.0
        for j in range(3):
            d = points[k, j] - centre[j]
            x += rotation[0, j] * d
            y += rotation[1, j] * d
            z += rotation[2, j] * d
        if z > 1e-6:
            out[k, 0] = intrinsics[0] * x / z + intrinsics[1]
            out[k, 1] = intrinsics[0] * y / z + intrinsics[2]
        else:
            out[k, 0] = np.nan
            out[k, 1] = np.nan


@njit(cache=True, nogil=True, error_model="numpy")
def visible_faces(faces: Array, centre: Array) -> NDArray[np.bool_]:
    """Return (n,) which of the faces (n, 12) face the camera."""
    seen = np.zeros(faces.shape[0], np.bool_)
    for k in range(faces.shape[0]):
        d = 0.0
        for j in range(3):
            d += (centre[j] - faces[k, j]) * faces[k, 9 + j]
        seen[k] = d > 1e-6
    return seen


@njit(cache=True, nogil=True, error_model="numpy")
def map_along_row(g: Array, v: float) -> RowMap:
    """Return a homography along image row v, float32: values at column 0, then per column."""
    return (
        np.float32(g[0, 1] * v + g[0, 2]),
        np.float32(g[1, 1] * v + g[1, 2]),
        np.float32(g[2, 1] * v + g[2, 2]),
        np.float32(g[0, 0]),
        np.float32(g[1, 0]),
        np.float32(g[2, 0]),
    )


@njit(cache=True, error_model="numpy")
def diagonal_intersection(corners: Array) -> tuple[float, float]:
    """Return where the diagonals of a quadrilateral meet: the image of a rectangle's centre.

    `corners` is (8,) [px], x0 y0 to x3 y3. The mean of the corners if the diagonals are parallel.
    """
    x0, y0, x1, y1 = corners[0], corners[1], corners[2], corners[3]
    x2, y2, x3, y3 = corners[4], corners[5], corners[6], corners[7]
    ax, ay, bx, by = x2 - x0, y2 - y0, x3 - x1, y3 - y1
    determinant = ax * by - ay * bx
    if abs(determinant) < 1e-9:
        return 0.25 * (x0 + x1 + x2 + x3), 0.25 * (y0 + y1 + y2 + y3)
    share = ((x1 - x0) * by - (y1 - y0) * bx) / determinant
    return x0 + share * ax, y0 + share * ay
