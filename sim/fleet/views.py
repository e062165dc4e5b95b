"""What the cameras of a fleet see, and where their trackers find the target, in compiled loops.

A camera and its tracker are those of a single vehicle: their arrays are lent (`lent.py`), and the
kernels are the same, so every pixel and corner has the same bits.
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.camera.camera import Camera
from seamark.sim.camera.pencil import Pencil, draw
from seamark.sim.camera.rows import interleave
from seamark.sim.camera.scene import buffers_for
from seamark.sim.camera.survey import Survey, survey
from seamark.sim.engine.sight import Sight, look
from seamark.sim.fleet.tables import Progress
from seamark.sim.numerics.arrays import Array, Flags, Integers
from seamark.sim.numerics.borrowed import borrowed
from seamark.sim.numerics.lanes import LANES
from seamark.sim.numerics.lent import lend, recalled
from seamark.sim.physics.pose import read_pose
from seamark.sim.trackers.template.level_buffers import bench_for

Image = NDArray[np.uint8]


class Pencils(NamedTuple):
    """The cameras of a fleet: a row of words for each channel of each of them."""

    words: Integers  # (n, channels, k)
    like: Pencil  # of the types that the words have


class Trackers(NamedTuple):
    """The template trackers of a fleet, and the cameras whose grey images they are given."""

    words: Integers  # (n, k) of their sights
    like: Sight
    size: tuple[int, int]  # width and height of the images [px]
    bench_size: int  # that the largest of them needs


class Found(NamedTuple):
    """What the trackers of a fleet report."""

    corners: Array  # (n, 8) [px] the last valid ones
    visible: Flags  # (n,)


class Shots(NamedTuple):
    """Images of a fleet on their way: where the cameras were when they were taken."""

    every: int  # control steps from one image to the next
    motions: Array  # (slots, n, 12) as `Camera` has them
    frames: Integers  # (slots, n) numbers since the trial began
    pencils: Pencils  # that they are drawn with
    copies: Image  # (n, height, width, channels) of the newest images, written; or empty


def pencils_for(count: int, camera: Camera, channels: tuple[int, ...]) -> Pencils:
    """Return a table for the cameras of `count` vehicles, of which this is one."""
    like = camera.pencil(channels[0])
    words = np.zeros((count, len(channels), lend(like).size), np.int64)
    return Pencils(words, like)


def lend_camera(pencils: Pencils, i: int, camera: Camera, channels: tuple[int, ...]) -> None:
    """Put a vehicle's camera into the table; it must live as long as it is there."""
    pencils.words[i] = [lend(camera.pencil(number)) for number in channels]


@njit(cache=True, nogil=True, error_model="numpy")
def motions_of(
    first: int, last: int, chosen: Flags, states: Array, moving: bool, motions: Array, read: Flags
) -> None:
    """Write the poses of the chosen vehicles of some blocks, and if `moving` their velocities.

    Parameters
    ----------
    states : (n, 13 or more)
    motions : (n, 12)
    read : (n,)
        Whether a vehicle is chosen and its state finite.
    """
    states, motions = borrowed(states), borrowed(motions)
    for i in range(first * LANES, min(last * LANES, chosen.size)):
        read[i] = chosen[i] and read_pose(states[i], motions[i, :6])
        for k in range(6):
            motions[i, 6 + k] = states[i, 7 + k] if moving else 0.0


