"""What is where in an image, without water: depth and label of each pixel of box and seabed."""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.camera.faces import columns_inside, outlines
from seamark.sim.camera.geometry import camera_pose, map_along_row
from seamark.sim.camera.raycast import seabed_map
from seamark.sim.camera.scene import Scene
from seamark.sim.numerics.arrays import Array

SEABED, TARGET = 0, 1  # labels
_LEAST = 1e-3  # [1/m] inverse depth of what is farthest


class Survey(NamedTuple):
    """One image's truth."""

    depth: NDArray[np.float32]  # (H, W) [m] along the optical axis
    labels: NDArray[np.uint8]  # (H, W)


@njit(cache=True, nogil=True, error_model="numpy")
def survey(pose: Array, scene: Scene, out: Survey) -> None:
    """Write depth and label at the centre of each pixel, from a pose (6,)."""
    rotation, centre, ground = np.empty((3, 3)), np.empty(3), np.empty((3, 3))
    camera_pose(pose, scene.mount, rotation, centre)
    seabed_map(scene.seabed_m, rotation, centre, scene.intrinsics, ground)
    shapes = outlines(scene.faces, scene.layout, rotation, centre, scene.intrinsics)
    height, width = out.depth.shape
    for row in range(height):
        _write(ground, row, 0, width, SEABED, out)
        for k in range(shapes.seen.shape[0]):
            box = shapes.boxes[k]
            if shapes.seen[k] and box[1] <= row < box[3]:
                first, end = columns_inside(shapes.edges[k], float(row), 0, width, 0.0)
                _write(shapes.maps[k], row, first, end, TARGET, out)


@njit(cache=True, nogil=True, error_model="numpy")
def _write(plane: Array, row: int, first: int, end: int, label: int, out: Survey) -> None:
    """Write part of a row, of a plane whose `map` gives pixel -> texel/z, texel/z, 1/z."""
    _, _, inverse, _, _, slope = map_along_row(plane, float(row))
    for column in range(first, end):
        out.depth[row, column] = 1.0 / max(float(inverse + slope * column), _LEAST)
        out.labels[row, column] = label
