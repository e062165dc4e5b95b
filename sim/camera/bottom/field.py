"""A seabed with litter: things painted onto the whole tile, which repeats itself."""

from collections.abc import Sequence

import numpy as np

from seamark.sim.camera.bottom.bottom import GROUNDS, ground_tiles
from seamark.sim.camera.bottom.painter import NOBODY, Sun, Tiles, paint
from seamark.sim.camera.bottom.things import draw_thing
from seamark.sim.camera.seabed import TEXEL_M, TILE

TILE_M = TILE * TEXEL_M  # [m] north and east, after which it is the same again
PLACES = 7  # along the tile and across it
_JITTER = 0.35  # of the distance between places, to either side, E
_LONGEST_SHADOW = 0.7  # [m] per metre of height, E: as of `bottom`


def draw_field(random: np.random.Generator, names: Sequence[str], *, share: float) -> Tiles:
    """Return the three channels of a new seabed.

    Parameters
    ----------
    names
        Kinds of `things` that may lie there.
    share
        Of the places, at which something lies.
    """
    ground, north_sun, east_sun = random.random(3).tolist()
    tiles = ground_tiles(GROUNDS[int(ground * len(GROUNDS))]).copy()
    sun = Sun(_LONGEST_SHADOW * (2.0 * north_sun - 1.0), _LONGEST_SHADOW * (2.0 * east_sun - 1.0))
    owners = np.full((TILE, TILE), NOBODY, np.uint8)
    pitch = TILE_M / PLACES
    for place in range(PLACES * PLACES):
        row, column = divmod(place, PLACES)
        there, which, along, across = random.random(4).tolist()
        north = pitch * (row + 0.5 + _JITTER * (2.0 * along - 1.0))
        east = pitch * (column + 0.5 + _JITTER * (2.0 * across - 1.0))
        name = names[int(which * len(names))]
        thing = draw_thing(name, north, east, random, burial=1.0)
        if there < share:
            paint(tiles, owners, thing.shape, thing.place, sun, thing.number)
    return tiles