@njit(cache=True, nogil=True, error_model="numpy")
def draw_all(
    first: int,
    last: int,
    chosen: Flags,
    motions: Array,
    frames: Integers,
    pencils: Pencils,
    out: Image,
) -> None:
    """Draw whole images of the chosen vehicles of some blocks.

    Parameters
    ----------
    motions : (n, 12)
        Poses and body velocities, as `Camera` has them.
    frames : (n,)
        Number of each image since the trial began.
    out : (n, height, width, channels)
        Channels as many as the pencils have, in their order.
    """
    count, height, width, channels = out.shape
    own = buffers_for(width)
    planes = np.empty((channels, height, width), np.uint8)
    buffers, pencils, motions = borrowed(own), borrowed(pencils), borrowed(motions)
    window = (0, 0, width, height)
    for i in range(first * LANES, min(last * LANES, count)):
        if not chosen[i]:
            continue
        if channels == 1:
            image = out[i].reshape(height, width)
            pencil = recalled(pencils.words[i, 0], pencils.like)
            draw(pencil, motions[i], frames[i], window, buffers, image)
            continue
        for k in range(channels):
            pencil = recalled(pencils.words[i, k], pencils.like)
            draw(pencil, motions[i], frames[i], window, buffers, planes[k])
        a, b, c = planes[0].ravel(), planes[1].ravel(), planes[2].ravel()
        interleave(a, b, c, out[i].ravel())
    own.levels[0] = 0  # the owner of `buffers` must live until here


@njit(cache=True, nogil=True, error_model="numpy")
def survey_all(
    first: int, last: int, chosen: Flags, motions: Array, pencils: Pencils, out: Survey
) -> None:
    """Write depth and labels, (n, height, width) each, of the chosen vehicles' images.

    Parameters are as those of `draw_all`.
    """
    pencils, motions, out = borrowed(pencils), borrowed(motions), borrowed(out)
    for i in range(first * LANES, min(last * LANES, chosen.size)):
        if chosen[i]:
            pencil = recalled(pencils.words[i, 0], pencils.like)
            survey(motions[i, :6], pencil.scene, Survey(out.depth[i], out.labels[i]))


@njit(cache=True, nogil=True, error_model="numpy")
def track_all(
    first: int,
    last: int,
    chosen: Flags,
    motions: Array,
    frames: Integers,
    trackers: Trackers,
    found: Found,
) -> None:
    """Give the chosen vehicles' trackers, which have started, their next images.

    Parameters are as those of `draw_all`.
    """
    width, height = trackers.size
    own, sheet = buffers_for(width), np.empty((height, width), np.uint8)
    table = bench_for(trackers.bench_size)
    buffers, canvas, bench = borrowed(own), borrowed(sheet), borrowed(table)
    motions = borrowed(motions)
    trackers, found = borrowed(trackers), borrowed(found)
    for i in range(first * LANES, min(last * LANES, chosen.size)):
        if not chosen[i]:
            continue
        sight = recalled(trackers.words[i], trackers.like)
        corners = found.corners[i]
        found.visible[i] = look(sight, motions[i], frames[i], buffers, canvas, bench, corners)
    # The owners of what was borrowed must live until here.
    own.levels[0], sheet[0, 0], table[0] = 0, 0, 0.0


@njit(cache=True, nogil=True, error_model="numpy")
def show_all(
    first: int,
    last: int,
    chosen: Flags,
    present: tuple[Array, Integers],
    progress: Progress,
    shots: Shots,
    images: Image | None,
    surveys: Survey | None,
) -> None:
    """Take an image with each of the chosen vehicles of some blocks, and render what arrives now.

    The others keep their images and surveys, which are None where they are not wanted. `present`
    are motions and frames as of `draw_all`, and become those of what is rendered.
    """
    motions, frames = present
    new = np.zeros(chosen.size, np.bool_)
    slots = shots.motions.shape[0]
    for i in range(first * LANES, min(last * LANES, chosen.size)):
        if not chosen[i]:
            continue
        step = progress.step[i]
        taken = step - progress.late[i, 0]
        new[i] = step == 0 or (taken > 0 and taken % shots.every == 0)
        at = max(taken, 0) % slots
        shots.frames[step % slots, i] = frames[i]
        frames[i] = shots.frames[at, i]
        for k in range(motions.shape[1]):
            shots.motions[step % slots, i, k] = motions[i, k]
            motions[i, k] = shots.motions[at, i, k]
    if images is not None:
        draw_all(first, last, new, motions, frames, shots.pencils, images)
        for i in range(first * LANES, min(last * LANES, shots.copies.shape[0])):
            image, copy = images[i].ravel(), shots.copies[i].ravel()
            for k in range(image.size):
                copy[k] = image[k]
    if surveys is not None:
        survey_all(first, last, new, motions, shots.pencils, surveys)
