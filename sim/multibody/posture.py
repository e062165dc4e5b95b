"""Where the links of a vehicle with an arm are, from the vehicle's pose and the arm's joints."""

from typing import NamedTuple

import numpy as np
from numba import njit

from seamark.sim.multibody.assembly import Assembly
from seamark.sim.multibody.mechanism import state_for, work_for
from seamark.sim.multibody.tree import FREE, Frames, Links, Structure, place, write_bias
from seamark.sim.multibody.workpiece import MOTION
from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.borrowed import borrowed
from seamark.sim.numerics.compilation import SameTypes
from seamark.sim.physics.dynamics import RIGID
from seamark.sim.physics.pose import write_pose

VEHICLE_MOTION = 12  # numbers: pose and velocities
_STEP_S = 1.0  # of the model, which does not move


class _Joint(NamedTuple):
    """A joint and the motor that it goes with."""

    coordinate: int
    speed: int
    motor: int
    ratio: float


class Posture:
    """The links of a vehicle with an arm and of what it works on, in the order of a mechanism."""

    def __init__(self, assembly: Assembly, workpiece: str | None = None) -> None:
        """Take a mechanism; `workpiece` is the name of the link of a workpiece in it."""
        mechanism = assembly.mechanism
        self._model = mechanism.model(_STEP_S)
        self._state, self._frames = state_for(self._model), work_for(self._model).frames
        self._push, self._rigid = np.zeros(6), np.zeros(RIGID)
        structure = self._model.structure
        followed = {one.link: (one.other, one.ratio) for one in mechanism.couplings}
        self._joints = []
        for number, link in enumerate(mechanism.links):
            motor, ratio = followed.get(link.name, (link.name, 1.0))
            if motor in assembly.motors:
                at = int(structure.coordinate[number]), int(structure.speed[number])
                self._joints.append(_Joint(*at, assembly.motors.index(motor), ratio))
        self._work = None if workpiece is None else mechanism.number(workpiece)
        if self._work is not None:
            self._free = bool(structure.joint[self._work] == FREE)
            self._at = int(structure.coordinate[self._work]), int(structure.speed[self._work])
        self._place = SameTypes(place_and_move)

    def place(self, motion: Array) -> tuple[Array, Array, Array]:
        """Return where the links are; the arrays are valid until the next call.

        Parameters
        ----------
        motion : (12 + 2 a,) or (26 + 2 a,)
            Pose of the vehicle [m, rad], velocities in its body frame [m/s, rad/s], coordinates of
            the joints of the arm's motors [rad or m], and their speeds; a may be more than these.
            Then the first numbers of `workpiece.measure`, if there is a workpiece.

        Returns
        -------
        (k, 3, 3), (k, 3), (k, 6)
            Rotations to world axes, positions NED [m], twists over ground in the link's axes.
        """
        q, v = self._state.q, self._state.v
        if self._work is not None:
            motion, work = np.split(motion, [-MOTION])
            self._place_work(work)
        joints, speeds = np.split(motion[VEHICLE_MOTION:], 2)
        write_pose(np.array(motion[:6]), self._rigid)
        q[:7], v[:6] = self._rigid[:7], motion[6:12]
        for joint in self._joints:
            q[joint.coordinate] = joint.ratio * joints[joint.motor]
            v[joint.speed] = joint.ratio * speeds[joint.motor]
        model, frames = self._model, self._frames
        self._place.call(model.structure, model.links, q, v, self._push, frames)
        return frames.rotation, frames.position, frames.twist

    def _place_work(self, work: Array) -> None:
        (coordinate, speed), q, v = self._at, self._state.q, self._state.v
        if not self._free:
            q[coordinate], v[speed] = work[12:MOTION]
            return
        write_pose(np.array(work[:6]), self._rigid)
        q[coordinate : coordinate + 7], v[speed : speed + 6] = self._rigid[:7], work[6:12]


@njit(cache=True, error_model="numpy")
def place_and_move(
    structure: Structure, links: Links, q: Array, v: Array, push: Array, frames: Frames
) -> None:
    """Write rotations, positions and twists over ground of all links, in water at rest."""
    frames = borrowed(frames)
    place(structure, links, q, frames)
    write_bias(structure, links, v, push, frames)
