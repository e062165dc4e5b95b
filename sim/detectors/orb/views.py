"""The views of the ORB detector: painted things and their features."""

from functools import lru_cache
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from seamark.sim.camera.bottom.things import OBJECTS
from seamark.sim.camera.seabed import TEXEL_M
from seamark.sim.detectors.template.library import painted_tile

_SEED = 8_090_000  # + the number of a tile; no benchmark's
_TILES = 4  # each has one view of every class, E
_FEATURES = 60  # of a view, E
_MARGIN_M = 0.03


class Views(NamedTuple):
    """Views of things, and all their features."""

    kinds: NDArray[np.int64]  # (views,) index of a class
    corners: NDArray[np.float64]  # (views, 4, 2) [texel]
    words: NDArray[np.uint64]  # (n, 4)
    points: NDArray[np.float64]  # (n, 2) [texel]
    views: NDArray[np.int64]  # (n,)


def features(
    finder: cv2.ORB, image: NDArray[np.uint8]
) -> tuple[NDArray[np.float64], NDArray[np.uint64]]:
    """Return points (n, 2) [px] and words (n, 4) of an image's features."""
    keys, words = finder.detectAndCompute(image, None)
    if words is None:
        return np.empty((0, 2)), np.empty((0, 4), np.uint64)
    points = np.array([key.pt for key in keys], np.float64)
    return points, np.ascontiguousarray(words).view(np.uint64)


@lru_cache(maxsize=1)
def views() -> Views:
    """Return the views, painted from seeds of their own."""
    finder = cv2.ORB.create(_FEATURES, edgeThreshold=8, patchSize=31)
    kinds: list[int] = []
    corners, words, points, owners = [], [], [], []
    for number in range(_TILES):
        random = np.random.Generator(np.random.PCG64(_SEED + number))
        tile, places = painted_tile(random, "sand")
        for kind, (north, east, length, width) in enumerate(places[:OBJECTS]):
            half = [int((0.5 * size + _MARGIN_M) / TEXEL_M) for size in (width, length)]
            row, column = int(east / TEXEL_M), int(north / TEXEL_M)
            shown = tile[row - half[0] : row + half[0], column - half[1] : column + half[1]]
            at, bits = features(finder, np.ascontiguousarray(shown))
            a, b = 0.5 * length / TEXEL_M, 0.5 * width / TEXEL_M
            plan = np.array([[-a, -b], [a, -b], [a, b], [-a, b]])
            corners.append(plan + np.array([half[1], half[0]]) - 0.5)
            owners.append(np.full(len(at), len(kinds)))
            kinds.append(kind)
            words.append(bits)
            points.append(at)
    return Views(
        np.array(kinds),
        np.array(corners),
        np.concatenate(words),
        np.concatenate(points),
        np.concatenate(owners),
    )
