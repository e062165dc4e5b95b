"""The inner loops of the ray-caster over a strip of rows, with the same bits on every processor.

Each loop runs from 0 over slices, which is what lets LLVM vectorise it; without `fastmath` LLVM
neither reorders nor contracts, so a lane of a vector has the same bits as the scalar remainder. A
pixel's value depends only on its absolute column, never on where the slice starts.
"""

from typing import TYPE_CHECKING

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.camera.geometry import map_along_row
from seamark.sim.camera.seabed import STRIDE, TILE
from seamark.sim.numerics.simd import (
    WIDTH,
    f32x16,
    fetch_pairs,
    i32x16,
    load,
    load_i32,
    maximum,
    minimum,
    sqrt,
    store,
    store_i32,
    store_u8,
    to_f32,
    to_i32,
)
from seamark.sim.numerics.stack import on_stack
from seamark.sim.numerics.uncounted import uncounted

if TYPE_CHECKING:
    from seamark.sim.numerics.simd import F32x16, I32x16

Row = NDArray[np.float32]
Rows = NDArray[np.float32]
Texels = NDArray[np.uint16]
Places = NDArray[np.int32]

_F = np.float32
BIAS = 4096  # [texel] keeps the coordinates positive, so that int() rounds down
_REACH = _F(4000.0)  # [texel] 20 m: beyond it the edge of the texture is repeated
NODE = 16  # [px] distance of the points at which the seabed's transmission is computed
STEPS = np.arange(NODE, dtype=np.float32)[None]
_LINES = 128  # rows of seabed whose maps are kept at once
_LAG = 3  # rows from locating pixels to reading their texels, and from there to their grey values
_RING = 8  # rows under way, a power of two above 2 _LAG
_PIXELS = _RING * WIDTH
_BOTH = 2 * WIDTH  # fractions in u and in v
CHUNK = 32  # [px] loops over a multiple of this compile to whole vectors


