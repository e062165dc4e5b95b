"""What a camera sees and where a template tracker finds the target in it, in one compiled call."""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.camera.pencil import Pencil, draw
from seamark.sim.camera.scene import Buffers
from seamark.sim.numerics.arrays import Array
from seamark.sim.trackers.template.frame_step import (
    FOUND,
    PART_TOO_SMALL,
    likely_part,
    track_frame,
    unpack_state,
)
from seamark.sim.trackers.template.level_buffers import Bench, fetch_templates, unpack_search
from seamark.sim.trackers.template.tracker import Memory


class Sight(NamedTuple):
    """A template tracker that has started, and what the grey images that it gets are drawn with."""

    pencil: Pencil
    memory: Memory


@njit(cache=True, nogil=True, error_model="numpy")
def look(
    sight: Sight,
    motion: Array,
    frame: int,
    buffers: Buffers,
    canvas: NDArray[np.uint8],
    bench: Bench,
    corners: Array,
) -> bool:
    """Draw what the tracker needs of an image and give it that; return whether it has the target.

    That is a part of its window in most images: where the target is expected.

    Parameters
    ----------
    motion : (12,)
        Pose and velocities, as `Camera` has them.
    canvas : (H, W)
        Any image of this size, which is drawn over.
    bench
        At least as large as that of the tracker's levels.
    corners : (8,) [px]
        Where the tracker last had the target, updated.
    """
    pencil, memory = sight
    state, search, numbers, store, box = memory
    window = (box[0], box[1], box[2], box[3])
    levels = unpack_search(search).levels
    fetch_templates(numbers, store, levels)
    found = PART_TOO_SMALL
    for part in (likely_part(state, levels, window), window):
        if found == PART_TOO_SMALL:
            draw(pencil, motion, frame, part, buffers, canvas)
            found, _, _ = track_frame(canvas, part, box, state, search, numbers, store, bench)
    if found == FOUND:
        last = unpack_state(state).last
        for k in range(8):
            corners[k] = last[k // 2, k % 2]
    return found == FOUND
