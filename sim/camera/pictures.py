"""Pictures that targets and seabeds are covered with: painted patterns, photographs, users' own.

All have the same size, mean grey and contrast, so that what differs is their structure. The
photographs are files beside this module (textures/LICENSE.md); patterns use only an integer hash
and + - * /, so that every processor gives the same bytes. A user's own covers a target's top as it
is, and goes on mirrored at the sides.
"""

import math
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.camera.seabed import TILE, hash01, packed, padded, value_noise
from seamark.sim.files import target_pictures

Picture = NDArray[np.uint8]  # (SIDE, SIDE)

SIDE = 512  # [px] of a picture: mirrored along both axes it is a seamless tile
PHOTOGRAPHS = ("brick", "camera", "coffee", "grass", "gravel")
PAINTED = ("mosaic", "mottle")
PICTURES = (*PAINTED, *PHOTOGRAPHS)
MEAN, SPREAD = 112.0, 46.0  # [grey] mean and standard deviation of the photographs
_FOLDER = Path(__file__).with_name("textures")
_MOSAIC_CELLS = ((7, 1.0), (19, 0.8), (53, 0.6))  # cells along a side, weight; E
_MOTTLE_CELLS = ((6, 0.5), (14, 1.0), (31, 1.0), (67, 0.8), (150, 0.6))  # as above
_OWN = (SIDE - target_pictures.HEIGHT) // 2, (SIDE - target_pictures.WIDTH) // 2  # its corner
_OWN_KEPT = 4
_FACE_OFFSET_PX = 150  # from the cut-out of a face to the next, so that no two look alike


@dataclass(frozen=True, slots=True)
class Cutout:
    """What part of a picture covers the faces of a box."""

    picture: str  # of PICTURES, or a user's own
    row: int  # [px] of the upper left corner of the first face, in the seamless tile
    column: int


def cutout(name: str, row_share: float, column_share: float) -> Cutout:
    """Return a part of a picture at a place given by shares of the tile; of a user's, its own."""
    if target_pictures.LIBRARY.is_own(name):
        return Cutout(name, *_OWN)
    return Cutout(name, int(row_share * TILE), int(column_share * TILE))


@lru_cache(maxsize=len(PICTURES) + _OWN_KEPT)
def picture(name: str) -> Picture:
    """Return a picture, (SIDE, SIDE)."""
    own = target_pictures.LIBRARY.get(name)
    if own is not None:
        row, column = _OWN
        return np.pad(own, ((row, row), (column, column)), mode="symmetric")
    if name == "mosaic":
        return _mosaic()
    if name == "mottle":
        return _mottle()
    image = cv2.imread(str(_FOLDER / f"{name}.png"), cv2.IMREAD_GRAYSCALE)
    if image is None or image.shape != (SIDE, SIDE):
        raise RuntimeError(f"{name}.png is missing below {_FOLDER}, or has another size")
    return np.asarray(image, np.uint8)


def tile(name: str) -> NDArray[np.uint8]:
    """Return a seamless tile (TILE, TILE): the picture and its mirror images."""
    quarter = picture(name)
    upper = np.hstack([quarter, quarter[:, ::-1]])
    return np.vstack([upper, upper[::-1]])


@lru_cache(maxsize=len(PICTURES))
def seabed(name: str) -> NDArray[np.uint16]:
    """Return the packed tile of a seabed, as `seamark.sim.camera.seabed.seabed` does."""
    return padded(packed(tile(name), wrap=True))


def face(cutout: Cutout, columns: int, rows: int, *, number: int) -> NDArray[np.float64]:
    """Return the albedo (rows, columns) of one face of a box: two pixels of the picture per texel.

    Smoothed by a binomial filter, since a texel is half a pixel of the camera, and with the mean
    and contrast of a whole picture, so that no cut-out is much easier to track than another.
    """
    first = cutout.row + _FACE_OFFSET_PX * number
    down = np.arange(first - 2, first + 2 * rows + 2) % TILE
    across = np.arange(cutout.column - 2, cutout.column + 2 * columns + 2) % TILE
    whole = tile(cutout.picture)[np.ix_(down, across)].astype(np.int64)
    fours = whole[::2, ::2] + whole[1::2, ::2] + whole[::2, 1::2] + whole[1::2, 1::2]
    smooth = fours[:-2] + 2 * fours[1:-1] + fours[2:]
    smooth = smooth[:, :-2] + 2 * smooth[:, 1:-1] + smooth[:, 2:]
    # Sums of integers are exact in any order, and so are the same on every processor.
    mean = int(smooth.sum()) / smooth.size
    variance = int((smooth * smooth).sum()) / smooth.size - mean * mean
    return _in_range(smooth, mean, math.sqrt(max(variance, 1.0))) / 255.0


def _in_range(
    pattern: NDArray[np.float64] | NDArray[np.int64], mean: float, spread: float
) -> NDArray[np.float64]:
    """Return a pattern, whose mean and standard deviation are given, like the photographs."""
    grey: NDArray[np.float64] = np.clip(MEAN + SPREAD / spread * (pattern - mean), 8.0, 247.0)
    return grey


def _in_grey(pattern: NDArray[np.float64], mean: float, spread: float) -> Picture:
    """Return a pattern in whole grey levels, as `_in_range`."""
    return (_in_range(pattern, mean, spread) + 0.5).astype(np.uint8)


def _mosaic() -> Picture:
    return _in_grey(_tiles(np.array(_MOSAIC_CELLS)), 0.061, 0.385)


def _mottle() -> Picture:
    return _in_grey(_clouds(np.array(_MOTTLE_CELLS)), 0.035, 0.738)


@njit(cache=True, nogil=True, error_model="numpy")
def _tiles(layers: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return layers of tiles, (SIDE, SIDE): each cell has a tone from -1 to 1 of its own."""
    out = np.zeros((SIDE, SIDE))
    for layer in range(layers.shape[0]):
        cells, weight = layers[layer]
        for j in range(SIDE):
            for i in range(SIDE):
                x, y = i * cells / SIDE, j * cells / SIDE
                shifted = x + hash01(0, int(y), 900 + layer)  # each row of tiles by its own length
                tone = 2.0 * hash01(int(shifted), int(y), 300 + layer) - 1.0
                out[j, i] += 0.5 * weight * tone
    return out


@njit(cache=True, nogil=True, error_model="numpy")
def _clouds(octaves: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a sum of octaves of value noise, (SIDE, SIDE)."""
    out = np.zeros((SIDE, SIDE))
    for octave in range(octaves.shape[0]):
        cells, weight = octaves[octave]
        for j in range(SIDE):
            for i in range(SIDE):
                out[j, i] += weight * value_noise(i / SIDE, j / SIDE, int(cells), 500 + octave)
    return out
