"""How strongly places of the seabed scatter, relative to its mean: patches, ripples and stones.

A tile that repeats every 51 m, made of an integer hash and IEEE arithmetic alone, so that every
processor has the same.
"""

from functools import cache

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.camera.seabed import hash01, value_noise
from seamark.sim.numerics.libm import exp

TILE, TEXEL_M = 512, 0.1  # [texel, m] a power of two; half of a beam's width at 11 m
_NEPERS = 0.2302585092994046  # of intensity in a dB
# E: [dB] standing for patches of shell and mud, and for ripples that a beam does not resolve.
_PATCHES = ((6, 3.0), (20, 2.5), (80, 2.0), (256, 1.0))  # cells across the tile, greatest deviation
_STONES, _STONE_DB = 0.0006, 12.0  # E: one in 17 m², as strong as concrete


@cache
def strength_tile() -> NDArray[np.float32]:
    """Return the backscatter relative to its mean, (TILE, TILE)."""
    tile: NDArray[np.float64] = _paint(11)
    mean = tile.sum() / tile.size
    relative: NDArray[np.float32] = (tile / mean).astype(np.float32)
    return relative


@njit(cache=True, error_model="numpy")
def _paint(seed: int) -> NDArray[np.float64]:
    tile = np.empty((TILE, TILE))
    for j in range(TILE):
        for i in range(TILE):
            level, x, y = 0.0, (i + 0.5) / TILE, (j + 0.5) / TILE
            for octave in range(len(_PATCHES)):
                cells, most = _PATCHES[octave]
                level += most * value_noise(x, y, cells, seed + octave)
            if hash01(i, j, seed + 40) < _STONES:
                level += _STONE_DB
            tile[j, i] = exp(_NEPERS * level)
    return tile
