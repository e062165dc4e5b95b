"""Turning a valve by its handle: straddle it with open jaws, turn the wrist.

The handle starts along the letters of its panel, so the letters tell where it is. Two jaws, one to
each side of the lever, turn it without a push. While they bear on it, the arm is stiff but for its
wrist: an arm that follows its vehicle would push against a handle that holds the hand. If the hand
slips off or the wrist ends too early, it comes up and starts again where the lever should be now.
"""

import math
from collections.abc import Mapping

from seamark.sim.control.manipulation.approach import (
    FALL,
    LOW_M,
    WORK,
    ArmCompensates,
    FirstLook,
    Steady,
    clipped,
    turned,
)
from seamark.sim.control.manipulation.arm_data import Vector
from seamark.sim.control.manipulation.kinematics import (
    Matrix,
    applied,
    plus,
    product,
    rotation,
)
from seamark.sim.control.manipulation.sight import Seen
from seamark.sim.control.observation import Observation
from seamark.sim.numerics.libm import PI, sincos

GOAL_RAD = 3.05  # 175 degrees
# Of the jaws' line before the lever that they will push: they pass it with room to both sides.
STRADDLE_RAD = 1.25
SWEEP_RAD = 4.0  # of the wrist: to the lever, half a turn, and what everything gives way
SPEED_RAD_S, SLOW_RAD_S = 0.4, 0.2  # of the wrist: with both jaws at the lever, and before
SPARE_RAD = 0.06  # of the wrist's range
READY_RAD = 0.1
KYAW, YAW_RAD_S = 0.5, 0.12
LOOSE_S = 0.3  # for which no jaw must touch before the arm moves again
FELT_N = 2.0  # of one jaw alone
JAW_M, CONTACT_M = 0.055, 0.022  # of a jaw from the hand's middle, and from a lever that it touches
EARLY_M, BACK_RAD, PAUSE_S = 0.006, 0.4, 1.5  # at which the hand steps back, how far, for how long
TURN_S = 25.0
SLIPPED_M = 0.07  # of the tool from the handle's middle
RISE_M_S = 0.06
SETTLE_S = 7.0  # above the handle
LONG_S = 18.0  # to come down: the hand stands on the lever
TURN, LEAVE = WORK, WORK + 1


