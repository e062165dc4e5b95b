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


def other_text(random: np.random.Generator) -> str:
    """Return a text of known letters that has another one than TEXT at every place."""
    others = ([letter for letter in GLYPHS if letter != usual] for usual in TEXT)
    return "".join(letters[random.integers(len(letters))] for letters in others)


def strokes(text: str, *, x: float, y: float, height: float, pitch: float) -> list[Segment]:
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


def _at(columns: NDArray[np.bool_], rows: NDArray[np.bool_]) -> tuple[NDArray[np.intp], ...]:
    """Return the index of all samples of these columns and rows."""
    return np.ix_(np.flatnonzero(rows), np.flatnonzero(columns))


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
            total += samples[dj::OVERSAMPLING, di::OVERSAMPLING]
    total /= OVERSAMPLING**2
    return total


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


def _striped(
    base: NDArray[np.float64], stripe: NDArray[np.float64], tone: float
) -> NDArray[np.float64]:
    """Paint the first half of each stripe, where stripes are counted from 0."""
    return np.where(stripe - np.floor(stripe) < 0.5, tone, base)


def _with_rim_and_bolts(
    samples: tuple[NDArray[np.float64], ...],
    wide: float,
    base: float,
    rim: tuple[float, float],
    bolts: tuple[float, float, float],
) -> NDArray[np.float64]:
    """Return a face with a rim (width, tone) and bolts (distance from the edges, radius, tone)."""
    u, v = samples
    across, down = u[0], v[:, 0]
    out = np.full(u.shape, base)
    width, tone = rim
    out[:, np.minimum(across, wide - across) < width] = tone
    out[np.minimum(down, 1 - down) < width] = tone
    edge, radius, tone = bolts
    for x in (edge, wide - edge):
        for y in (edge, 1.0 - edge):
            near = _around(u, v, (x, y, x, y), radius)
            distance = np.sqrt((u[near] - x) ** 2 + (v[near] - y) ** 2)
            out[near] = _painted(out[near], distance, radius, tone)
    return out


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
    if not lettered:
        return _averaged(np.full(u.shape, BLACK))
    # Worn edges are lighter.
    out = _with_rim_and_bolts((u, v), wide, BLACK, (0.05, 0.11), (0.16, 0.055, 0.42))
    if wide < 2:
        return _smoothed(_smoothed(_averaged(out)))
    for stroke in strokes(TEXT, x=0.32, y=0.26, height=0.44, pitch=0.345):
        near = _around(u, v, stroke, 0.042)
        out[near] = _painted(out[near], _distance(u[near], v[near], stroke), 0.042, WHITE)
    across, down = u[0], v[:, 0]
    mark = _at((across > wide - 0.48) & (across < wide - 0.29), (down > 0.26) & (down < 0.74))
    out[mark] = _striped(out[mark], (u[mark] + v[mark]) * 4.2, AMBER[channel])
    out[_at((across > 0.36) & (across < 2.2), np.abs(down - 0.86) < 0.025)] = 0.34
    return _smoothed(_smoothed(_averaged(out)))


@lru_cache(maxsize=32)
def label(
    length_m: float, width_m: float, texel_m: float, albedo: float, ink: float, text: str = TEXT
) -> NDArray[np.float64]:
    """Return the albedo (rows, columns) of a painted face: a rim, bolts, and the text across it.

    `ink` is the albedo of bolts, text and the bar below it; the text has seven letters of GLYPHS.
    See `face` for the rest.
    """
    columns, rows = max(round(length_m / texel_m), 2), max(round(width_m / texel_m), 2)
    u, v = _grid(length_m, width_m, columns, rows)
    wide = length_m / width_m
    rim, bolts = (0.04, 0.6 * albedo), (0.1, 0.035, ink)
    out = _with_rim_and_bolts((u, v), wide, albedo, rim, bolts)
    # Seven letters are 5.5 times as wide as high.
    height = min(0.5, 0.8 * wide / 5.5)
    left, top = 0.5 * (wide - 5.4 * height), 0.42 - 0.5 * height
    half = 0.095 * height
    for stroke in strokes(text, x=left, y=top, height=height, pitch=0.784 * height):
        near = _around(u, v, stroke, half)
        out[near] = _painted(out[near], _distance(u[near], v[near], stroke), half, ink)
    across, down = u[0], v[:, 0]
    bar = _at((across > left) & (across < wide - left), np.abs(down - 0.76) < 0.05)
    out[bar] = _striped(out[bar], (u[bar] + v[bar]) * 6.0, ink)
    return _smoothed(_smoothed(_averaged(out)))
