"""Compares a place in an image with the library, and moves it to where it fits best."""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.detectors.template.frame import CELLS, SIDE, Patches, across, normalise
from seamark.sim.numerics.libm import cos, sin
from seamark.sim.numerics.simd import WIDTH, f32x16, horizontal_sum, load

Octaves = tuple[NDArray[np.float32], ...]  # an image, and three that are halved again and again
_OCTAVES = 4
_PASSES = 3  # over the coordinates of a pose
_SHIFT, _STRETCH, _TURN = 0.05, 0.10, 0.15  # E: first steps, in lengths, of it, in rad
_NEXT_STEP = 0.6  # E
_WAYS = 8


class Pose(NamedTuple):
    """Where a thing is in an image."""

    u: float  # [px] its middle
    v: float
    length: float  # [px]
    heading: float  # [rad] of its length, from u to v


class Likeness(NamedTuple):
    """What the library says about places."""

    values: NDArray[np.float64]  # (n, kinds) correlation with the look of a kind that is most like
    looks: NDArray[np.int64]  # (n, kinds) which of the library that is
    contrast: NDArray[np.float64]  # (n,) [grey] as if of single pixels, see `_take`


def octaves(image: NDArray[np.uint8]) -> Octaves:
    """Return an image at four resolutions."""
    every = [image.astype(np.float32)]
    for _ in range(_OCTAVES - 1):
        every.append(_halved(every[-1]))
    return tuple(every)


@njit(cache=True, nogil=True, error_model="numpy")
def _halved(image: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return an image of half the size, of the means of four pixels."""
    rows, columns = image.shape[0] // 2, image.shape[1] // 2
    out = np.empty((rows, columns), np.float32)
    for r in range(rows):
        for c in range(columns):
            upper = image[2 * r, 2 * c] + image[2 * r, 2 * c + 1]
            lower = image[2 * r + 1, 2 * c] + image[2 * r + 1, 2 * c + 1]
            out[r, c] = np.float32(0.25) * (upper + lower)
    return out


@njit(cache=True, nogil=True, error_model="numpy")
def _take(images: Octaves, pose: Pose, patch: Patches) -> float:
    """Fill a patch (1, CELLS) with what an image shows at a pose, normalised.

    Returns its spread [grey], times by how much its octave averages the noise of pixels down.
    """
    cell_px = (across(1) - across(0)) * pose.length
    octave = 0
    while octave < len(images) - 1 and cell_px > 1.5 * (1 << octave):
        octave += 1
    image, size = images[octave], float(1 << octave)
    rows, columns = image.shape
    cosine, sine = cos(pose.heading), sin(pose.heading)
    for cell in range(CELLS):
        x, y = across(cell % SIDE) * pose.length, across(cell // SIDE) * pose.length
        u = (pose.u + cosine * x - sine * y + 0.5) / size - 0.5
        v = (pose.v + sine * x + cosine * y + 0.5) / size - 0.5
        u, v = min(max(u, 0.0), columns - 1.001), min(max(v, 0.0), rows - 1.001)
        i, j = int(u), int(v)
        a, b = u - i, v - j
        upper = image[j, i] + a * (image[j, i + 1] - image[j, i])
        lower = image[j + 1, i] + a * (image[j + 1, i + 1] - image[j + 1, i])
        patch[0, cell] = upper + b * (lower - upper)
    return float(size * normalise(patch))


@njit(cache=True, nogil=True, error_model="numpy")
def _likeness(patch: Patches, patches: Patches, row: int) -> float:
    """Return the correlation of a patch with one of the library, from -1 to 1."""
    total = f32x16(0.0)
    for at in range(0, CELLS, WIDTH):
        total = total + load(patch, 0, at) * load(patches, row, at)
    return horizontal_sum(total)


@njit(cache=True, nogil=True, error_model="numpy")
def compare(
    images: Octaves, poses: NDArray[np.float64], patches: Patches, kinds: NDArray[np.int64]
) -> Likeness:
    """Return how much each place, a row of poses (n, 4), is like each kind of the library."""
    count = poses.shape[0]
    found = Likeness(
        np.full((count, kinds.max() + 1), -1.0),
        np.zeros((count, kinds.max() + 1), np.int64),
        np.zeros(count),
    )
    patch = np.empty((1, CELLS), np.float32)
    for k in range(count):
        pose = Pose(poses[k, 0], poses[k, 1], poses[k, 2], poses[k, 3])
        found.contrast[k] = _take(images, pose, patch)
        for row in range(patches.shape[0]):
            value, kind = _likeness(patch, patches, row), kinds[row]
            if value > found.values[k, kind]:
                found.values[k, kind], found.looks[k, kind] = value, row
    return found


@njit(cache=True, nogil=True, error_model="numpy")
def refine(
    images: Octaves,
    poses: NDArray[np.float64],
    patches: Patches,
    looks: NDArray[np.int64],
    passes: int = _PASSES,
) -> None:
    """Move each pose to where the image is more like its look: coordinate by coordinate."""
    patch = np.empty((1, CELLS), np.float32)
    for k in range(poses.shape[0]):
        pose = Pose(poses[k, 0], poses[k, 1], poses[k, 2], poses[k, 3])
        _take(images, pose, patch)
        best, step = _likeness(patch, patches, looks[k]), 1.0
        for _ in range(passes):
            for way in range(_WAYS):
                trial = _moved(pose, way, step)
                _take(images, trial, patch)
                value = _likeness(patch, patches, looks[k])
                if value > best:
                    best, pose = value, trial
            step *= _NEXT_STEP
        poses[k, 0], poses[k, 1], poses[k, 2], poses[k, 3] = pose


@njit(cache=True, nogil=True, error_model="numpy")
def _moved(pose: Pose, way: int, step: float) -> Pose:
    """Return a pose that differs in one coordinate, to one side or the other."""
    signed = step if way % 2 == 0 else -step
    coordinate = way // 2
    if coordinate == 0:
        return Pose(pose.u + _SHIFT * signed * pose.length, pose.v, pose.length, pose.heading)
    if coordinate == 1:
        return Pose(pose.u, pose.v + _SHIFT * signed * pose.length, pose.length, pose.heading)
    if coordinate == 2:
        return Pose(pose.u, pose.v, pose.length * (1.0 + _STRETCH * signed), pose.heading)
    return Pose(pose.u, pose.v, pose.length, pose.heading + _TURN * signed)
