"""Bringing a hand to a handle from above, with the tool of the arm pointing down.

See it, come over it, come down; then the work begins, which is for subclasses. What was seen is
remembered in axes that stay level and north-up, by dead reckoning, because the arm hides it from
the camera now and then.
"""

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

from seamark.sim.control.manipulation.arm_data import Vector
from seamark.sim.control.manipulation.arm_reading import data_of, mount_of
from seamark.sim.control.manipulation.kinematics import (
    ArmKinematics,
    Matrix,
    applied,
    column,
    cross,
    damped,
    dot,
    length,
    minus,
    plus,
    product,
    rotation,
    times,
)
from seamark.sim.control.manipulation.sight import Corners, Pinhole, Seen, find
from seamark.sim.control.observation import Observation
from seamark.sim.numerics.libm import PI, atan2, sincos
from seamark.sim.vehicles import load
from seamark.sim.vehicles.linkage_reading import load_linkage

# Joints with the tool pointing down, well within their ranges.
WORKING = {"arm-5e-like": (0.0, 0.45, 0.6, 0.0), "alpha-like": (0.0, 0.45, 3.1, 0.0)}
FALL_M_S, SINK_M_S = 0.04, 0.12  # slowly, and before
LOOK_M = 0.3  # from the place above the grip, to learn the drift of the reckoning
NEAR_M, OVER_M = 0.1, 0.05  # horizontally: to come down, and to go on coming down
MARGIN_RAD = 0.03  # of the range of a joint
KP, KI = 0.7, 0.15  # [1/s, 1/s²] of the vehicle, level
KZ = 0.25  # [1/s] slower than the depth control that it moves the set point of
KJ = 2.0  # [1/s] of the joints
LEARN = 0.25  # share of a new sighting in what is remembered
LOW_M = 0.15  # of the tool above the grip, from which on it does not look
BELIEVED_M = 0.03  # of a correction on the way down
MOST_DRIFT_M_S = 0.02  # of the reckoning
LEANING_S = 4.0  # over which the attitude is averaged
SEE, COME, FALL, WORK = range(4)  # phases; subclasses may have more after these


