"""Fits a picture of the face to an image: an affine map, and how bright paint, ink and ground are.

The camera samples the face at single points, so the picture is looked up at each pixel: an image
that is interpolated instead would lose what little it shows of the letters from afar.
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.detectors.faces.picture import (
    BOTTOM,
    HALF_LENGTH,
    HALF_WIDTH,
    LEFT,
    LETTERS,
    PITCH,
    TOP,
    Texels,
)
from seamark.sim.trackers.template.warps import solve

Plane = NDArray[np.float32]  # (H, W) an image

NOISE = 1.4  # [grey] E: of the camera (`Water`)
_MARGIN = 0.15  # lengths around the face that the fit looks at, E
_SIDES = 4
_LEAST = 8  # pixels on which a level of brightness is based
_SHAPE = 0.08  # E: how far an affine map is from a similarity
_OUTLIER = 3.0  # E: standard deviations from which residuals count less
_LEAST_PX = 12.0  # of the length and twice the width of a face, E
_FAR_PX = 1e4
_LEAST_CONTRAST = 0.3  # E: of the noise's variance; with less, noise may look like anything
_LEAST_SPREAD = 1e-6
# Each of six unknowns: the slope along x or y, times 1, x or y, and what two of these make.
_SLOPE, _FACTOR = (0, 1, 0, 0, 1, 1), (0, 0, 1, 2, 1, 2)
_MOMENT = ((0, 1, 2), (1, 3, 4), (2, 4, 5))


class Map(NamedTuple):
    """Where a face is: a pixel is (u, v) + x (ax, ay) + y (bx, by)."""

    u: float
    v: float
    ax: float
    ay: float
    bx: float
    by: float


class Look(NamedTuple):
    """How a picture is compared with an image."""

    pictures: Texels  # (n, rows, columns)
    letters: NDArray[np.int64]  # (LETTERS,) which picture has each of them
    ramp_px: float  # over how many pixels an edge of the face goes
    pixels: float  # along the face; of a longer one only every second row and column counts, or so


class Levels(NamedTuple):
    """How bright things are [grey]."""

    ink: float
    gain: float  # from ink to paint
    ground: tuple[float, float, float, float]  # to the right and left, below and above
    spread: float  # of residuals on the face
    printed: float  # share of the variation on the face that the picture explains


class Region(NamedTuple):
    """The pixels around a face, and what leads from them to face coordinates."""

    left: int
    top: int
    right: int
    bottom: int
    xu: float
    xv: float
    yu: float
    yv: float
    long_px: float
    wide_px: float  # for a whole length across


@njit(cache=True, nogil=True, error_model="numpy")
def region(image: Plane, at: Map) -> Region:
    """Return the pixels around a face; none if it is too small or mirrored."""
    x, y = HALF_LENGTH + _MARGIN, HALF_WIDTH + _MARGIN
    wide, tall = x * abs(at.ax) + y * abs(at.bx), x * abs(at.ay) + y * abs(at.by)
    long_px = np.sqrt(at.ax * at.ax + at.ay * at.ay)
    wide_px = np.sqrt(at.bx * at.bx + at.by * at.by)
    area = at.ax * at.by - at.ay * at.bx
    # A comparison with what is not a number is false, too.
    known = abs(at.u) < _FAR_PX and abs(at.v) < _FAR_PX and max(long_px, wide_px) < _FAR_PX
    if not (known and min(long_px, wide_px) > _LEAST_PX and area > 0.5 * long_px * wide_px):
        return Region(0, 0, -1, -1, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0)
    rows, columns = image.shape
    left, right = max(int(at.u - wide), 0), min(int(at.u + wide) + 1, columns - 1)
    top, bottom = max(int(at.v - tall), 0), min(int(at.v + tall) + 1, rows - 1)
    xu, xv, yu, yv = at.by / area, -at.bx / area, -at.ay / area, at.ax / area
    return Region(left, top, right, bottom, xu, xv, yu, yv, long_px, wide_px)


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def on_face(here: Region, at: Map, column: int, row: int) -> tuple[float, float]:
    """Return where a pixel is in face coordinates."""
    du, dv = column - at.u, row - at.v
    return here.xu * du + here.xv * dv, here.yu * du + here.yv * dv


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def looked_up(picture: Texels, x: float, y: float) -> tuple[float, float, float]:
    """Return a picture's value at a place on the face, and its slopes along x and y."""
    rows, columns = picture.shape
    p = (x / HALF_LENGTH + 1.0) * 0.5 * columns - 0.5
    q = (y / HALF_WIDTH + 1.0) * 0.5 * rows - 0.5
    p, q = min(max(p, 0.0), columns - 1.001), min(max(q, 0.0), rows - 1.001)
    i, j = int(p), int(q)
    a, b = p - i, q - j
    upper, lower = float(picture[j, i]), float(picture[j + 1, i])
    rise, fall = picture[j, i + 1] - upper, picture[j + 1, i + 1] - lower
    down = lower - upper + a * (fall - rise)
    along = (rise + b * (fall - rise)) * 0.5 * columns / HALF_LENGTH
    return upper + a * rise + b * down, along, down * 0.5 * rows / HALF_WIDTH


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def letter_field(x: float, y: float) -> int:
    """Return in the field of which letter a place on the face is; -1 if in none."""
    if y < TOP or y >= BOTTOM or x < LEFT:
        return -1
    field = int((x - LEFT) / PITCH)
    return field if field < LETTERS else -1


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _painted(look: Look, x: float, y: float) -> tuple[float, float, float]:
    """Return what `looked_up` does, of the picture that has the letter of a place."""
    field = letter_field(x, y)
    number = look.pictures.shape[0] - 1 if field < 0 else look.letters[field]
    return looked_up(look.pictures[number], x, y)


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _side(x: float, y: float) -> int:
    """Return beside which side of the face a place is."""
    if abs(x) - HALF_LENGTH > abs(y) - HALF_WIDTH:
        return 0 if x > 0.0 else 1
    return 2 if y > 0.0 else 3


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _cover(off: float, half: float, slope: float) -> tuple[float, float]:
    """Return how much of a pixel is within half a size along one axis, and how that changes."""
    inner = 0.5 + (half - abs(off)) * slope
    if inner >= 1.0:
        return 1.0, 0.0
    if inner <= 0.0:
        return 0.0, 0.0
    return inner, -slope if off > 0.0 else slope


