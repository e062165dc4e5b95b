"""What the network of the learned entry gets of an observation, and what its answer means.

An archive with a learned program has this text, too: `examples/imitation/train.py` packs it with
what it imports of this package. Its numbers are its own and do not follow those of the expert,
because the network has learned with them.
"""

import math
from collections.abc import Callable, Mapping
from typing import Any

from seamark.sim.control.manipulation.arm_data import Vector
from seamark.sim.control.manipulation.kinematics import (
    applied,
    length,
    minus,
    plus,
    product,
    rotation,
    times,
)
from seamark.sim.control.manipulation.sight import Pinhole, find
from seamark.sim.numerics.libm import sincos

PHASES = 5
SEE, COME, FALL, CLOSE, LIFT = range(PHASES)  # of the work, as the expert counts them
NEAR_M, LOOK_M = 0.1, 0.3  # from where on to learn the integral, and to count the time
LEARN, DRIFT = 0.25, 0.06  # shares of what was seen in what is remembered
MOST_DRIFT_M_S = 0.02  # of the reckoning
BELIEVED_M, LOW_M = 0.03, 0.15  # on the way down: of a correction, and from where on to look away
KI, MOST_INTEGRAL_M_S = 0.15, 0.1
LONGEST_S = (3.0, 8.0)
PATIENCE = 5  # control steps for which a new phase must be told in a row
HANDLE_M, ABOVE_M = 0.07, 0.6  # of the handle above the face, and of the tool above it to come
Network = Callable[[list[float]], tuple[list[float], list[float], list[float]]]


