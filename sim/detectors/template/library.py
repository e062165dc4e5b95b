"""The library of the template detector: what things of each kind look like.

Many things of each kind are painted as those of a benchmark are, but from seeds of their own, on
every ground, and summed up in a few looks by spherical k-means (Dhillon & Modha 2001). That takes
half a minute, so the looks are stored: `python -m seamark.sim.detectors.template.library` writes
them anew.
"""

from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.camera.bottom.bottom import GROUNDS, ground_tiles
from seamark.sim.camera.bottom.painter import Sun, paint
from seamark.sim.camera.bottom.things import NAMES, draw_thing
from seamark.sim.camera.seabed import TEXEL_M, TILE
from seamark.sim.detectors.template.frame import CELLS, SIDE, Patches, across, normalise

GROUND = len(NAMES)  # the number of the kind of bare ground
KINDS = GROUND + 1
STORED = Path(__file__).with_name("looks.npy")
_SEED = 8_080_000  # + the number of a tile; no benchmark's
_TILES = 150  # each has one thing of every kind
_LOOKS, _PASSES = 12, 15  # of a kind, and of k-means, E
_GRID = 4  # things along and across a tile
_SUBSAMPLES = 4  # along a cell
_LONGEST_SHADOW = 0.7  # as of the benchmark's bottoms
_GROUNDS_A_TILE = 2
_GROUND_M = (0.1, 0.7)  # [m] sizes of bare ground
_GREEN = 1
_KIND, _PROPORTION, _PATCH = 0, 1, 2  # columns of a stored look


class Library(NamedTuple):
    """Normalised patches of things and of bare ground, each as it is and after half a turn."""

    patches: Patches  # (n, CELLS)
    kinds: NDArray[np.int64]  # (n,) index in NAMES, or GROUND
    proportions: NDArray[np.float64]  # (n,) width over length


@lru_cache(maxsize=1)
def library() -> Library:
    """Return the stored library."""
    stored = np.load(STORED).astype(np.float64)
    patches = stored[:, _PATCH:].astype(np.float32)
    return Library(
        np.concatenate([patches, patches[:, ::-1]]),
        np.tile(stored[:, _KIND].astype(np.int64), 2),
        np.tile(stored[:, _PROPORTION], 2),
    )


def painted() -> NDArray[np.float16]:
    """Return what is stored: kind, proportion and patch of each look."""
    seen: list[list[NDArray[np.float32]]] = [[] for _ in range(KINDS)]
    proportions: list[list[float]] = [[] for _ in range(KINDS)]
    for number in range(_TILES):
        random = np.random.Generator(np.random.PCG64(_SEED + number))
        ground = GROUNDS[number % len(GROUNDS)]
        tile, places = painted_tile(random, ground)
        for kind, (north, east, length, width) in enumerate(places):
            seen[kind].append(_seen(tile, north, east, length))
            proportions[kind].append(width / length)
        bare, (low, high) = ground_tiles(ground)[_GREEN], _GROUND_M
        for north, east, share in random.random((_GROUNDS_A_TILE, 3)).tolist():
            size = low + (high - low) * share
            seen[GROUND].append(_seen(bare, north * TILE * TEXEL_M, east * TILE * TEXEL_M, size))
            proportions[GROUND].append(1.0)
    rows = []
    for kind in range(KINDS):
        looks, means = _clusters(
            np.concatenate(seen[kind]).astype(np.float64), np.array(proportions[kind])
        )
        rows.append(np.column_stack([np.full(_LOOKS, kind), means, looks]))
    return np.concatenate(rows).astype(np.float16)


def painted_tile(
    random: np.random.Generator, ground: str
) -> tuple[NDArray[np.uint8], list[tuple[float, float, float, float]]]:
    """Return a tile with one thing of each kind: north, east, length, width [m] of each."""
    tiles, owners = ground_tiles(ground).copy(), np.zeros((TILE, TILE), np.uint8)
    sun = Sun(*(_LONGEST_SHADOW * (2.0 * random.random(2) - 1.0)).tolist())
    pitch = TILE * TEXEL_M / _GRID
    places = []
    for kind, name in enumerate(NAMES):
        north, east = pitch * (kind % _GRID + 0.5), pitch * (kind // _GRID + 0.5)
        thing = draw_thing(name, north, east, random, burial=1.0)
        place = thing.place._replace(cosine=1.0, sine=0.0)
        paint(tiles, owners, thing.shape, place, sun, thing.number)
        places.append((north, east, thing.shape.length, thing.shape.width))
    return tiles[_GREEN], places


@njit(cache=True, nogil=True, error_model="numpy")
def _seen(tile: NDArray[np.uint8], north: float, east: float, length: float) -> NDArray[np.float32]:
    """Return the normalised patch (1, CELLS) around a thing whose length is along north."""
    patch = np.empty((1, CELLS), np.float32)
    step = (across(1) - across(0)) / _SUBSAMPLES
    first = -0.5 * (_SUBSAMPLES - 1)
    for cell in range(CELLS):
        total = 0.0
        for k in range(_SUBSAMPLES * _SUBSAMPLES):
            x = across(cell % SIDE) + (first + k % _SUBSAMPLES) * step
            y = across(cell // SIDE) + (first + k // _SUBSAMPLES) * step
            i = int(np.floor((north + x * length) / TEXEL_M)) & (TILE - 1)
            j = int(np.floor((east + y * length) / TEXEL_M)) & (TILE - 1)
            total += tile[j, i]
        patch[0, cell] = total / (_SUBSAMPLES * _SUBSAMPLES)
    normalise(patch)
    return patch


@njit(cache=True, nogil=True, error_model="numpy")
def _product(one: NDArray[np.float64], other: NDArray[np.float64]) -> float:
    total = 0.0
    for cell in range(CELLS):
        total += one[cell] * other[cell]
    return total


@njit(cache=True, nogil=True, error_model="numpy")
def _nearest(looks: NDArray[np.float64], patch: NDArray[np.float64]) -> int:
    nearest, most = 0, -2.0
    for k in range(_LOOKS):
        value = _product(looks[k], patch)
        if value > most:
            nearest, most = k, value
    return nearest


@njit(cache=True, nogil=True, error_model="numpy")
def _clusters(
    patches: NDArray[np.float64], proportions: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the looks (_LOOKS, CELLS) of normalised patches, and the proportion of each."""
    looks, means = np.empty((_LOOKS, CELLS)), np.zeros(_LOOKS)
    for k in range(_LOOKS):
        looks[k] = patches[k * patches.shape[0] // _LOOKS]
    for _ in range(_PASSES):
        sums, counts = np.zeros((_LOOKS, CELLS)), np.zeros(_LOOKS)
        means[:] = 0.0
        for row in range(patches.shape[0]):
            nearest = _nearest(looks, patches[row])
            sums[nearest] += patches[row]
            counts[nearest] += 1.0
            means[nearest] += proportions[row]
        for k in range(_LOOKS):
            if counts[k] > 0.0:
                looks[k] = sums[k] / np.sqrt(_product(sums[k], sums[k]))
                means[k] /= counts[k]
    return looks, means


if __name__ == "__main__":
    np.save(STORED, painted())
