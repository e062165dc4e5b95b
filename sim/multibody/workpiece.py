"""What a vehicle with an arm works on: things in the world, and how far the work has come."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit

from seamark.sim.multibody.assembly import Assembly, Frame, Mounting
from seamark.sim.multibody.step import Model
from seamark.sim.multibody.tree import FREE, Frames, place
from seamark.sim.multibody.vectors import Vector, dot, minus, plus, rotate, three
from seamark.sim.numerics.arrays import Array, Integers
from seamark.sim.numerics.borrowed import borrowed
from seamark.sim.numerics.libm import asin, atan2

MOTION = 14  # numbers of `measure` that images depend on: pose, velocities, joint and its speed
OTHER_MOTION = 12  # likewise of each other thing: pose and velocities
_REACH, _TOOL, MEASURED = 14, 15, 21


@dataclass(frozen=True, slots=True, kw_only=True)
class Workpiece:
    """Things in the world, one link of which is worked on.

    The names of links and shapes are those in the mechanism, with the prefix of their mounting.
    """

    things: tuple[Mounting, ...]
    link: str  # that is followed: it moves freely or on a joint
    shapes: tuple[str, ...]  # whose contacts are those of the workpiece
    grip: tuple[float, float, float]  # [m] where the tool should go, axes of the link
    # What trackers look for: the middle of a rectangle, whose x axis is to the right and whose
    # y axis is downwards as one reads its letters; length and width [m].
    face: Frame
    size_m: tuple[float, float]
    # Things that look like it but are not to be worked on; each has one link, which moves freely.
    others: tuple[str, ...] = ()
    other_shapes: tuple[str, ...] = ()

    def corners(self) -> Array:
        """Return the corners of the face in the axes of its link, (4, 3) [m].

        In reading order: upper left, upper right, lower right, lower left.
        """
        x, y = 0.5 * self.size_m[0], 0.5 * self.size_m[1]
        return np.array(
            [self.face.at((a, b, 0.0)) for a, b in ((-x, -y), (x, -y), (x, y), (-x, y))]
        )


class Points(NamedTuple):
    """Where the work is measured."""

    links: Integers  # (2,) of the tool and of the workpiece
    at: Array  # (2, 3) [m] tool centre point and grip, in the axes of their links
    turn: Array  # (3, 3) from the tool's axes into those of its link
    others: Integers  # (m,) links of other things


def points_of(workpiece: Workpiece, assembly: Assembly) -> Points:
    """Return where work is measured.

    Raises
    ------
    ValueError
        The arm has no tool.
    """
    if assembly.tool is None:
        raise ValueError("an arm that works on something needs a tool centre point")
    number = assembly.mechanism.number
    return Points(
        links=np.array([number(assembly.tool.link), number(workpiece.link)]),
        at=np.array([assembly.tool.point, workpiece.grip]),
        turn=np.ascontiguousarray(assembly.tool.turn),
        others=np.array([number(name) for name in workpiece.others], dtype=np.int64),
    )


@njit(cache=True, error_model="numpy")
def measure(model: Model, q: Array, v: Array, points: Points, frames: Frames, out: Array) -> None:
    """Write pose and motion of the workpiece, and how far the tool is from its grip.

    Parameters
    ----------
    frames
        A buffer.
    out : (21 + 12 m,)
        Pose [m NED, rad] and velocities over ground in its axes [m/s, rad/s] of the link, if it is
        free, else its pose alone; coordinate and speed of its joint, if it has one [rad or m];
        distance of the tool centre point from the grip [m]; pose of the tool. Then pose and
        velocities of each other thing.
    """
    model, points, frames = borrowed(model), borrowed(points), borrowed(frames)
    structure = model.structure
    place(structure, model.links, q, frames)
    number = points.links[1]
    out[6:MOTION] = 0.0
    if structure.joint[number] == FREE:
        _write_free(number, structure.speed[number], v, frames, out)
    else:
        _write_pose(number, frames, out)
        out[12], out[13] = q[structure.coordinate[number]], v[structure.speed[number]]
    for k in range(points.others.size):
        other = points.others[k]
        _write_free(other, structure.speed[other], v, frames, out[MEASURED + k * OTHER_MOTION :])
    tool = points.links[0]
    there = _point(tool, three(points.at, 0, 0), frames)
    grip = _point(number, three(points.at, 1, 0), frames)
    off = minus(grip, there)
    out[_REACH] = math.sqrt(dot(off, off))
    out[_TOOL], out[_TOOL + 1], out[_TOOL + 2] = there
    turn = np.zeros((3, 3))
    for a in range(3):
        for b in range(3):
            for c in range(3):
                turn[a, b] += frames.rotation[tool, a, c] * points.turn[c, b]
    _write_attitude(turn, out[_TOOL + 3 :])


@njit(cache=True, error_model="numpy", inline="always")
def _write_pose(link: int, frames: Frames, out: Array) -> None:
    for a in range(3):
        out[a] = frames.position[link, a]
    _write_attitude(frames.rotation[link], out[3:6])


@njit(cache=True, error_model="numpy", inline="always")
def _write_free(link: int, speed: int, v: Array, frames: Frames, out: Array) -> None:
    """Write pose and velocities of a link that moves freely, whose first speed is at `speed`."""
    _write_pose(link, frames, out)
    for a in range(6):
        out[6 + a] = v[speed + a]


@njit(cache=True, error_model="numpy", inline="always")
def _point(link: int, point: Vector, frames: Frames) -> Vector:
    """Return a point of a link in the world [m]."""
    return plus(three(frames.position, link, 0), rotate(frames.rotation, link, point))


@njit(cache=True, error_model="numpy", inline="always")
def _write_attitude(rotation: Array, out: Array) -> None:
    """Write roll, pitch and yaw [rad] of axes, (3, 3), whose rotation is to world axes."""
    out[0] = atan2(rotation[2, 1], rotation[2, 2])
    out[1] = asin(min(max(-rotation[2, 0], -1.0), 1.0))
    out[2] = atan2(rotation[1, 0], rotation[0, 0])