@njit(cache=True, nogil=True, error_model="numpy")
def levels(image: Plane, at: Map, look: Look) -> Levels:
    """Return how bright ink, paint and the ground beside each side are, by least squares."""
    here, skip = region(image, at), _skip(at, look)
    n, t, tt, g, gt, gg = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    counts, sums = np.zeros(_SIDES), np.zeros(_SIDES)
    for r in range(here.top, here.bottom + 1, skip):
        for c in range(here.left, here.right + 1, skip):
            x, y = on_face(here, at, c, r)
            if abs(x) > HALF_LENGTH + _MARGIN or abs(y) > HALF_WIDTH + _MARGIN:
                continue
            mx, _ = _cover(x, HALF_LENGTH, here.long_px / look.ramp_px)
            my, _ = _cover(y, HALF_WIDTH, here.wide_px / look.ramp_px)
            inside, grey = mx * my, float(image[r, c])
            if inside >= 1.0:
                value = _painted(look, x, y)[0]
                n += 1.0
                t += value
                tt += value * value
                g += grey
                gt += grey * value
                gg += grey * grey
            elif inside <= 0.0:
                side = _side(x, y)
                counts[side] += 1.0
                sums[side] += grey
    varied, around = tt - t * t / max(n, 1.0), counts.sum()
    if n < _LEAST or varied < _LEAST_SPREAD or around < _LEAST:
        return Levels(0.0, 0.0, (0.0, 0.0, 0.0, 0.0), 0.0, 0.0)
    gain = (gt - g * t / n) / varied
    whole = max(gg - g * g / n, _LEAST_SPREAD)
    explained = min(gain * gain * varied, whole)
    mean = sums.sum() / around
    for side in range(_SIDES):
        sums[side] = sums[side] / counts[side] if counts[side] >= _LEAST else mean
    ground = (sums[0], sums[1], sums[2], sums[3])
    printed = _share(explained, whole, n) if gain > 0.0 else 0.0
    return Levels((g - gain * t) / n, gain, ground, np.sqrt((whole - explained) / n), printed)


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _skip(at: Map, look: Look) -> int:
    """Return from how many rows and columns one is looked at."""
    return 1 + int(np.sqrt(at.ax * at.ax + at.ay * at.ay) / look.pixels)


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _expected(
    here: Region, look: Look, have: Levels, x: float, y: float
) -> tuple[float, float, float]:
    """Return how bright a place should be, and its slopes along x and y."""
    mx, sx = _cover(x, HALF_LENGTH, here.long_px / look.ramp_px)
    my, sy = _cover(y, HALF_WIDTH, here.wide_px / look.ramp_px)
    inside, ground = mx * my, have.ground[_side(x, y)]
    if inside <= 0.0:
        return ground, 0.0, 0.0
    value, along, down = _painted(look, x, y)
    above = have.ink + have.gain * value - ground
    return (
        ground + inside * above,
        sx * my * above + inside * have.gain * along,
        mx * sy * above + inside * have.gain * down,
    )