class Features:
    """Where the box is by sight and dead reckoning, and what the arm feels.

    Places are remembered in level axes, north and east; the network gets them ahead and to
    starboard. It gets no velocity: that tells what the expert did before, which a network may
    learn to repeat instead of what is needed (de Haan, Jayaraman and Levine 2019).
    """

    def __init__(self, config: Mapping[str, Any], tool: Vector) -> None:
        """Set up; `tool` is where the tool is in the body, with the arm in its posture [m]."""
        self.camera = Pinhole.told(config)
        self.face_m, self.tool = tuple(config["face_m"]), tool
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self.phase, self.since_s, self.near_s = SEE, 0.0, 0.0
        self.told, self.times = SEE, 0  # the phase that was told last, and how often in a row
        self.untouched = PATIENCE  # control steps since the hand was touched, at most so many
        self.goal = ABOVE_M  # height of the tool above the handle that the work asks for
        self.box: Vector | None = None  # [m] from the vehicle, and its depth
        self.heading = 0.0  # [rad] of its long side
        self.drift = self.integral = (0.0, 0.0, 0.0)  # [m/s] of the reckoning; of the control
        self.depth_before: float | None = None  # when the phase began

    def update(self, observation: Any) -> list[float]:
        """Return the features of an observation: 33 numbers for an arm of five joints."""
        o, (roll, pitch, yaw) = observation, observation.attitude.tolist()
        level, north, ahead = (
            rotation(*each) for each in ((roll, pitch, 0.0), (0.0, 0.0, yaw), (0.0, 0.0, -yaw))
        )
        if self.depth_before is None:
            self.depth_before = o.depth
        if self.box is not None:
            over_ground = minus(applied(product(north, level), _vector(o.velocity)), self.drift)
            self.box = minus(self.box, times((over_ground[0], over_ground[1], 0.0), o.dt))
        seen = bool(o.target_visible) and self.phase < CLOSE
        found = find(o.corners.tolist(), self.face_m, self.camera, level) if seen else None
        if found is not None:
            x, y, z = applied(north, found.centre)
            self.heading = yaw + found.yaw
            self._learn((x, y, z + o.depth))
        touching = float(sum(o.touch.tolist()))  # of whole numbers, so exact
        self.untouched = 0 if touching else min(self.untouched + 1, PATIENCE)
        self.since_s += o.dt
        off = (0.0, 0.0, 0.0)
        if self.box is not None:
            x, y, depth = self.box
            goal = applied(ahead, (x, y, depth - HANDLE_M - self.goal - o.depth))
            off = minus(goal, applied(level, self.tool))
            self._integrate(applied(north, off), o.dt)
        distance = math.sqrt(off[0] * off[0] + off[1] * off[1])
        if self.box is not None and distance < LOOK_M:
            self.near_s += o.dt
        return [
            *(2.0 * clipped(each, 1.0) for each in off),
            *(10.0 * clipped(each, NEAR_M) for each in off[:2]),
            *(clipped(off[2], most) / most for most in (0.2, 0.05)),
            *(min(distance, most) / most for most in (LOOK_M, NEAR_M)),
            *(clipped(self.goal, most) / most for most in (ABOVE_M, LOW_M, 0.05)),
            *sincos(self.heading - yaw),
            *(10.0 * each for each in applied(ahead, self.integral)[:2]),
            *o.joints.tolist(),
            touching,
            float(self.untouched < PATIENCE),
            min(self.since_s, LONGEST_S[0]),
            0.5 * min(self.near_s, LONGEST_S[1]),
            2.0 * (o.depth - self.depth_before),
            *(float(each) for each in (seen, self.box is not None)),
            *(float(self.phase == phase) for phase in range(PHASES)),
        ]

    def advance(self, phase: int, fall: float, observation: Any) -> None:
        """Take the phase that the work is told to be in, and how fast the goal falls [m/s]."""
        if self.phase == FALL:
            self.goal -= fall * observation.dt
        self.times = self.times + 1 if phase == self.told else 1
        self.told = phase
        if phase != self.phase and self.times >= PATIENCE:
            self.phase, self.since_s, self.near_s = phase, 0.0, 0.0
            self.depth_before = observation.depth
            if phase == COME:
                self.goal = ABOVE_M

    def _learn(self, place: Vector) -> None:
        """Learn where the box is, and the drift of the reckoning: the box stands still."""
        if self.box is None:
            self.box = place
            return
        off = minus(place, self.box)
        if self.phase == FALL:  # the lower the hand, the more of the face it hides
            off = (off[0], off[1], 0.0)
            if self.goal < LOW_M or length(off) > BELIEVED_M:
                return
        self.box = plus(self.box, times(off, LEARN))
        x, y = (clipped(self.drift[i] + DRIFT * off[i], MOST_DRIFT_M_S) for i in (0, 1))
        self.drift = (x, y, 0.0)

    def _integrate(self, off: Vector, dt: float) -> None:
        """Learn the velocity that holds the tool where it should be; not while it lifts."""
        if self.phase == LIFT:
            return
        x, y = (
            clipped(self.integral[i] + KI * off[i] * dt, MOST_INTEGRAL_M_S)
            if abs(off[i]) < NEAR_M
            else self.integral[i]
            for i in (0, 1)
        )
        self.integral = (x, y, 0.0)


class Imitator:
    """A controller that does what a network says.

    The phase that the network has come to is part of the features of the next step: its memory.
    """

    def __init__(
        self, config: Mapping[str, Any], known: Mapping[str, Any], network: Network
    ) -> None:
        """Set up.

        Parameters
        ----------
        known
            `tool_m`: where the tool is in the body, with the arm in its posture [m]. `most`: the
            largest command that the expert ever gave [m/s, rad/s].
        network
            Features -> the command, how fast the goal falls [m/s], and a score of each phase.
        """
        self.features = Features(config, tuple(known["tool_m"]))
        self.most, self.network = known["most"], network

    def reset(self, level: Mapping[str, Any]) -> None:
        """Forget everything."""
        self.features.reset()

    def step(self, observation: Any) -> list[float]:
        """Return surge, sway, heave [m/s], yaw rate [rad/s] and the speeds of the joints."""
        command, [fall], scores = self.network(self.features.update(observation))
        self.features.advance(scores.index(max(scores)), fall, observation)
        return [clipped(each, most) for each, most in zip(command, self.most, strict=True)]


def clipped(value: float, most: float) -> float:
    """Return a number within plus or minus another."""
    return min(max(value, -most), most)


def _vector(values: Any) -> Vector:
    x, y, z = values.tolist()
    return x, y, z