class Approach(ABC):
    """The steps up to the handle; what is done with it, and how, is for subclasses."""

    label: ClassVar[str]
    HANDLE_M: ClassVar[float]  # above the face that is tracked
    HANDLE_RAD: ClassVar[float]  # of the handle from the face's first side
    ABOVE_M: ClassVar[float] = 0.25  # of the tool above the grip, to come down from
    DRIFT: ClassVar[float] = 0.04  # share of a correction in the drift of the reckoning [1/s]
    SLOW_M: ClassVar[float] = 0.3  # of the tool above the grip, from where it comes down slowly
    SETTLE_S: ClassVar[float] = 0.0  # for which it looks before it comes down
    FASTEST_M_S: ClassVar[float] = 0.25  # of the vehicle
    OPEN_RAD: ClassVar[float] = 0.6  # of a jaw
    BOTTOM_M: ClassVar[float]  # of the tool above the grip, where the work begins

    def __init__(self, config: Mapping[str, Any]) -> None:
        vehicle, arm = load(config["vehicle"]), load_linkage(config["arm"])
        self.kinematics = ArmKinematics(data_of(arm), mount_of(vehicle, arm.name))
        self.camera = Pinhole.told(config)
        self.face_m = tuple(config["face_m"])
        self.working = WORKING[arm.name]
        self.wrist = self.kinematics.reaching[-1]
        self.jaw = len(self.working)

    def reset(self, level: Mapping[str, float | int]) -> None:
        """Forget everything."""
        self.dt = float(level["dt"])
        self.phase, self.since_s = SEE, 0.0
        self.looked_s = 0.0  # for which it has been above the grip
        self.place = [0.0, 0.0]  # [m] of the vehicle, north and east of its start
        self.work: Vector | None = None  # [m] grip, north and east of the start, depth
        self.handle = 0.0  # [rad] direction of the handle
        self.drift = [0.0, 0.0]  # [m/s] of the reckoning, north and east
        self.integral = [0.0, 0.0]  # [m/s] north, east
        self.offset = self.ABOVE_M  # [m] of the tool above the grip
        self.falling = 0.0
        self.touching = 0  # parts of the hand

    def step(self, observation: Observation) -> Sequence[float]:
        """Return surge, sway, heave [m/s], yaw rate [rad/s] and the speeds of the joints."""
        self.touching = int(sum(observation.touch.tolist()))
        roll, pitch, yaw = self._attitude(observation)
        tilt, joints = rotation(roll, pitch, 0.0), self._joints(observation)
        velocity = applied(tilt, self._velocity(observation))
        self._reckon(velocity, yaw)
        self._look(observation, tilt, yaw)
        self.since_s += self.dt
        if self.work is None:
            return [0.0] * 4 + self._posture(joints, 0.0)
        grip = self._grip(observation, yaw)
        tool = self.kinematics.tool(joints)
        error = minus(minus(grip, (0.0, 0.0, self.offset)), applied(tilt, tool.point))
        self._advance(observation, error, joints)
        speeds = self._posture(joints, self._wrist_angle(joints, tilt, yaw))
        wanted = self._compensate(error, joints, tilt, velocity, observation, speeds)
        return [*self._fly(wanted, yaw, observation), self._turn(joints, tilt, yaw), *speeds]

    # How things are known

    def _attitude(self, observation: Observation) -> Vector:
        roll, pitch, yaw = observation.attitude.tolist()
        return roll, pitch, yaw

    def _velocity(self, observation: Observation) -> Vector:
        u, v, w = observation.velocity.tolist()
        return u, v, w

    def _joints(self, observation: Observation) -> list[float]:
        joints: list[float] = observation.joints.tolist()
        return joints

    def _rates(self, observation: Observation) -> Vector:
        p, q, r = observation.rates.tolist()
        return p, q, r

    def _reckon(self, velocity: Vector, yaw: float) -> None:
        north, east = turned(velocity, yaw)
        self.place[0] += north * self.dt
        self.place[1] += east * self.dt
        for axis in (0, 1):
            self.place[axis] -= self.drift[axis] * self.dt

    def _depth(self, observation: Observation) -> float:
        return float(observation.depth)

    def _look(self, observation: Observation, tilt: Matrix, yaw: float) -> None:
        """Learn where the handle is, until the work begins."""
        seen = self._seen(observation, tilt) if self.phase < WORK else None
        if seen is not None:
            self._learn(seen, yaw, observation)

    def _seen(self, observation: Observation, tilt: Matrix) -> Seen | None:
        """Return where the face is, if it is seen."""
        if not observation.target_visible:
            return None
        return self._find(observation.corners.tolist(), tilt)

    def _find(self, corners: Corners, tilt: Matrix) -> Seen | None:
        return find(corners, self.face_m, self.camera, tilt)

    def _learn(self, seen: Seen, yaw: float, observation: Observation) -> None:
        north, east = turned(seen.centre, yaw)
        depth = self._depth(observation) + seen.centre[2] - self.HANDLE_M
        place = (self.place[0] + north, self.place[1] + east, depth)
        self.handle = yaw + seen.yaw + self.HANDLE_RAD
        if self.work is None:
            self.work = place
        else:
            self._correct(minus(place, self.work))

    def _correct(self, off: Vector) -> None:
        """Learn where the handle is, and the drift of the reckoning: the handle stands still."""
        if self.phase == FALL:  # the lower the hand, the more of the face it hides
            off = (off[0], off[1], 0.0)
            if self.offset < LOW_M or dot(off, off) > BELIEVED_M * BELIEVED_M:
                return
        if self.work is not None:
            self.work = plus(self.work, times(off, LEARN))
        for axis in (0, 1):
            self.drift[axis] = clipped(self.drift[axis] + self.DRIFT * off[axis], MOST_DRIFT_M_S)

    def _grip(self, observation: Observation, yaw: float) -> Vector:
        """Return where the grip is from the body's origin, level axes turned with the heading."""
        if self.work is None:
            raise RuntimeError("the work has not been seen")
        off = (self.work[0] - self.place[0], self.work[1] - self.place[1], 0.0)
        ahead, side = turned(off, -yaw)
        return ahead, side, self.work[2] - self._depth(observation)

    # What is done

    def _advance(self, observation: Observation, error: Vector, joints: list[float]) -> None:
        """Go to the next step if this one is done, or back."""
        off = math.sqrt(error[0] * error[0] + error[1] * error[1])
        self.falling = 0.0
        if self.phase == SEE:
            self._go(COME)
        elif self.phase == COME:
            if off < LOOK_M and abs(error[2]) < LOOK_M:
                self.looked_s += self.dt
            near = off < NEAR_M and abs(error[2]) < 0.1 and self.looked_s > self.SETTLE_S
            if near and self.since_s > 2.0 and self._ready():
                self._go(FALL)
        elif self.phase == FALL:
            self._fall(off, error[2])
        else:
            self._work(observation, error, joints)

    def _fall(self, off: float, above: float) -> None:
        if off < OVER_M and self.offset > self.BOTTOM_M:
            self.falling = FALL_M_S if self.offset <= self.SLOW_M else SINK_M_S
            self.offset -= self.falling * self.dt
        elif off > 2.0 * NEAR_M:
            self._again()
        if self.offset <= self.BOTTOM_M and abs(above) < 0.02 and off < OVER_M:
            self._go(WORK)

    def _ready(self) -> bool:
        """Return whether the hand may come down."""
        return True

    @abstractmethod
    def _work(self, observation: Observation, error: Vector, joints: list[float]) -> None:
        """Go to the next step of the work if this one is done, or back."""

    def _again(self) -> None:
        self.looked_s = 0.0
        self.offset = self.ABOVE_M
        self._go(COME)

    def _go(self, phase: int) -> None:
        self.phase, self.since_s = phase, 0.0

    def _posture(self, joints: list[float], wrist: float) -> list[float]:
        """Return the speeds of the joints towards the working posture."""
        fastest = self.kinematics.fastest
        wanted = [*self.working]
        wanted[self.wrist] = wrist
        speeds = [
            clipped(KJ * (want - now), most)
            for want, now, most in zip(wanted, joints, fastest, strict=False)
        ]
        return [*speeds, self._jaw_speed(joints)]

    def _jaw_speed(self, joints: list[float]) -> float:
        """Return the speed of the jaws, which opens them."""
        return clipped(KJ * (self.OPEN_RAD - joints[self.jaw]), self.kinematics.fastest[self.jaw])

    def _wrist_angle(self, joints: list[float], tilt: Matrix, yaw: float) -> float:
        """Return the angle of the wrist at which the jaws open across the handle."""
        angle = self._across(joints, tilt, yaw)
        low, high = self.kinematics.ranges[self.wrist]
        fitting = [a for a in (angle - PI, angle, angle + PI) if low + 0.05 < a < high - 0.05]
        return min(fitting, key=lambda a: abs(a - joints[self.wrist]), default=0.0)

    def _across(self, joints: list[float], tilt: Matrix, yaw: float) -> float:
        """Return the same, within plus or minus pi; half a turn from it they do so, too."""
        straight = [*joints]
        straight[self.wrist] = 0.0
        turn = product(tilt, self.kinematics.tool(straight).turn)
        sine, cosine = sincos(self.handle - yaw)
        along = (cosine, sine, 0.0)
        return atan2(-dot(column(turn, 1), along), dot(column(turn, 2), along))

    def _compensate(
        self,
        error: Vector,
        joints: list[float],
        tilt: Matrix,
        velocity: Vector,
        observation: Observation,
        speeds: list[float],
    ) -> Vector:
        """Return the error that is left to the vehicle; may change the speeds of joints."""
        point = self.kinematics.tool(joints).point
        return self._left(error, point, point, tilt)

    def _left(self, error: Vector, point: Vector, home: Vector, tilt: Matrix) -> Vector:
        """Return what the vehicle must move for the tool to be right with the arm in its posture.

        `point` is where the tool is in the body, `home` where it is in that posture.
        """
        return minus(error, applied(tilt, minus(home, point)))

    def _fly(self, error: Vector, yaw: float, observation: Observation) -> list[float]:
        """Return surge, sway and heave that take the error away."""
        north, east = turned(error, yaw)
        for axis, off in enumerate((north, east)):
            if abs(off) < NEAR_M:
                self.integral[axis] = clipped(self.integral[axis] + KI * off * self.dt, 0.1)
        ahead, side = turned((self.integral[0], self.integral[1], 0.0), -yaw)
        surge = clipped(KP * error[0], self.FASTEST_M_S) + ahead
        sway = clipped(KP * error[1], self.FASTEST_M_S) + side
        return [surge, sway, self.falling + clipped(KZ * error[2], self.FASTEST_M_S)]

    def _turn(self, joints: list[float], tilt: Matrix, yaw: float) -> float:
        """Return the yaw rate: the heading stays."""
        return 0.0