@uncounted
def seabed_light(
    tile: Texels,
    ground: NDArray[np.float64],
    extent: tuple[int, int, int],
    shift: tuple[int, int],
    out: Row,
) -> None:
    """Write bilinear samples [grey] of the seabed for a strip of rows.

    Parameters
    ----------
    tile : (n,)
        The seabed's packed texels.
    ground : (3, 3)
        Pixel (u, v, 1) -> a/z, b/z, 1/z [texel, 1/m].
    extent : tuple
        Row and column of the strip's first pixel, and its width [px].
    shift : tuple
        Texels that a and b are counted from.
    """
    row, start, width = extent
    blocks = out.reshape(out.shape[0] // NODE, NODE)
    across = width // NODE
    height = blocks.shape[0] // across
    lines = on_stack(np.float32, _LINES, 3)
    for top in range(0, height, _LINES):
        count = min(_LINES, height - top)
        _, _, _, a, b, w = map_along_row(ground, 0.0)
        for r in range(count):
            lines[r, 0], lines[r, 1], lines[r, 2], _, _, _ = map_along_row(
                ground, float(row + top + r)
            )
        for i in range(across):
            column = f32x16(float(start + i * NODE)) + load(STEPS, 0, 0)
            terms = f32x16(a) * column, f32x16(b) * column, f32x16(w) * column
            _sample_column(tile, lines[:count], terms, shift, blocks[top * across + i :], across)


@uncounted
def _sample_column(
    tile: Texels,
    lines: Rows,
    terms: "tuple[F32x16, F32x16, F32x16]",
    shift: tuple[int, int],
    blocks: Rows,
    across: int,
) -> None:
    """Write the samples of sixteen columns into every `across`-th block, row by row.

    `lines` (rows, 3) are the map's values at column 0 of each row, `terms` what the columns add.
    Each step of the loop finds where pixels of one row are, reads the texels of an earlier one and
    interpolates those of a still earlier one: the processor then never waits for what it has just
    written, and has work to do while the memory answers.
    """
    at, four = on_stack(np.int32, _PIXELS), on_stack(np.int32, _PIXELS)
    fractions = on_stack(np.float32, _RING, _BOTH)
    count = lines.shape[0]
    for r in range(count + 2 * _LAG):
        if r < count:
            _locate((lines[r, 0], lines[r, 1], lines[r, 2]), terms, shift, r % _RING, at, fractions)
        if _LAG <= r < count + _LAG:
            fetch_pairs(tile, at, four, (r - _LAG) % _RING * WIDTH)
        if r >= 2 * _LAG:
            k = (r - 2 * _LAG) % _RING
            fu, fv = load(fractions, k, 0), load(fractions, k, WIDTH)
            value = bilinear(load_i32(four, k * WIDTH), fu, fv)
            store(blocks, (r - 2 * _LAG) * across, 0, value)


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _locate(
    line: tuple[np.float32, np.float32, np.float32],
    terms: "tuple[F32x16, F32x16, F32x16]",
    shift: tuple[int, int],
    k: int,
    at: Places,
    fractions: Rows,
) -> None:
    """Write the texels' indices of sixteen pixels, and the fractions in u and in v, as the k-th."""
    far, near, bias = f32x16(_REACH), f32x16(-_REACH), f32x16(float(BIAS))
    z = f32x16(1.0) / maximum(f32x16(line[2]) + terms[2], f32x16(1e-3))
    u = minimum(maximum((f32x16(line[0]) + terms[0]) * z, near), far) + bias
    v = minimum(maximum((f32x16(line[1]) + terms[1]) * z, near), far) + bias
    iu, iv = to_i32(u), to_i32(v)
    across_tile = (iu + i32x16(shift[0])) & i32x16(TILE - 1)
    down_tile = (iv + i32x16(shift[1])) & i32x16(TILE - 1)
    store_i32(at, k * WIDTH, down_tile * i32x16(STRIDE) + across_tile)
    store(fractions, k, 0, u - to_f32(iu))
    store(fractions, k, WIDTH, v - to_f32(iv))


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def bilinear(four: "I32x16", fu: "F32x16", fv: "F32x16") -> "F32x16":
    """Return bilinear interpolations of the four grey values in pairs of packed texels."""
    byte = i32x16(255)
    a, c = to_f32(four & byte), to_f32((four >> i32x16(8)) & byte)
    b, d = to_f32((four >> i32x16(16)) & byte), to_f32((four >> i32x16(24)) & byte)
    top = a + fu * (b - a)
    low = c + fu * (d - c)
    return top + fv * (low - top)


@njit(cache=True, nogil=True, error_model="numpy")
def illuminate(light: Row, gain: Row, transmission: Row, veil: float) -> None:
    """Replace radiances [grey] by what reaches the camera under `gain` times daylight."""
    b = _F(veil)
    for q in range(gain.shape[0]):
        light[q] = (light[q] * gain[q] - b) * transmission[q] + b


@njit(cache=True, nogil=True, error_model="numpy")
def interpolate_nodes(nodes: NDArray[np.float32], extent: tuple[int, int, int], out: Row) -> None:
    """Write a strip of values interpolated between nodes (rows, columns) every NODE px.

    `extent` is row and column of the strip's first pixel, counted from the first node, and its
    width; the column is that of a node.
    """
    row, start, width = extent
    first = start // NODE
    blocks = out.reshape(out.shape[0] // NODE, NODE)
    across = width // NODE
    steps = load(STEPS, 0, 0)
    k = 0
    for r in range(blocks.shape[0] // across):
        j = (row + r) // NODE
        share = _F((row + r - j * NODE) / NODE)
        left = _between(nodes, j, first, share)
        for i in range(across):
            right = _between(nodes, j, first + i + 1, share)
            slope = (right - left) * _F(1.0 / NODE)
            store(blocks, k, 0, f32x16(left) + f32x16(slope) * steps)
            left = right
            k += 1


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _between(nodes: NDArray[np.float32], row: int, column: int, share: np.float32) -> np.float32:
    """Return the value interpolated between a node and the one below it."""
    above = nodes[row, column]
    value: np.float32 = above + share * (nodes[row + 1, column] - above)
    return value


@njit(cache=True, nogil=True, error_model="numpy")
def attenuate(
    nodes: NDArray[np.float32], extent: tuple[int, int, int], veil: float, light: Row
) -> None:
    """Replace a strip of radiances [grey] by what reaches the camera through the water.

    `nodes` are transmissions and `extent` that of `interpolate_nodes`: both steps in one loop.
    """
    row, start, width = extent
    first = start // NODE
    blocks = light.reshape(light.shape[0] // NODE, NODE)
    across = width // NODE
    steps, b = load(STEPS, 0, 0), f32x16(veil)
    k = 0
    for r in range(blocks.shape[0] // across):
        j = (row + r) // NODE
        share = _F((row + r - j * NODE) / NODE)
        left = _between(nodes, j, first, share)
        for i in range(across):
            right = _between(nodes, j, first + i + 1, share)
            slope = (right - left) * _F(1.0 / NODE)
            transmission = f32x16(left) + f32x16(slope) * steps
            store(blocks, k, 0, (load(blocks, k, 0) - b) * transmission + b)
            left = right
            k += 1


@njit(cache=True, nogil=True, error_model="numpy")
def copy(source: Row | NDArray[np.uint8], out: Row | NDArray[np.uint8]) -> None:
    """Copy `source`; Numba does not vectorise the assignment of slices."""
    for q in range(out.shape[0]):
        out[q] = source[q]


@uncounted
def expose(
    light: Rows, noise: Rows, read_variance: float, shot_gain: float, out: NDArray[np.uint8]
) -> None:
    """Write grey values: radiance (k, 16) plus read and shot noise, rounded and clipped."""
    v0, g = f32x16(read_variance), f32x16(shot_gain)
    zero, half, top = f32x16(0.0), f32x16(0.5), f32x16(255.0)
    for k in range(light.shape[0]):
        radiance = load(light, k, 0)
        sigma = sqrt(v0 + g * maximum(radiance, zero))
        value = radiance + load(noise, k, 0) * sigma + half
        store_u8(out, k * WIDTH, to_i32(minimum(maximum(value, zero), top)))


@njit(cache=True, nogil=True, error_model="numpy")
def interleave(
    first: NDArray[np.uint8],
    second: NDArray[np.uint8],
    third: NDArray[np.uint8],
    out: NDArray[np.uint8],
) -> None:
    """Write three planes (n,) as one image (3 n,)."""
    for q in range(first.shape[0]):
        out[3 * q] = first[q]
        out[3 * q + 1] = second[q]
        out[3 * q + 2] = third[q]
