"""Where the links of a vehicle with an arm are, from the vehicle's pose and the arm's joints."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from seamark.sim.multibody.assembly import Assembly
from seamark.sim.multibody.mechanism import state_for, work_for
from seamark.sim.multibody.tree import FREE, Frames, Links, Structure, place, write_bias
from seamark.sim.multibody.workpiece import MOTION, OTHER_MOTION
from seamark.sim.numerics.arrays import Array, Integers
from seamark.sim.numerics.compilation import SameTypes
from seamark.sim.numerics.uncounted import uncounted
from seamark.sim.physics.pose import write_pose

VEHICLE_MOTION = 12  # numbers: pose and velocities
_STEP_S = 1.0  # of the model, which does not move


class _Motion(NamedTuple):
    """Where the numbers of a motion belong."""

    joints: Integers  # (j, 3) coordinate, degree of freedom and motor of each joint
    ratio: Array  # (j,) of the joint's speed to its motor's
    work: Integers  # (3,) coordinate and degree of freedom of a workpiece, 1 if it is free; or (0,)
    others: Integers  # (m, 2) coordinate and degree of freedom of other free things


class Posture:
    """The links of a vehicle with an arm and of what it works on, in the order of a mechanism."""

    def __init__(
        self, assembly: Assembly, workpiece: str | None = None, others: Sequence[str] = ()
    ) -> None:
        """Take a mechanism; `workpiece` is the link of a workpiece, `others` of other things."""
        mechanism = assembly.mechanism
        self._model = mechanism.model(_STEP_S)
        self._state, self._frames = state_for(self._model), work_for(self._model).frames
        self._push = np.zeros(6)
        structure = self._model.structure
        followed = {one.link: (one.other, one.ratio) for one in mechanism.couplings}
        joints, ratios = [], []
        for number, link in enumerate(mechanism.links):
            motor, ratio = followed.get(link.name, (link.name, 1.0))
            if motor in assembly.motors:
                at = structure.coordinate[number], structure.speed[number]
                joints.append((*at, assembly.motors.index(motor)))
                ratios.append(ratio)
        work = []
        if workpiece is not None:
            number = mechanism.number(workpiece)
            free = structure.joint[number] == FREE
            work = [structure.coordinate[number], structure.speed[number], free]
        self._belong = _Motion(
            np.array(joints, np.int64).reshape(-1, 3),
            np.array(ratios, np.float64),
            np.array(work, np.int64),
            np.array(
                [
                    (structure.coordinate[number], structure.speed[number])
                    for number in map(mechanism.number, others)
                ],
                np.int64,
            ).reshape(-1, 2),
        )
        self._place = SameTypes(place_and_move)

    def place(self, motion: Array) -> tuple[Array, Array, Array]:
        """Return where the links are; the arrays are valid until the next call.

        Parameters
        ----------
        motion : (12 + 2 a,) or (26 + 2 a + 12 m,)
            Pose of the vehicle [m, rad], velocities in its body frame [m/s, rad/s], coordinates of
            the joints of the arm's motors [rad or m], and their speeds; a may be more than these.
            Then the first numbers of `workpiece.measure`, if there is a workpiece, and pose and
            velocities of each other thing.

        Returns
        -------
        (k, 3, 3), (k, 3), (k, 6)
            Rotations to world axes, positions NED [m], twists over ground in the link's axes.
        """
        model, frames, moving = self._model, self._frames, (self._state.q, self._state.v)
        # A copy, of the type that is compiled for: a motion may be read-only or strided.
        own = np.array(motion, np.float64)
        self._place.call(
            own, self._belong, model.structure, model.links, moving, self._push, frames
        )
        return frames.rotation, frames.position, frames.twist


@uncounted
def place_and_move(
    motion: Array,
    belong: _Motion,
    structure: Structure,
    links: Links,
    moving: tuple[Array, Array],
    push: Array,
    frames: Frames,
) -> None:
    """Write rotations, positions and twists over ground of all links, in water at rest.

    `moving` are coordinates and speeds, which take the motion.
    """
    q, v = moving
    end = motion.size
    for k in range(belong.others.shape[0] - 1, -1, -1):
        end -= OTHER_MOTION
        _place_free(motion[end:], q[belong.others[k, 0] :], v[belong.others[k, 1] :])
    if belong.work.size:
        end -= MOTION
        coordinate, speed, free = belong.work[0], belong.work[1], belong.work[2]
        if free:
            _place_free(motion[end:], q[coordinate:], v[speed:])
        else:
            q[coordinate], v[speed] = motion[end + 12], motion[end + 13]
    _place_free(motion, q, v)
    motors = (end - VEHICLE_MOTION) // 2
    for i in range(belong.ratio.size):
        joint = VEHICLE_MOTION + belong.joints[i, 2]
        q[belong.joints[i, 0]] = belong.ratio[i] * motion[joint]
        v[belong.joints[i, 1]] = belong.ratio[i] * motion[joint + motors]
    place(structure, links, q, frames)
    write_bias(structure, links, v, push, frames)


@uncounted
def _place_free(motion: Array, q: Array, v: Array) -> None:
    """Write pose and velocities, the first twelve numbers, to the first of q and v."""
    write_pose(motion, q)
    for a in range(6):
        v[a] = motion[6 + a]
