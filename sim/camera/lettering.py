"""The surface of the box: black plastic with a rim, bolts and letters in a stroke font.

Rendered from distances to line segments, so it needs no font file and no library whose results
depend on the processor.
"""

from functools import lru_cache
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

TEXT = "SEAMARK"
OVERSAMPLING = 4  # [samples per texel and axis]
BLACK = 0.055  # albedo of the plastic, E
WHITE = 0.80  # albedo of the paint, E
AMBER: tuple[float, float, float] = (0.95, 0.62, 0.10)  # red, green, blue of the warning mark, E

Segment = tuple[float, float, float, float]
# Polylines on a grid 4 wide and 6 high, origin at the upper left.
GLYPHS: dict[str, tuple[tuple[tuple[float, float], ...], ...]] = {
    "S": (
        (
            *((4, 0.7), (3, 0), (1, 0), (0, 1.2), (0.7, 2.6)),
            *((3.3, 3.4), (4, 4.8), (3, 6), (1, 6), (0, 5.3)),
        ),
    ),
    "E": (((4, 0), (0, 0), (0, 6), (4, 6)), ((0, 3), (3, 3))),
    "A": (((0, 6), (2, 0), (4, 6)), ((0.8, 4), (3.2, 4))),
    "M": (((0, 6), (0, 0), (2, 3.4), (4, 0), (4, 6)),),
    "R": (((0, 6), (0, 0), (3, 0), (4, 0.9), (4, 2.3), (3, 3.2), (0, 3.2)), ((2, 3.2), (4, 6))),
    "K": (((0, 0), (0, 6)), ((4, 0), (0, 3.4)), ((1.4, 2.4), (4, 6))),
}  # fmt: skip


def _segments(text: str, *, x: float, y: float, height: float, pitch: float) -> list[Segment]:
    """Return the strokes of a text whose first letter has its upper left corner at (x, y)."""
    unit = height / 6
    segments = []
    for position, letter in enumerate(text):
        left = x + position * pitch
        for line in GLYPHS[letter]:
            for (x0, y0), (x1, y1) in pairwise(line):
                segments.append((left + x0 * unit, y + y0 * unit, left + x1 * unit, y + y1 * unit))
    return segments


def _distance(
    u: NDArray[np.float64], v: NDArray[np.float64], stroke: Segment
) -> NDArray[np.float64]:
    """Return the distance of every sample to a line segment."""
    x0, y0, x1, y1 = stroke
    dx, dy = x1 - x0, y1 - y0
    along = ((u - x0) * dx + (v - y0) * dy) / (dx * dx + dy * dy)
    along = np.minimum(np.maximum(along, 0.0), 1.0)
    ex, ey = u - x0 - along * dx, v - y0 - along * dy
    distance: NDArray[np.float64] = np.sqrt(ex * ex + ey * ey)
    return distance


def _around(
    u: NDArray[np.float64], v: NDArray[np.float64], stroke: Segment, half: float
) -> tuple[slice, slice]:
    """Return the rows and columns that hold all samples nearer than `half` to a line segment."""
    x0, y0, x1, y1 = stroke
    left, right = np.searchsorted(u[0], (min(x0, x1) - 2.0 * half, max(x0, x1) + 2.0 * half))
    upper, lower = np.searchsorted(v[:, 0], (min(y0, y1) - 2.0 * half, max(y0, y1) + 2.0 * half))
    return slice(upper, lower), slice(left, right)


def _grid(length: float, width: float, columns: int, rows: int) -> tuple[NDArray[np.float64], ...]:
    """Return sample positions in units of the face's width, the origin at the upper left."""
    u = (np.arange(columns * OVERSAMPLING) + 0.5) / (columns * OVERSAMPLING) * (length / width)
    v = (np.arange(rows * OVERSAMPLING) + 0.5) / (rows * OVERSAMPLING)
    across = np.broadcast_to(u, (v.size, u.size))
    down = np.broadcast_to(v[:, None], (v.size, u.size))
    return across, down


