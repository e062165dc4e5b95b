"""A bottom with one object of each class and one of each decoy, in a strip that a camera passes."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from seamark.sim.camera import pictures
from seamark.sim.camera.bottom.painter import NOBODY, Sun, Tiles, packed_tile, paint
from seamark.sim.camera.bottom.things import NAMES, OBJECTS, Thing, draw_thing
from seamark.sim.camera.camera import SAND
from seamark.sim.camera.seabed import SEABED_SEED, TEXEL_M, TILE, texels

STRIP_M = TILE * TEXEL_M  # length of the strip, along north
_ROWS, _ROW_M = 2, 0.80  # rows of cells side by side, E
_CELLS = len(NAMES) // _ROWS
_CELL_M = STRIP_M / _CELLS
_JITTER = 0.35  # of a cell, to either side: neighbours may overlap a little, E
_TINTS: dict[str, tuple[float, float, float]] = {  # red, green, blue of photographs, E
    "grass": (0.78, 1.0, 0.55),
    "gravel": (1.06, 1.0, 0.90),
}
GROUNDS = (SAND, *_TINTS)
_LONGEST_SHADOW = 0.7  # [m] per metre of height, E: light in water comes from above


@dataclass(frozen=True, slots=True, kw_only=True)
class Bottom:
    """A painted strip. It repeats itself every STRIP_M, as the tile that it is."""

    ground: str  # of GROUNDS
    east_m: float  # of the strip's middle
    objects: tuple[Thing, ...]  # one of each, in the order of NAMES
    decoys: tuple[Thing, ...]  # likewise
    visible: tuple[float, ...]  # share of each object and decoy that is not covered
    tiles: Tiles  # of the three channels

    def packed(self, channel: int) -> NDArray[np.uint16]:
        """Return the tile of one channel for the ray-caster."""
        return packed_tile(self.tiles[channel])


def draw_bottom(random: np.random.Generator, *, burial: float = 1.0) -> Bottom:
    """Return a new bottom.

    Parameters
    ----------
    burial
        From 0 to 1: how deep things may lie in the sand, relative to each kind's deepest.
    """
    shares = random.random(4).tolist()
    ground = GROUNDS[int(shares[0] * len(GROUNDS))]
    east_m = STRIP_M * shares[1]
    sun = Sun(_LONGEST_SHADOW * (2.0 * shares[2] - 1.0), _LONGEST_SHADOW * (2.0 * shares[3] - 1.0))
    cells = random.permutation(len(NAMES)).tolist()
    jitter = random.random((len(NAMES), 2)).tolist()
    things = []
    for name, cell, (along, across) in zip(NAMES, cells, jitter, strict=True):
        column, row = divmod(cell, _ROWS)
        north = _CELL_M * (column + 0.5 + _JITTER * (2.0 * along - 1.0))
        east = _ROW_M * (row + 0.5 - 0.5 * _ROWS + _JITTER * (2.0 * across - 1.0))
        things.append(draw_thing(name, north, east_m + east, random, burial=burial))
    tiles, owners = ground_tiles(ground).copy(), np.full((TILE, TILE), NOBODY, np.uint8)
    outlines = np.zeros(len(things))
    for at in random.permutation(len(things)).tolist():  # who lies on whom
        thing = things[at]
        outlines[at] = paint(tiles, owners, thing.shape, thing.place, sun, thing.number)
    shown = np.bincount(owners.ravel(), minlength=len(things) + 1)[1:]
    return Bottom(
        ground=ground,
        east_m=east_m,
        objects=tuple(things[:OBJECTS]),
        decoys=tuple(things[OBJECTS:]),
        visible=tuple(np.minimum(shown / np.maximum(outlines, 1.0), 1.0).tolist()),
        tiles=tiles,
    )


@lru_cache(maxsize=len(GROUNDS))
def ground_tiles(name: str) -> Tiles:
    """Return the three channels of a ground without things."""
    if name == SAND:
        return np.stack([texels(SEABED_SEED, channel) for channel in range(3)])
    grey = pictures.tile(name).astype(np.int64)
    # Whole numbers, so that no rounding depends on the processor.
    return np.stack([np.minimum(grey * round(100 * t) // 100, 255) for t in _TINTS[name]]).astype(
        np.uint8
    )
