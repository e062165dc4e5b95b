"""Paints things onto a bottom: outline, burial, light and shadow, all at one texel.

A bottom is a seamless tile like that of `camera.seabed`, three channels of it. What is painted last
covers what lies below it. Seen obliquely, a thing stays as flat as its picture: no side of it comes
into sight (E: heights are a tenth of the camera's altitude).
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.camera.bottom.shapes import Shape, stains, surface
from seamark.sim.camera.seabed import STRIDE, TEXEL_M, TILE

Tiles = NDArray[np.uint8]  # (3, TILE, TILE) red, green, blue in 255ths of the albedo
Owners = NDArray[np.uint8]  # (TILE, TILE) number of the thing that is seen at a texel, 0: none
NOBODY = 0

_MASK = TILE - 1
_EDGE_M = 0.006  # over which sand runs out on a buried thing
_SHADOW = 0.5  # share of the light that the sun has in water, E
_STEPS = 8  # heights at which a shadow is looked for
_STEEPEST = 2.0
_WEED = (0.14, 0.17, 0.08)  # albedo of growth, E
_SILT = 0.9  # albedo of settled dust, relative to the bottom around


class Place(NamedTuple):
    """Where a thing lies, and what became of it there."""

    north: float  # [m]
    east: float  # [m]
    cosine: float  # of its heading: from north to its x axis, towards east
    sine: float
    burial: float  # from 0 to 0.5: about the share of its outline below the sand
    growth: float  # from 0 to 1
    dust: float  # from 0 to 1


class Sun(NamedTuple):
    """Direction of the light: how far a shadow reaches per metre of height."""

    north: float
    east: float


@njit(cache=True, nogil=True, error_model="numpy")
def _clamped(value: float) -> float:
    return min(max(value, 0.0), 1.0)


class Patch(NamedTuple):
    """The texels around a thing."""

    north: int  # [texel] of the first row and column
    east: int
    heights: NDArray[np.float64]  # (n, n) [m]
    cover: NDArray[np.float64]  # (n, n) share of a texel that shows the thing
    colours: NDArray[np.float32]  # (n, n, 3)


@njit(cache=True, nogil=True, error_model="numpy")
def paint(tiles: Tiles, owners: Owners, shape: Shape, place: Place, sun: Sun, number: int) -> int:
    """Paint a thing; return how many texels its outline has, covered or not.

    `number` is what `owners` gets where more than half of a texel shows the thing.
    """
    shadow = shape.height * max(abs(sun.north), abs(sun.east))
    reach = 0.5 * np.sqrt(shape.length**2 + shape.width**2) + shadow + 3.0 * TEXEL_M
    n = int(2.0 * reach / TEXEL_M) + 2
    patch = Patch(
        int(np.floor((place.north - reach) / TEXEL_M)),
        int(np.floor((place.east - reach) / TEXEL_M)),
        np.zeros((n, n)),
        np.zeros((n, n)),
        np.zeros((n, n, 3), np.float32),
    )
    outline = _sampled(patch, tiles, shape, place)
    for j in range(1, n - 1):
        for i in range(1, n - 1):
            row, column = (patch.east + j) & _MASK, (patch.north + i) & _MASK
            alpha = patch.cover[j, i]
            ground = 1.0
            if alpha < 1.0:
                ground -= _SHADOW * _shadow_at(patch, i, j, shape.height, sun)
            light = _light_on(patch, i, j, sun) if alpha > 0.0 else 1.0
            for k in range(3):
                tone = _clamped(patch.colours[j, i, k] * light) * 255.0
                below = tiles[k, row, column] * ground
                tiles[k, row, column] = int(below + alpha * (tone - below) + 0.5)
            if alpha > 0.5:
                owners[row, column] = number
    return outline


@njit(cache=True, nogil=True, error_model="numpy")
def _sampled(patch: Patch, tiles: Tiles, shape: Shape, place: Place) -> int:
    """Fill a patch with what the thing shows; return how many texels its outline has."""
    outline = 0
    n = patch.heights.shape[0]
    for j in range(n):
        for i in range(n):
            dn = (patch.north + i + 0.5) * TEXEL_M - place.north
            de = (patch.east + j + 0.5) * TEXEL_M - place.east
            x = place.cosine * dn + place.sine * de
            y = place.cosine * de - place.sine * dn
            if abs(x) > 0.5 * shape.length + TEXEL_M or abs(y) > 0.5 * shape.width + TEXEL_M:
                continue
            sample = surface(x, y, shape)
            alpha = _clamped(sample.inside / TEXEL_M + 0.5)
            patch.heights[j, i] = sample.height
            if alpha == 0.0:
                continue
            outline += alpha > 0.5
            broad = stains(x, y, 5, shape.seed + 11) + 0.4 * stains(x, y, 17, shape.seed + 12)
            if place.burial > 0.0:
                sand = shape.height * (0.25 + 1.3 * place.burial + 0.9 * broad)
                alpha *= _clamped((sample.height - sand) / _EDGE_M + 0.5)
            patch.cover[j, i] = alpha
            fine = stains(x, y, 31, shape.seed + 13) + 0.5 * stains(x, y, 83, shape.seed + 14)
            grown = _clamped(1.6 * (fine + 2.2 * place.growth - 1.3))
            settled = place.dust * _clamped(0.5 + 0.6 * broad - 0.3 * fine)
            row, column = (patch.east + j) & _MASK, (patch.north + i) & _MASK
            for k in range(3):
                tone = sample.colour[k]
                tone += grown * (_WEED[k] - tone)
                silt = _SILT * tiles[k, row, column] / 255.0
                patch.colours[j, i, k] = tone + settled * (silt - tone)
    return outline


@njit(cache=True, nogil=True, error_model="numpy")
def _light_on(patch: Patch, i: int, j: int, sun: Sun) -> float:
    """Return the light on a thing relative to a level bottom, from the slope of its surface."""
    here = patch.heights[j, i]
    east = _slope(patch, here, (i, j + 1), (i, j - 1))
    north = _slope(patch, here, (i + 1, j), (i - 1, j))
    facing = (1.0 + sun.north * north + sun.east * east) / np.sqrt(
        1.0 + north * north + east * east
    )
    return float(1.0 - _SHADOW + _SHADOW * max(facing, 0.0))


@njit(cache=True, nogil=True, error_model="numpy")
def _slope(patch: Patch, here: float, one: tuple[int, int], other: tuple[int, int]) -> float:
    """Return the slope from the other neighbour of a texel to the one.

    Beyond the outline the surface goes on level.
    """
    after = patch.heights[one[1], one[0]] if patch.cover[one[1], one[0]] > 0.0 else here
    before = patch.heights[other[1], other[0]] if patch.cover[other[1], other[0]] > 0.0 else here
    return min(max((after - before) / (2.0 * TEXEL_M), -_STEEPEST), _STEEPEST)


@njit(cache=True, nogil=True, error_model="numpy")
def _shadow_at(patch: Patch, i: int, j: int, highest: float, sun: Sun) -> float:
    """Return how much of the sun a thing hides from a texel of the bottom."""
    n = patch.heights.shape[0]
    hidden = 0.0
    for step in range(1, _STEPS + 1):
        height = highest * step / _STEPS
        column = int(np.floor(i - sun.north * height / TEXEL_M + 0.5))
        row = int(np.floor(j - sun.east * height / TEXEL_M + 0.5))
        if min(row, column) < 0 or max(row, column) >= n or patch.cover[row, column] < 0.5:
            continue
        above = patch.heights[row, column] - height
        hidden = max(hidden, _clamped(above / (0.3 * highest) + 0.6))
    return hidden


@njit(cache=True, nogil=True, error_model="numpy")
def packed_tile(texels: NDArray[np.uint8]) -> NDArray[np.uint16]:
    """Return a tile of one channel as `seabed.packed` and `seabed.padded` do, in one pass."""
    out = np.zeros(TILE * STRIDE, np.uint16)
    for j in range(TILE):
        here, below = texels[j], texels[(j + 1) & _MASK]
        row = out[j * STRIDE : (j + 1) * STRIDE]
        for i in range(TILE):
            row[i] = np.uint16(here[i]) | np.uint16(below[i]) << np.uint16(8)
        row[TILE] = row[0]
    return out
