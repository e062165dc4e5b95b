"""The hot loops of the ray-caster, one row of pixels each, the same on every CPU.

Each loop runs from 0 over slices, which is what lets LLVM vectorise it; without `fastmath` LLVM
neither reorders nor contracts, so a vector lane computes the same bits as the scalar remainder. A
pixel's value depends on its absolute column alone, never on where the slice starts.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.camera.seabed import TILE

Row = NDArray[np.float32]
Texels = NDArray[np.int32]

_F = np.float32
_MASK = np.int32(TILE - 1)
_SHIFT = np.int32(10)
_BIAS = np.int32(4096)  # [texel] keeps the coordinates positive, so that int() rounds down
_REACH = _F(4000.0)  # [texel] 20 m: what lies farther repeats the texture's edge
_BYTE = np.int32(255)
NODE = 16  # [px] distance of the points at which the seabed's transmission is computed


@njit(cache=True, nogil=True, error_model="numpy")
def seabed_places(
    line: Row, x0: int, shift_u: int, shift_v: int, index: Texels, fu: Row, fv: Row
) -> None:
    """Write texel numbers and fractions of the seabed along a row.

    Parameters
    ----------
    line : (6,) float32
        a/z, b/z, 1/z [texel, 1/m] at column 0 and their change per column.
    x0 : int
        Absolute column of the first pixel.
    """
    a0 = line[0]
    b0 = line[1]
    w0 = line[2]
    a1 = line[3]
    b1 = line[4]
    w1 = line[5]
    first = np.int32(x0)
    su = np.int32(shift_u)
    sv = np.int32(shift_v)
    for q in range(index.shape[0]):
        column = _F(np.int32(first + np.int32(q)))
        z = _F(1.0) / max(w0 + w1 * column, _F(1e-3))
        u = min(max((a0 + a1 * column) * z, -_REACH), _REACH) + _F(4096.0)
        v = min(max((b0 + b1 * column) * z, -_REACH), _REACH) + _F(4096.0)
        iu = np.int32(u)
        iv = np.int32(v)
        fu[q] = u - _F(iu)
        fv[q] = v - _F(iv)
        index[q] = np.int32(
            np.int32(np.int32(np.int32(iv + sv) & _MASK) << _SHIFT)
            | np.int32(np.int32(iu + su) & _MASK)
        )


@njit(cache=True, nogil=True, error_model="numpy")
def face_places(
    line: Row, x0: int, place: tuple[int, int, int], index: Texels, fu: Row, fv: Row, depth: Row
) -> None:
    """Write texel numbers, fractions and depths [m] of a face along a row; edges are repeated.

    `place` is the face in the skin: offset, columns, rows.
    """
    a0 = line[0]
    b0 = line[1]
    w0 = line[2]
    a1 = line[3]
    b1 = line[4]
    w1 = line[5]
    first = np.int32(x0)
    offset, columns, rows = place
    start = np.int32(offset)
    width = np.int32(columns)
    right = _F(columns) - _F(1.001)
    bottom = _F(rows) - _F(1.001)
    for q in range(index.shape[0]):
        column = _F(np.int32(first + np.int32(q)))
        z = _F(1.0) / max(w0 + w1 * column, _F(1e-3))
        u = min(max((a0 + a1 * column) * z, _F(0.0)), right)
        v = min(max((b0 + b1 * column) * z, _F(0.0)), bottom)
        iu = np.int32(u)
        iv = np.int32(v)
        fu[q] = u - _F(iu)
        fv[q] = v - _F(iv)
        depth[q] = z
        index[q] = np.int32(start + np.int32(np.int32(iv * width) + iu))


@njit(cache=True, nogil=True, error_model="numpy")
def fetch(quads: Texels, index: Texels) -> None:
    """Replace texel numbers by packed texels; apart, so that the arithmetic vectorises."""
    for q in range(index.shape[0]):
        index[q] = quads[np.uint32(index[q])]


@njit(cache=True, nogil=True, error_model="numpy")
def sample(quad: Texels, fu: Row, fv: Row, out: Row) -> None:
    """Write bilinear samples [grey] of packed texels."""
    for q in range(out.shape[0]):
        four = quad[q]
        a = _F(np.int32(four & _BYTE))
        b = _F(np.int32(np.int32(four >> np.int32(8)) & _BYTE))
        c = _F(np.int32(np.int32(four >> np.int32(16)) & _BYTE))
        d = _F(np.int32(np.int32(four >> np.int32(24)) & _BYTE))
        top = a + fu[q] * (b - a)
        low = c + fu[q] * (d - c)
        out[q] = top + fv[q] * (low - top)


@njit(cache=True, nogil=True, error_model="numpy")
def attenuate(light: Row, transmission: Row, veil: float) -> None:
    """Replace radiances by what arrives through the water, in place."""
    b = _F(veil)
    for q in range(light.shape[0]):
        light[q] = (light[q] - b) * transmission[q] + b


@njit(cache=True, nogil=True, error_model="numpy")
def spread(nodes: Row, x0: int, out: Row) -> None:
    """Write values between nodes that stand every NODE px from absolute column 0 on."""
    q = 0
    while q < out.shape[0]:
        k = (x0 + q) // NODE
        start = x0 + q - k * NODE
        count = min(NODE - start, out.shape[0] - q)
        left = nodes[k]
        slope = (nodes[k + 1] - left) * _F(1.0 / NODE)
        piece = out[q : q + count]
        first = np.int32(start)
        for p in range(count):
            piece[p] = left + slope * _F(np.int32(first + np.int32(p)))
        q += count


@njit(cache=True, nogil=True, error_model="numpy")
def face_transmission(
    depth: Row, x0: int, lens: tuple[float, float], y: float, water: tuple[int, float], out: Row
) -> None:
    """Write the transmission of each pixel's own ray; `water` is law (0 beer, 1 uwsim) and c.

    `lens` is focal length and principal column [px], `y` the row's slope in the camera frame.

    exp(x) = p(x / 64)^64 with a polynomial p: for x > -10 the relative error is below 1e-5.
    """
    inverse = _F(1.0 / lens[0])
    middle = _F(lens[1])
    square = _F(1.0 + y * y)
    first = np.int32(x0)
    c = _F(water[1])
    fog = water[0] == 1
    for q in range(out.shape[0]):
        x = (_F(np.int32(first + np.int32(q))) - middle) * inverse
        if fog:
            path = c * depth[q]
            path = path * path
        else:
            path = c * depth[q] * np.sqrt(square + x * x)
        t = max(-path, _F(-40.0)) * _F(1.0 / 64.0)
        p = _F(1.0) + t * (
            _F(1.0)
            + t * (_F(0.5) + t * (_F(1.0 / 6.0) + t * (_F(1.0 / 24.0) + t * _F(1.0 / 120.0))))
        )
        p = p * p
        p = p * p
        p = p * p
        p = p * p
        p = p * p
        out[q] = p * p


@njit(cache=True, nogil=True, error_model="numpy")
def coverage(edges: NDArray[np.float64], y: float, x0: int, out: Row) -> None:
    """Write how much of each pixel lies inside a convex polygon: exact along straight edges.

    Parameters
    ----------
    edges : (4, 3)
        Outward unit normal and offset of each edge [px]: distance = nx u + ny v + offset.
    y : float
        Row.
    """
    for q in range(out.shape[0]):
        out[q] = _F(1.0)
    first = np.int32(x0)
    for k in range(edges.shape[0]):
        nx = _F(edges[k, 0])
        base = _F(edges[k, 1] * y + edges[k, 2])
        a = max(abs(nx), _F(0.02))
        b = max(_F(abs(edges[k, 1])), _F(0.02))
        s = (a + b) * _F(0.5)
        m = abs(a - b) * _F(0.5)
        scale = _F(0.5) / (a * b)
        farthest = max(nx * _F(first), nx * _F(np.int32(first + np.int32(out.shape[0] - 1))))
        if -(base + farthest) > s:  # the whole span is inside this edge: every factor is 1
            continue
        for q in range(out.shape[0]):
            t = -(base + nx * _F(np.int32(first + np.int32(q))))
            # Second difference of t^2/2: the area a half-plane cuts from a unit square.
            q1 = max(t + s, _F(0.0))
            q2 = max(t + m, _F(0.0))
            q3 = max(t - m, _F(0.0))
            q4 = max(t - s, _F(0.0))
            area = ((q1 * q1 - q2 * q2) - (q3 * q3 - q4 * q4)) * scale
            inside = min(max(area, _F(0.0)), _F(1.0))
            out[q] = out[q] * (_F(1.0) if t > s else inside)


@njit(cache=True, nogil=True, error_model="numpy")
def blend(total: Row, ground: Row, light: Row, cover: Row) -> None:
    """Add a face's share of each pixel to the row, in place of the ground's."""
    for q in range(total.shape[0]):
        total[q] = total[q] + cover[q] * (light[q] - ground[q])


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