class Steady(Approach):
    """Lets the vehicle chase how it lies in the mean, not each swing."""

    def reset(self, level: Mapping[str, float | int]) -> None:
        """Forget everything."""
        super().reset(level)
        self.attitude = (0.0, 0.0, 0.0)
        self.leaning = [0.0, 0.0]  # [rad] roll and pitch in the mean

    def step(self, observation: Observation) -> Sequence[float]:
        """Return the command."""
        self.attitude = self._attitude(observation)
        return super().step(observation)

    def _left(self, error: Vector, point: Vector, home: Vector, tilt: Matrix) -> Vector:
        """Return what the vehicle must move; with the tool right as it lies in the mean."""
        for axis in (0, 1):
            off = self.attitude[axis] - self.leaning[axis]
            self.leaning[axis] += off * self.dt / LEANING_S
        mean = rotation(self.leaning[0], self.leaning[1], 0.0)
        return minus(plus(error, applied(tilt, point)), applied(mean, home))


class FirstLook(Approach):
    """Looks for the first seconds of a level only, and then goes by dead reckoning."""

    LOOK_S: ClassVar[float]

    def reset(self, level: Mapping[str, float | int]) -> None:
        """Forget everything."""
        super().reset(level)
        self.looks_to_s = float(level["t"]) + self.LOOK_S

    def _look(self, observation: Observation, tilt: Matrix, yaw: float) -> None:
        if observation.t < self.looks_to_s:
            super()._look(observation, tilt, yaw)


