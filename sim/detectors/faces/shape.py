"""The coarse search for faces: places that look like one, whichever way up."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.detectors.faces.picture import HALF_LENGTH, HALF_WIDTH, pictures
from seamark.sim.detectors.template.frame import CELLS, SIDE, Patches, across, normalise
from seamark.sim.detectors.template.matching import Octaves, compare, refine
from seamark.sim.detectors.template.search import Prototypes, places, turned
from seamark.sim.numerics.libm import PI

_LENGTHS_PX = (26.0, 34.0, 44.0, 56.0, 72.0)  # of faces, levels of the search
_TURNS = 8  # headings in half a turn, E
_SIDE = 10  # [cell] of the window of the search
_GROUND = 0.5  # E: how bright the ground is, from ink to paint
_SUBSAMPLES = 4  # along a cell
_PLACES = 5  # of each length, E
_REFINED = ((14, 1), (4, 2))  # E: places and passes, first many places roughly
_LEAST = 0.5  # E: of a hundred faces one is less alike, and half of what are none
_NEAR = 0.25  # lengths, E: two places that are nearer are one if their lengths are alike, too
_ALIKE = 1.2  # E
_KIND = np.zeros(1, np.int64)


class Shape(NamedTuple):
    """What is searched."""

    prototypes: Prototypes
    patch: Patches  # (1, CELLS) that places are compared with


def candidates(image: NDArray[np.uint8], images: Octaves, shape: Shape) -> NDArray[np.float64]:
    """Return the poses (n, 4) at which faces may be, the most likely first."""
    prototypes, patch = shape
    poses = places(image, (prototypes,), _PLACES)
    for most, passes in _REFINED:
        poses = _ranked(poses, compare(images, poses, patch, _KIND).values[:, 0], most)
        refine(images, poses, patch, np.zeros(len(poses), np.int64), passes)
    likeness = compare(images, poses, patch, _KIND).values[:, 0]
    alike = likeness > _LEAST
    return _ranked(poses[alike], likeness[alike], len(poses))


def _ranked(
    poses: NDArray[np.float64], likeness: NDArray[np.float64], most: int
) -> NDArray[np.float64]:
    """Return the poses, the most likely first, without those that are almost as another one."""
    return _apart(poses[np.argsort(-likeness, kind="stable")], most)


@njit(cache=True, nogil=True, error_model="numpy")
def _apart(poses: NDArray[np.float64], most: int) -> NDArray[np.float64]:
    kept = np.empty((most, poses.shape[1]))
    n = 0
    for pose in poses:
        alone = True
        for other in kept[:n]:
            away = max(abs(pose[0] - other[0]), abs(pose[1] - other[1]))
            long, short = max(pose[2], other[2]), min(pose[2], other[2])
            alone = alone and (away >= _NEAR * pose[2] or long >= _ALIKE * short)
        if alone and n < most:
            kept[n] = pose
            n += 1
    return kept[:n]


@lru_cache(maxsize=1)
def shape() -> Shape:
    """Return what is searched: the face on the ground, whichever way up."""
    patch = np.array([_mean_of_cell(cell) for cell in range(CELLS)], np.float32)[None]
    normalise(patch)
    headings = [PI * k / _TURNS for k in range(_TURNS)]
    weights = [turned(patch[0].astype(np.float64), heading, _SIDE) for heading in headings]
    found = Prototypes(_SIDE, np.concatenate(weights), np.array(headings), _LENGTHS_PX)
    return Shape(found, patch)


def _mean_of_cell(cell: int) -> float:
    """Return the mean of a cell of the frame around a face that lies on the ground."""
    (picture,) = pictures().either
    rows, columns = picture.shape
    step = (across(1) - across(0)) / _SUBSAMPLES
    total = 0.0
    for k in range(_SUBSAMPLES**2):
        x = across(cell % SIDE) + (k % _SUBSAMPLES - 0.5 * (_SUBSAMPLES - 1)) * step
        y = across(cell // SIDE) + (k // _SUBSAMPLES - 0.5 * (_SUBSAMPLES - 1)) * step
        if max(abs(x) / HALF_LENGTH, abs(y) / HALF_WIDTH) < 1.0:
            column = int((x / HALF_LENGTH + 1.0) * 0.5 * columns)
            total += float(picture[int((y / HALF_WIDTH + 1.0) * 0.5 * rows), column])
        else:
            total += _GROUND
    return total / _SUBSAMPLES**2
