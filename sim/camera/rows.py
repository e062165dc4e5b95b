"""The hot loops of the ray-caster over a strip of rows, the same on every CPU.

Each loop runs from 0 over slices, which is what lets LLVM vectorise it; without `fastmath` LLVM
neither reorders nor contracts, so a vector lane computes the same bits as the scalar remainder. A
pixel's value depends on its absolute column alone, never on where the slice starts.
"""

from typing import TYPE_CHECKING

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.camera.geometry import row_of
from seamark.sim.camera.seabed import STRIDE, TILE
from seamark.sim.numerics.simd import (
    gather,
    lanes,
    larger,
    load,
    places,
    real,
    smaller,
    store,
    whole,
)

if TYPE_CHECKING:
    from seamark.sim.numerics.simd import Lanes, Places

Row = NDArray[np.float32]
Texels = NDArray[np.int32]

_F = np.float32
BIAS = 4096  # [texel] keeps the coordinates positive, so that int() rounds down
_REACH = _F(4000.0)  # [texel] 20 m: what lies farther repeats the texture's edge
NODE = 16  # [px] distance of the points at which the seabed's transmission is computed
STEPS = np.arange(NODE, dtype=np.float32)[None]
CHUNK = 32  # [px] what LLVM makes of a loop is whole vectors for a multiple of this


@njit(cache=True, nogil=True, error_model="numpy")
def seabed_light(
    tile: Texels,
    ground: NDArray[np.float64],
    place: tuple[int, int, int],
    shift: tuple[int, int],
    out: Row,
) -> None:
    """Write bilinear samples [grey] of the seabed for a strip of rows.

    From a pixel's place on the ground to its grey without memory in between.

    Parameters
    ----------
    tile : (n,)
        The seabed's packed texels.
    ground : (3, 3)
        Pixel (u, v, 1) -> a/z, b/z, 1/z [texel, 1/m].
    place : tuple
        Row and column of the strip's first pixel, and its width [px].
    shift : tuple
        Texels that a and b are counted from.
    """
    row, start, width = place
    blocks = out.reshape(out.shape[0] // NODE, NODE)
    across = width // NODE
    shift_u, shift_v = places(shift[0]), places(shift[1])
    steps = load(STEPS, 0, 0)
    least, far, near, bias = lanes(1e-3), lanes(_REACH), lanes(-_REACH), lanes(float(BIAS))
    for r in range(blocks.shape[0] // across):
        a, b, w, a_slope, b_slope, w_slope = row_of(ground, float(row + r))
        a0, b0, w0 = lanes(a), lanes(b), lanes(w)
        a1, b1, w1 = lanes(a_slope), lanes(b_slope), lanes(w_slope)
        for i in range(across):
            column = lanes(float(start + i * NODE)) + steps
            z = lanes(1.0) / larger(w0 + w1 * column, least)
            u = smaller(larger((a0 + a1 * column) * z, near), far) + bias
            v = smaller(larger((b0 + b1 * column) * z, near), far) + bias
            iu, iv = whole(u), whole(v)
            across_tile = (iu + shift_u) & places(TILE - 1)
            down_tile = (iv + shift_v) & places(TILE - 1)
            four = gather(tile, down_tile * places(STRIDE) + across_tile)
            store(blocks, r * across + i, 0, mixture(four, u - real(iu), v - real(iv)))


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def mixture(four: "Places", fu: "Lanes", fv: "Lanes") -> "Lanes":
    """Return the bilinear mixtures of packed texels' four greys."""
    byte = places(255)
    a, b = real(four & byte), real((four >> places(8)) & byte)
    c, d = real((four >> places(16)) & byte), real((four >> places(24)) & byte)
    top = a + fu * (b - a)
    low = c + fu * (d - c)
    return top + fv * (low - top)


@njit(cache=True, nogil=True, error_model="numpy")
def shine(light: Row, gain: Row, transmission: Row, veil: float) -> None:
    """Replace radiances [grey] by what arrives of them when they get `gain` times daylight."""
    b = _F(veil)
    for q in range(gain.shape[0]):
        light[q] = (light[q] * gain[q] - b) * transmission[q] + b


@njit(cache=True, nogil=True, error_model="numpy")
def spread(nodes: NDArray[np.float32], place: tuple[int, int, int], out: Row) -> None:
    """Write a strip of values between nodes (rows, columns) that stand every NODE px.

    `place` is row and column of the strip's first pixel, counted from the first node, and its
    width; the column is that of a node.
    """
    row, start, width = place
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
            store(blocks, k, 0, lanes(left) + lanes(slope) * steps)
            left = right
            k += 1


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _between(nodes: NDArray[np.float32], row: int, column: int, share: np.float32) -> np.float32:
    """Return the value on the way from a node to the one below it."""
    above = nodes[row, column]
    value: np.float32 = above + share * (nodes[row + 1, column] - above)
    return value


@njit(cache=True, nogil=True, error_model="numpy")
def pass_through(
    nodes: NDArray[np.float32], place: tuple[int, int, int], veil: float, light: Row
) -> None:
    """Replace a strip of radiances [grey] by what arrives of them through the water.

    `nodes` are transmissions and `place` what `spread` takes: the two of them in one.
    """
    row, start, width = place
    first = start // NODE
    blocks = light.reshape(light.shape[0] // NODE, NODE)
    across = width // NODE
    steps, b = load(STEPS, 0, 0), lanes(veil)
    k = 0
    for r in range(blocks.shape[0] // across):
        j = (row + r) // NODE
        share = _F((row + r - j * NODE) / NODE)
        left = _between(nodes, j, first, share)
        for i in range(across):
            right = _between(nodes, j, first + i + 1, share)
            slope = (right - left) * _F(1.0 / NODE)
            transmission = lanes(left) + lanes(slope) * steps
            store(blocks, k, 0, (load(blocks, k, 0) - b) * transmission + b)
            left = right
            k += 1


@njit(cache=True, nogil=True, error_model="numpy")
def copy(source: Row | NDArray[np.uint8], out: Row | NDArray[np.uint8]) -> None:
    """Write what is in `source`; Numba's assignment of slices is no vector loop."""
    for q in range(out.shape[0]):
        out[q] = source[q]


@njit(cache=True, nogil=True, error_model="numpy")
def expose(
    light: Row, noise: Row, read_variance: float, shot_gain: float, out: NDArray[np.uint8]
) -> None:
    """Write grey levels: radiance plus read and shot noise, rounded and clipped."""
    v0 = _F(read_variance)
    g = _F(shot_gain)
    for q in range(out.shape[0]):
        sigma = np.sqrt(v0 + g * max(light[q], _F(0.0)))
        value = light[q] + noise[q] * sigma + _F(0.5)
        out[q] = np.uint8(np.int32(min(max(value, _F(0.0)), _F(255.0))))


@njit(cache=True, nogil=True, error_model="numpy")
def interleave(
    first: NDArray[np.uint8],
    second: NDArray[np.uint8],
    third: NDArray[np.uint8],
    out: NDArray[np.uint8],
) -> None:
    """Write three planes (n,) as one picture (3 n,)."""
    for q in range(first.shape[0]):
        out[3 * q] = first[q]
        out[3 * q + 1] = second[q]
        out[3 * q + 2] = third[q]