class ArmCompensates(Approach):
    """The arm takes off what the vehicle leaves of the error, at the rate of its joints."""

    GAIN_1_S, DAMPING = 1.5, 0.05

    def _compensate(
        self,
        error: Vector,
        joints: list[float],
        tilt: Matrix,
        velocity: Vector,
        observation: Observation,
        speeds: list[float],
    ) -> Vector:
        if self._folded() or self.phase == SEE or (self.phase == COME and self.since_s < 2.0):
            return super()._compensate(error, joints, tilt, velocity, observation, speeds)
        tool, columns = self.kinematics.jacobian(joints)
        turning = cross(self._rates(observation), tool.point)
        moved = plus(self._from_the_goal(velocity), applied(tilt, turning))
        wanted = minus(limited(times(error, self.GAIN_1_S), 0.3), moved)
        numbers = [n for n in self.kinematics.reaching if n != self.wrist]
        ways = [applied(tilt, columns[n][0]) for n in numbers]
        for number, speed in zip(numbers, damped(ways, wanted, self.DAMPING), strict=True):
            low, high = self.kinematics.ranges[number]
            most = self.kinematics.fastest[number]
            # The joint stops at its range instead of running into it.
            speeds[number] = min(
                max(speed, -most, KJ * (low + MARGIN_RAD - joints[number])),
                *(most, KJ * (high - MARGIN_RAD - joints[number])),
            )
        posture = [*self.working]
        posture[self.wrist] = joints[self.wrist]
        return self._left(error, tool.point, self.kinematics.tool(posture).point, tilt)

    def _from_the_goal(self, velocity: Vector) -> Vector:
        """Return the vehicle's velocity relative to where the tool should be: as if that rested."""
        return velocity

    def _folded(self) -> bool:
        """Return whether the arm keeps its posture now."""
        return False


def turned(v: Vector, yaw: float) -> tuple[float, float]:
    """Return the level part of a vector, turned by an angle."""
    sine, cosine = sincos(yaw)
    return cosine * v[0] - sine * v[1], sine * v[0] + cosine * v[1]


def limited(v: Vector, most: float) -> Vector:
    """Return a vector that is no longer than this."""
    long = length(v)
    return v if long <= most else times(v, most / long)


def clipped(value: float, most: float) -> float:
    """Return a number within plus or minus another."""
    return min(max(value, -most), most)
