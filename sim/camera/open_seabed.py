"""The seabed from a camera that may look anywhere: up to the horizon, and beyond it the veil.

Towards the horizon a pixel covers more and more texels: the contrast of the texture then fades as
their mean does, so that it does not flicker.
"""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.camera import rows
from seamark.sim.camera.geometry import map_along_row, plane_homography
from seamark.sim.camera.lighting import Lighting, Point, arriving
from seamark.sim.camera.rows import BIAS, NODE
from seamark.sim.camera.seabed import STRIDE, TEXEL_M, TILE
from seamark.sim.camera.sightings import Sight
from seamark.sim.numerics.simd import (
    f32x16,
    gather_pairs,
    i32x16,
    load,
    maximum,
    minimum,
    select_greater,
    store,
    to_f32,
    to_i32,
)
from seamark.sim.numerics.uncounted import uncounted

if TYPE_CHECKING:
    from seamark.sim.numerics.simd import F32x16

Array = NDArray[np.float64]
Row = NDArray[np.float32]
Texels = NDArray[np.uint16]

LOWEST_M = 0.005  # above the seabed; a camera that is lower is drawn from there
LEAST = 1e-3  # [1/m] inverse depth of the horizon
_REACH = np.float32(4000.0)  # [texel] 20 m: beyond it the edge of the texture is repeated
_SHARP = 2.0  # [texel] in a pixel: more of them lose contrast


class Ground(NamedTuple):
    """The seabed in one image."""

    map: Array  # (3, 3) pixel -> texel/z, texel/z, 1/z
    shift: tuple[int, int]  # texels that the map counts from
    detail: float  # [m²] contrast by the square of the inverse depth
    mean: float  # [grey] of the texture


@njit(cache=True, nogil=True, error_model="numpy")
def ground_from(sight: Sight, seabed_m: float, mean: float, intrinsics: Array) -> Ground:
    """Return the seabed as it is seen from a place above it."""
    centre = sight.centre.copy()
    height = max(seabed_m - centre[2], LOWEST_M)
    centre[2] = seabed_m - height
    north, east = np.floor(centre[0] / TEXEL_M), np.floor(centre[1] / TEXEL_M)
    plane = np.zeros(12)
    plane[0], plane[1], plane[2] = north * TEXEL_M, east * TEXEL_M, seabed_m
    plane[3], plane[7] = TEXEL_M, TEXEL_M
    g = np.zeros((3, 3))
    plane_homography(plane, sight.axes, centre, intrinsics, g)
    for k in range(3):
        g[0, k] -= 0.5 * g[2, k]
        g[1, k] -= 0.5 * g[2, k]
    detail = _SHARP * height * intrinsics[0] * TEXEL_M
    return Ground(g, (int(north) - BIAS, int(east) - BIAS), detail, mean)


@uncounted
def draw_seabed(
    ground: Ground,
    tile: Texels,
    extent: tuple[int, int, int],
    lens: Point,
    lighting: Lighting,
    gain: Row,
    hidden: NDArray[np.bool_],
    out: Row,
) -> None:
    """Write what reaches the camera [grey] of the seabed, for a strip of rows.

    `extent` is row and column of the strip's first pixel, and its width. `gain` is the light on the
    seabed, or empty for even daylight; `hidden` which NODE pixels are left out, one after another.
    """
    row, start, width = extent
    blocks = out.reshape(out.shape[0] // NODE, NODE)
    gains = gain.reshape(gain.shape[0] // NODE, NODE)
    across = width // NODE
    inverse_f, u0 = f32x16(1.0 / lens[0]), f32x16(lens[1])
    level, mean, detail = f32x16(lighting.level), f32x16(ground.mean), f32x16(ground.detail)
    one, least, veil = f32x16(1.0), f32x16(LEAST), f32x16(lighting.veil)
    steps = load(rows.STEPS, 0, 0)
    for r in range(blocks.shape[0] // across):
        a, b, w, a_slope, b_slope, w_slope = map_along_row(ground.map, float(row + r))
        y = f32x16((row + r - lens[2]) / lens[0])
        for i in range(across):
            k = r * across + i
            if hidden[k]:
                continue
            column = f32x16(float(start + i * NODE)) + steps
            inverse = f32x16(w) + f32x16(w_slope) * column
            depth = one / maximum(inverse, least)
            u = (f32x16(a) + f32x16(a_slope) * column) * depth
            v = (f32x16(b) + f32x16(b_slope) * column) * depth
            contrast = minimum(detail * inverse * inverse, one)
            light = mean + contrast * (_texel(tile, u, v, ground.shift) - mean)
            light = light * (load(gains, k, 0) if gains.shape[0] else level)
            arrived = arriving(light, depth, (column - u0) * inverse_f, y, lighting)
            store(blocks, k, 0, select_greater(inverse, least, arrived, veil))


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _texel(tile: Texels, u: "F32x16", v: "F32x16", shift: tuple[int, int]) -> "F32x16":
    """Return bilinear samples [grey] of the tile; beyond its reach they are those of its edge."""
    far, near, bias = f32x16(_REACH), f32x16(-_REACH), f32x16(float(BIAS))
    u = minimum(maximum(u, near), far) + bias
    v = minimum(maximum(v, near), far) + bias
    iu, iv = to_i32(u), to_i32(v)
    last = i32x16(TILE - 1)
    across, down = (iu + i32x16(shift[0])) & last, (iv + i32x16(shift[1])) & last
    four = gather_pairs(tile, down * i32x16(STRIDE) + across)
    return rows.bilinear(four, u - to_f32(iu), v - to_f32(iv))
