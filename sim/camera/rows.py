"""The hot loops of the ray-caster over a strip of rows, the same on every CPU.

Each loop runs from 0 over slices, which is what lets LLVM vectorise it; without `fastmath` LLVM
neither reorders nor contracts, so a vector lane computes the same bits as the scalar remainder. A
pixel's value depends on its absolute column alone, never on where the slice starts.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.camera.geometry import Line, row_of
from sim.camera.seabed import TILE

Row = NDArray[np.float32]
Texels = NDArray[np.int32]

_F = np.float32
_MASK = np.int32(TILE - 1)
_TEN, _FOUR = np.int32(10), np.int32(4)  # a row of STRIDE = 2**10 + 2**4 texels
BIAS = 4096  # [texel] keeps the coordinates positive, so that int() rounds down
_REACH = _F(4000.0)  # [texel] 20 m: what lies farther repeats the texture's edge
_BYTE = np.int32(255)
NODE = 16  # [px] distance of the points at which the seabed's transmission is computed
CHUNK = 32  # [px] what LLVM makes of a loop is whole vectors for a multiple of this


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _mixed(four: np.int32, fu: np.float32, fv: np.float32) -> np.float32:
    """Return the bilinear mixture of a packed texel's four greys."""
    a = _F(np.int32(four & _BYTE))
    b = _F(np.int32(np.int32(four >> np.int32(8)) & _BYTE))
    c = _F(np.int32(np.int32(four >> np.int32(16)) & _BYTE))
    d = _F(np.int32(np.int32(four >> np.int32(24)) & _BYTE))
    top = a + fu * (b - a)
    low = c + fu * (d - c)
    return top + fv * (low - top)


@njit(cache=True, nogil=True, error_model="numpy")
def seabed_places(
    ground: NDArray[np.float64],
    place: tuple[int, int, int],
    shift: tuple[int, int],
    index: Texels,
    fu: Row,
    fv: Row,
) -> None:
    """Write texel numbers and fractions of the seabed for a strip of rows.

    Parameters
    ----------
    ground : (3, 3)
        Pixel (u, v, 1) -> a/z, b/z, 1/z [texel, 1/m].
    place : tuple
        Row and column of the strip's first pixel, and its width [px].
    shift : tuple
        Texels that a and b are counted from.
    """
    row, start, width = place
    for r in range(index.shape[0] // width):
        line = row_of(ground, float(row + r))
        first, last = r * width, (r + 1) * width
        _row_places(line, start, shift, index[first:last], fu[first:last], fv[first:last])


@njit(cache=True, nogil=True, error_model="numpy")
def _row_places(
    line: Line, start: int, shift: tuple[int, int], index: Texels, fu: Row, fv: Row
) -> None:
    a0, b0, w0, a1, b1, w1 = line
    first = np.int32(start)
    su = np.int32(shift[0])
    sv = np.int32(shift[1])
    for q in range(index.shape[0]):
        column = _F(np.int32(first + np.int32(q)))
        z = _F(1.0) / max(w0 + w1 * column, _F(1e-3))
        u = min(max((a0 + a1 * column) * z, -_REACH), _REACH) + _F(4096.0)
        v = min(max((b0 + b1 * column) * z, -_REACH), _REACH) + _F(4096.0)
        iu = np.int32(u)
        iv = np.int32(v)
        fu[q] = u - _F(iu)
        fv[q] = v - _F(iv)
        across = np.int32(np.int32(iu + su) & _MASK)
        down = np.int32(np.int32(iv + sv) & _MASK)
        line_start = np.int32(np.int32(down << _TEN) + np.int32(down << _FOUR))
        index[q] = np.int32(line_start + across)


@njit(cache=True, nogil=True, error_model="numpy")
def fetch(quads: Texels, index: Texels, out: Texels) -> None:
    """Write the packed texels of texel numbers; apart, so that the arithmetic vectorises."""
    for q in range(index.shape[0]):
        out[q] = quads[np.uint32(index[q])]


@njit(cache=True, nogil=True, error_model="numpy")
def sample(quad: Texels, fu: Row, fv: Row, out: Row) -> None:
    """Write bilinear samples [grey] of packed texels."""
    for q in range(out.shape[0]):
        out[q] = _mixed(quad[q], fu[q], fv[q])


@njit(cache=True, nogil=True, error_model="numpy")
def sample_through(
    quad: Texels, fu: Row, fv: Row, transmission: Row, veil: float, out: Row
) -> None:
    """Write what arrives of the bilinear samples of packed texels through the water [grey]."""
    b = _F(veil)
    for q in range(out.shape[0]):
        out[q] = (_mixed(quad[q], fu[q], fv[q]) - b) * transmission[q] + b


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
    k = 0
    for r in range(blocks.shape[0] // across):
        j = (row + r) // NODE
        share = _F((row + r - j * NODE) / NODE)
        above = nodes[j, first : first + across + 1]
        below = nodes[j + 1, first : first + across + 1]
        left = above[0] + share * (below[0] - above[0])
        for i in range(across):
            right = above[i + 1] + share * (below[i + 1] - above[i + 1])
            slope = (right - left) * _F(1.0 / NODE)
            block = blocks[k]
            for p in range(NODE):
                block[p] = left + slope * _F(np.int32(p))
            left = right
            k += 1


@njit(cache=True, nogil=True, error_model="numpy")
def fill(value: float, out: Row) -> None:
    """Write one value everywhere."""
    v = _F(value)
    for q in range(out.shape[0]):
        out[q] = v


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