def _averaged(samples: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return texels: means of OVERSAMPLING x OVERSAMPLING samples, added in a fixed order."""
    total = np.zeros((samples.shape[0] // OVERSAMPLING, samples.shape[1] // OVERSAMPLING))
    for dj in range(OVERSAMPLING):
        for di in range(OVERSAMPLING):
            total = total + samples[dj::OVERSAMPLING, di::OVERSAMPLING]
    return total / OVERSAMPLING**2


def _smoothed(texels: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return texels under a binomial 3x3 mask, edges repeated.

    It models the area of a pixel and the blur of a lens: without it the letters would alias under
    sub-pixel motion, which limits every tracker.
    """
    out = texels
    for axis in range(2):
        padded = np.pad(out, [(1, 1) if k == axis else (0, 0) for k in range(2)], mode="edge")
        n = padded.shape[axis]
        first, middle, last = (np.take(padded, range(k, n - 2 + k), axis=axis) for k in range(3))
        out = 0.25 * (first + last) + 0.5 * middle
    return out


def _painted(
    base: NDArray[np.float64], distance: NDArray[np.float64], half: float, tone: float
) -> NDArray[np.float64]:
    return np.where(distance < half, tone, base)


@lru_cache(maxsize=32)
def face(
    length_m: float, width_m: float, texel_m: float, channel: int, *, lettered: bool = True
) -> NDArray[np.float64]:
    """Return the albedo (rows, columns) of a face, with the text if there is room for it.

    Parameters
    ----------
    length_m, width_m : float [m]
        Extent to the right and downwards as one reads the text.
    texel_m : float [m]
        Desired texel size; the actual one divides the face evenly.
    channel : int
        0 red, 1 green, 2 blue.
    lettered : bool
        False gives plain black plastic.
    """
    columns, rows = round(length_m / texel_m), round(width_m / texel_m)
    u, v = _grid(length_m, width_m, columns, rows)
    wide = length_m / width_m
    out = np.full(u.shape, BLACK)
    if not lettered:
        return _averaged(out)
    rim = np.minimum(np.minimum(u, wide - u), np.minimum(v, 1 - v))
    out = np.where(rim < 0.05, 0.11, out)  # worn edges are lighter
    for x in (0.16, wide - 0.16):
        for y in (0.16, 0.84):
            out = _painted(out, np.sqrt((u - x) ** 2 + (v - y) ** 2), 0.055, 0.42)
    if wide < 2:
        return _smoothed(_smoothed(_averaged(out)))
    for stroke in _segments(TEXT, x=0.32, y=0.26, height=0.44, pitch=0.345):
        near = _around(u, v, stroke, 0.042)
        out[near] = _painted(out[near], _distance(u[near], v[near], stroke), 0.042, WHITE)
    mark = (u > wide - 0.48) & (u < wide - 0.29) & (v > 0.26) & (v < 0.74)
    stripe = (u + v) * 4.2
    out = np.where(mark & (stripe - np.floor(stripe) < 0.5), AMBER[channel], out)
    out = np.where((np.abs(v - 0.86) < 0.025) & (u > 0.36) & (u < 2.2), 0.34, out)
    return _smoothed(_smoothed(_averaged(out)))


@lru_cache(maxsize=32)
def label(
    length_m: float, width_m: float, texel_m: float, albedo: float, ink: float
) -> NDArray[np.float64]:
    """Return the albedo (rows, columns) of a painted face: a rim, bolts, and the text across it.

    `ink` is the albedo of bolts, text and the bar below it; see `face` for the rest.
    """
    columns, rows = max(round(length_m / texel_m), 2), max(round(width_m / texel_m), 2)
    u, v = _grid(length_m, width_m, columns, rows)
    wide = length_m / width_m
    out = np.full(u.shape, albedo)
    rim = np.minimum(np.minimum(u, wide - u), np.minimum(v, 1 - v))
    out = np.where(rim < 0.04, 0.6 * albedo, out)
    for x in (0.1, wide - 0.1):
        for y in (0.1, 0.9):
            out = _painted(out, np.sqrt((u - x) ** 2 + (v - y) ** 2), 0.035, ink)
    # Text of seven letters, 5.5 times as wide as high.
    height = min(0.5, 0.8 * wide / 5.5)
    left, top = 0.5 * (wide - 5.4 * height), 0.42 - 0.5 * height
    half = 0.095 * height
    for stroke in _segments(TEXT, x=left, y=top, height=height, pitch=0.784 * height):
        near = _around(u, v, stroke, half)
        out[near] = _painted(out[near], _distance(u[near], v[near], stroke), half, ink)
    bar = (np.abs(v - 0.76) < 0.05) & (u > left) & (u < wide - left)
    stripe = (u + v) * 6.0
    out = np.where(bar & (stripe - np.floor(stripe) < 0.5), ink, out)
    return _smoothed(_smoothed(_averaged(out)))