@njit(cache=True, nogil=True, error_model="numpy")
def agreement(image: Plane, at: Map, look: Look, have: Levels) -> float:
    """Return which share of the variation of an image around a face its picture explains."""
    here, skip = region(image, at), _skip(at, look)
    n, total, squares, wrong = 0.0, 0.0, 0.0, 0.0
    for r in range(here.top, here.bottom + 1, skip):
        for c in range(here.left, here.right + 1, skip):
            x, y = on_face(here, at, c, r)
            if abs(x) > HALF_LENGTH + _MARGIN or abs(y) > HALF_WIDTH + _MARGIN:
                continue
            grey = float(image[r, c])
            off = grey - _expected(here, look, have, x, y)[0]
            n += 1.0
            total += grey
            squares += grey * grey
            wrong += off * off
    varied = squares - total * total / max(n, 1.0)
    return _share(varied - wrong, varied, n)


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _share(explained: float, varied: float, pixels: float) -> float:
    """Return which share of squares is explained of what noise does not explain."""
    noise = pixels * NOISE * NOISE
    return explained / max(varied - noise, _LEAST_CONTRAST * noise, _LEAST_SPREAD)


@njit(cache=True, nogil=True, error_model="numpy")
def step(image: Plane, at: Map, look: Look) -> Map:
    """Return a map that fits better: one step of Gauss and Newton."""
    here, skip, have = region(image, at), _skip(at, look), levels(image, at, look)
    sums = np.zeros((4, 6))
    limit = _OUTLIER * max(have.spread, NOISE)
    for r in range(here.top, here.bottom + 1, skip):
        for c in range(here.left, here.right + 1, skip):
            x, y = on_face(here, at, c, r)
            if abs(x) > HALF_LENGTH + _MARGIN or abs(y) > HALF_WIDTH + _MARGIN:
                continue
            model, gx, gy = _expected(here, look, have, x, y)
            if gx == 0.0 and gy == 0.0:
                continue
            off = model - float(image[r, c])
            _add(sums, (x, y), (gx, gy), off, min(1.0, limit / max(abs(off), NOISE)))
    normal, right = _equations(sums)
    # A map is almost a similarity: x stretches and turns as y does.
    stiff = (max(have.spread, NOISE) / _SHAPE) ** 2
    for k in (2, 3, 4, 5):
        normal[k, k] += stiff
    normal[5, 2] -= stiff
    normal[4, 3] += stiff
    if have.gain == 0.0 or not solve(normal, right):
        return at
    return _composed(at, right)


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _add(
    sums: NDArray[np.float64],
    place: tuple[float, float],
    slopes: tuple[float, float],
    off: float,
    weight: float,
) -> None:
    """Add one pixel to the sums (4, 6) from which `_equations` are made."""
    x, y = place
    gx, gy = weight * slopes[0], weight * slopes[1]
    products = (gx * slopes[0], gx * slopes[1], gy * slopes[1])
    moments = (1.0, x, y, x * x, x * y, y * y)
    for j in range(6):
        for i in range(3):
            sums[i, j] += products[i] * moments[j]
    for j in range(3):
        sums[3, j] += gx * off * moments[j]
        sums[3, j + 3] += gy * off * moments[j]


@njit(cache=True, nogil=True, error_model="numpy")
def _equations(
    sums: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the normal equations (6, 6), (6,) for shift, and x and y in x and in y."""
    normal, right = np.empty((6, 6)), np.empty(6)
    for i in range(6):
        slope, factor = _SLOPE[i], _FACTOR[i]
        right[i] = sums[3, 3 * slope + factor]
        for j in range(6):
            normal[i, j] = sums[slope + _SLOPE[j], _MOMENT[factor][_FACTOR[j]]]
    return normal, right


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _composed(at: Map, d: NDArray[np.float64]) -> Map:
    """Return the map of a place that has moved on the face: x + d0 + d2 x + d3 y, likewise y."""
    return Map(
        at.u + at.ax * d[0] + at.bx * d[1],
        at.v + at.ay * d[0] + at.by * d[1],
        at.ax * (1.0 + d[2]) + at.bx * d[4],
        at.ay * (1.0 + d[2]) + at.by * d[4],
        at.bx * (1.0 + d[5]) + at.ax * d[3],
        at.by * (1.0 + d[5]) + at.ay * d[3],
    )