class TurnValve(Steady):
    """The steps of turning a valve clockwise."""

    OPEN_RAD = 0.45
    ABOVE_M, BOTTOM_M = 0.3, -0.02
    HANDLE_M = 0.12
    HANDLE_RAD = 0.0

    def reset(self, level: Mapping[str, float | int]) -> None:
        """Forget everything."""
        super().reset(level)
        self.start = self.swept = self.askew = 0.0  # [rad] of the wrist
        self.turned = 0.0  # [rad] of the handle, as far as the wrist tells
        self.wrist_before = 0.0
        self.loose_s = LOOSE_S
        self.gripped, self.pause_s = False, 0.0

    def _learn(self, seen: Seen, yaw: float, observation: Observation) -> None:
        super()._learn(seen, yaw, observation)
        self.handle += self.turned

    def _wrist_angle(self, joints: list[float], tilt: Matrix, yaw: float) -> float:
        """Return where the wrist should be: before the lever, then on its way."""
        if self.phase < WORK:
            self.start, self.askew = self._before(joints, tilt, yaw)
            self.swept = 0.0
        return self.start + self.swept

    def _before(self, joints: list[float], tilt: Matrix, yaw: float) -> tuple[float, float]:
        """Return the wrist's angle to start from, and by how much it is beyond what leaves room."""
        return self._room(self._across(joints, tilt, yaw) + 0.5 * PI - STRADDLE_RAD)

    def _room(self, angle: float) -> tuple[float, float]:
        """Return the same for an angle that may be half a turn off."""
        low, high = self.kinematics.ranges[self.wrist]
        low, high = low + SPARE_RAD, high - SPARE_RAD - SWEEP_RAD
        ways = (angle + turns * PI for turns in (-2, -1, 0, 1))
        beyond = {way: way - min(max(way, low), high) for way in ways}
        return min(beyond.items(), key=lambda item: abs(item[1]))

    def _turn(self, joints: list[float], tilt: Matrix, yaw: float) -> float:
        """Return the yaw rate that gives the wrist room for its whole way."""
        return clipped(KYAW * self.askew, YAW_RAD_S) if self.phase < WORK else 0.0

    def _ready(self) -> bool:
        return abs(self.askew) < READY_RAD and self.since_s > SETTLE_S

    def _fall(self, off: float, above: float) -> None:
        super()._fall(off, above)
        if self.phase == FALL and (self.touching or self.since_s > LONG_S):
            self._go(LEAVE)

    def _work(self, observation: Observation, error: Vector, joints: list[float]) -> None:
        self._feel(joints)
        if self.phase == LEAVE:
            self._leave()
            return
        if self.touching == 1 and self.pause_s <= 0.0 and not self.gripped:
            self._give_way(observation, joints)
        if self.pause_s > 0.0:
            self.pause_s -= self.dt
        else:
            speed = SPEED_RAD_S if self.gripped else SLOW_RAD_S
            self.swept = min(self.swept + speed * self.dt, SWEEP_RAD)
        slipped = math.sqrt(error[0] * error[0] + error[1] * error[1]) > SLIPPED_M
        ended = self.swept >= SWEEP_RAD and joints[self.wrist] > self.start + SWEEP_RAD - 0.1
        if self.turned >= GOAL_RAD or slipped or ended or self.since_s > TURN_S:
            self.gripped = False
            self._go(LEAVE)

    def _feel(self, joints: list[float]) -> None:
        """Learn how far the lever was turned, while both jaws are at it."""
        self.loose_s = 0.0 if self.touching else self.loose_s + self.dt
        if self.touching > 1 and self.phase == TURN:
            self.gripped = True
            self.turned += max(joints[self.wrist] - self.wrist_before, 0.0)
        self.wrist_before = joints[self.wrist]

    def _give_way(self, observation: Observation, joints: list[float]) -> None:
        """Learn from the jaw that touches too early where the lever is, and step back from it."""
        early = STRADDLE_RAD - (joints[self.wrist] - self.start)
        off = JAW_M * sincos(max(early, 0.0))[0] - CONTACT_M
        roll, pitch, yaw = self._attitude(observation)
        turn = product(rotation(roll, pitch, 0.0), self.kinematics.tool(joints).turn)
        x, y, z = observation.wrist_force.tolist()
        north, east = turned(applied(turn, (-x, -y, -z)), yaw)
        size = math.sqrt(north * north + east * east)
        if off < EARLY_M or size < FELT_N or self.work is None:
            return
        self.work = plus(self.work, (off * north / size, off * east / size, 0.0))
        self.swept = max(joints[self.wrist] - self.start - BACK_RAD, 0.0)
        self.pause_s = PAUSE_S

    def _leave(self) -> None:
        if self.offset < self.ABOVE_M:
            self.offset += RISE_M_S * self.dt
            self.falling = -RISE_M_S
        elif self.turned < GOAL_RAD:
            self._again()

    def _bears(self) -> bool:
        """Return whether the jaws bear on the lever."""
        return self.phase == TURN and (self.gripped or self.loose_s < LOOSE_S)

    def _posture(self, joints: list[float], wrist: float) -> list[float]:
        """Return the speeds of the joints; at the lever the arm is stiff, but for its wrist."""
        speeds = super()._posture(joints, wrist)
        if self._bears():
            for number in self.kinematics.reaching:
                if number != self.wrist:
                    speeds[number] = 0.0
        return speeds


class Scripted(TurnValve):
    """The vehicle alone goes where the hand is needed; the arm keeps one posture."""

    label = "Scripted: the vehicle brings the hand"


class Blind(FirstLook, Scripted):
    """Looks at the panel until it is about there, then goes down at once, by dead reckoning."""

    label = "Blind after six seconds"
    ABOVE_M = 0.1
    LOOK_S = 6.0

    def _ready(self) -> bool:
        return abs(self.askew) < READY_RAD


class ResolvedRate(ArmCompensates, TurnValve):
    """The arm takes off what the vehicle leaves of the error, at the rate of its joints."""

    label = "Resolved rate: vehicle and arm together"

    def _folded(self) -> bool:
        """Return whether the arm keeps its posture: also as long as it is to hide little."""
        near = self.phase == TURN or (self.phase == FALL and self.offset < LOW_M)
        return self._bears() or not near
