"""A pipe on the seabed in the rows of an image, before the water acts on them.

Each pixel's ray is intersected with the half cylinders of the pipe in closed form, in the plane
across each of them. How bright the pipe is there is painted once: along it in steps of `STEP_M`,
and across it in `ACROSS` steps. Only + - * / and sqrt are used, so every processor gives the same
bits.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.camera.geometry import plane_homography
from seamark.sim.camera.seabed import hash01
from seamark.sim.numerics.arrays import Array
from seamark.sim.physics.pipe import Pipe, sand_on

STEP_M, ACROSS = 0.02, 32  # E: two pixels from the height of the following
BARE_SAND = -1.0  # in place of a radiance: the pipe is covered
_FAR = 2.0  # E: pieces farther away than this many heights of the camera are not in the image
JOINT_EACH_M, JOINT_M = 4.0, 0.25  # E: field joints; real ones are 12 m apart (a pipe's length)
JOINT_LIGHT = 0.22  # E: of the joints' coating relative to white, beside the rest's
_PATCH_M = 0.12  # E: of growth
GROWTH_ALBEDO = (0.30, 0.34, 0.22)  # E: red, green, blue of algae and crust
GROWTH_SHARE = 0.7  # E: how much of the coating the thickest growth hides
_DIFFUSE, _DIRECT = 0.35, 0.65  # E: light from all sides and from above, on the top of the pipe
_RAGGED = 0.35  # E: how far the edge of the sand goes up and down, in radii


class Across(NamedTuple):
    """The camera beside one straight piece, in axes across, along and up from its start."""

    across: float  # [m] of the camera
    along: float
    height: float
    direction: tuple[float, float]  # north and east of the piece
    length: float
    start: float  # [m] arc length
    slack: float  # [m] how far the piece goes on at both ends, so that bends have no gaps


@njit(cache=True, nogil=True, error_model="numpy")
def ground_map(rotation: Array, centre: Array, intrinsics: Array, seabed_m: float) -> Array:
    """Return (3, 3) pixel -> n/z, e/z, 1/z: north and east of the camera on the seabed [m]."""
    plane = np.zeros(12)
    plane[0], plane[1], plane[2] = centre[0], centre[1], seabed_m
    plane[3] = plane[7] = 1.0
    g = np.empty((3, 3))
    plane_homography(plane, rotation, centre, intrinsics, g)
    return g


@njit(cache=True, nogil=True, error_model="numpy")
def draw_pipe(
    pipe: Pipe,
    paint: NDArray[np.float32],
    view: tuple[Array, Array],
    extent: tuple[int, int, int],
    light: NDArray[np.float32],
) -> None:
    """Draw the pipe over the radiances [grey] of a strip of rows of the seabed.

    Parameters
    ----------
    paint : (steps along, ACROSS)
        What `painted` returns.
    view
        What `ground_map` returns, and the camera's position (3,) [m].
    extent
        Row and column of the strip's first pixel, and its width [px].
    """
    g, centre = view
    height = pipe.seabed_m - centre[2]
    if height <= pipe.radius_m:
        return  # inside the pipe or below
    row, start, width = extent
    for k in range(pipe.starts_m.shape[0] - 1):
        north = pipe.axis_m[k + 1, 0] - pipe.axis_m[k, 0]
        east = pipe.axis_m[k + 1, 1] - pipe.axis_m[k, 1]
        length = pipe.starts_m[k + 1] - pipe.starts_m[k]
        north, east = north / length, east / length
        x, y = centre[0] - pipe.axis_m[k, 0], centre[1] - pipe.axis_m[k, 1]
        along, across = north * x + east * y, north * y - east * x
        beyond = max(-along, along - length)
        if max(abs(across), beyond) > _FAR * height:
            continue
        piece = Across(
            across, along, height, (north, east), length, pipe.starts_m[k], 0.25 * pipe.radius_m
        )
        for r in range(light.shape[0] // width):
            line = light[r * width : (r + 1) * width]
            _draw_piece(paint, pipe.radius_m, piece, g, (row + r, start), line)


@njit(cache=True, nogil=True, error_model="numpy")
def _draw_piece(
    paint: NDArray[np.float32],
    radius: float,
    piece: Across,
    g: Array,
    first: tuple[int, int],
    line: NDArray[np.float32],
) -> None:
    """Draw one straight piece in one row, which begins at this row and column of the image."""
    north, east = piece.direction
    v = float(first[0])
    # Along the row, what is across and along on the ground is (a + b u) / (c + d u).
    n0, e0, c = g[0, 1] * v + g[0, 2], g[1, 1] * v + g[1, 2], g[2, 1] * v + g[2, 2]
    n1, e1, d = g[0, 0], g[1, 0], g[2, 0]
    across = (piece.across * c + north * e0 - east * n0, piece.across * d + north * e1 - east * n1)
    along = (piece.along * c + north * n0 + east * e0, piece.along * d + north * n1 + east * e1)
    end = piece.slack + radius
    low, high = float(first[1]), float(first[1] + line.shape[0] - 1)
    low, high = _between(across, (c, d), _seen_across(piece, radius), (low, high))
    low, high = _between(along, (c, d), (-end, piece.length + end), (low, high))
    for u in range(math.ceil(low), math.floor(high) + 1):
        z = 1.0 / (c + d * u)
        x = (across[0] + across[1] * u) * z
        share = _hit(piece, x, radius)
        if share < 0.0:
            continue
        t = piece.along + share * ((along[0] + along[1] * u) * z - piece.along)
        if t < -piece.slack or t > piece.length + piece.slack:
            continue
        x = (piece.across + share * (x - piece.across)) / radius
        i = min(max(int((piece.start + t) / STEP_M), 0), paint.shape[0] - 1)
        radiance = paint[i, min(max(int(0.5 * ACROSS * (x + 1.0)), 0), ACROSS - 1)]
        if radiance >= 0.0:
            line[u - first[1]] = radiance


@njit(cache=True, nogil=True, error_model="numpy")
def _seen_across(piece: Across, radius: float) -> tuple[float, float]:
    """Return between which places across, on the ground, a ray can hit the pipe [m]."""
    square = piece.across * piece.across + piece.height * piece.height
    root = piece.height * math.sqrt(square - radius * radius)
    right, left = radius * piece.across + root, radius * piece.across - root
    most = radius * square / right if right > 0.0 else radius
    least = radius * square / left if left < 0.0 else -radius
    return min(least, -radius), max(most, radius)


@njit(cache=True, nogil=True, error_model="numpy")
def _between(
    value: tuple[float, float],
    scale: tuple[float, float],
    bounds: tuple[float, float],
    columns: tuple[float, float],
) -> tuple[float, float]:
    """Return the columns u of a range at which (a + b u) / (c + d u) is within bounds."""
    low, high = columns
    for k in range(2):
        sign = 1.0 if k == 0 else -1.0
        # sign (a + b u - bound (c + d u)) >= 0, with c + d u > 0 below the horizon
        rest = sign * (value[0] - bounds[k] * scale[0])
        slope = sign * (value[1] - bounds[k] * scale[1])
        if slope > 0.0:
            low = max(low, -rest / slope)
        elif slope < 0.0:
            high = min(high, -rest / slope)
        elif rest < 0.0:
            high = low - 1.0
    return low, high


@njit(cache=True, nogil=True, error_model="numpy")
def _hit(piece: Across, x: float, radius: float) -> float:
    """Return which share of the way to a place x across on the ground is free; -1: all of it."""
    run = x - piece.across
    a = run * run + piece.height * piece.height
    b = piece.across * run - piece.height * piece.height
    c = piece.across * piece.across + piece.height * piece.height - radius * radius
    square = b * b - a * c
    if square < 0.0:
        return -1.0
    share = (-b - math.sqrt(square)) / a
    return share if share <= 1.0 else -1.0


@njit(cache=True, nogil=True, error_model="numpy")
def painted(pipe: Pipe, channel: int) -> NDArray[np.float32]:
    """Return the radiances [grey] of a pipe in one channel, (steps along, ACROSS).

    `BARE_SAND` where sand covers it.
    """
    count = int(pipe.starts_m[-1] / STEP_M) + 1
    out = np.full((count, ACROSS), BARE_SAND, np.float32)
    for i in range(count):
        along = (i + 0.5) * STEP_M
        sand = sand_on(pipe, along)
        for j in range(ACROSS):
            across = (j + 0.5) * 2.0 / ACROSS - 1.0
            up = math.sqrt(1.0 - across * across)
            ragged = _RAGGED * (_noise(along, across, pipe.seed + 7) - 0.5) if sand > 0.0 else 0.0
            if up > (1.0 + 0.5 * _RAGGED) * sand + ragged:
                light = _DIFFUSE + _DIRECT * up
                out[i, j] = 255.0 * light * _albedo(pipe, along, across, channel)
    return out


@njit(cache=True, nogil=True, error_model="numpy")
def _albedo(pipe: Pipe, along: float, across: float, channel: int) -> float:
    """Return the albedo at an arc length and a place across, in radii."""
    albedo = float(pipe.coat[channel])
    if along - JOINT_EACH_M * math.floor(along / JOINT_EACH_M) < JOINT_M:
        albedo = 0.5 * albedo + JOINT_LIGHT
    growth = GROWTH_SHARE * max(0.0, 2.0 * _noise(along, across, pipe.seed) - 0.9)
    return albedo + growth * (GROWTH_ALBEDO[channel] - albedo)


@njit(cache=True, nogil=True, error_model="numpy")
def _noise(along: float, across: float, seed: int) -> float:
    """Return smooth noise in [0, 1) in patches along and across the pipe."""
    x, y = along / _PATCH_M, 1.5 * across + 8.0
    i, j = math.floor(x), math.floor(y)
    a, b = x - i, y - j
    a, b = a * a * (3.0 - 2.0 * a), b * b * (3.0 - 2.0 * b)
    left = hash01(i, j, seed) * (1.0 - b) + hash01(i, j + 1, seed) * b
    right = hash01(i + 1, j, seed) * (1.0 - b) + hash01(i + 1, j + 1, seed) * b
    return float(left * (1.0 - a) + right * a)
