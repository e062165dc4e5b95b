"""Recovering a box by its handle: come down to it, close the hand, lift, hold.

And again from the start if the hand closes on nothing.
"""

from collections.abc import Mapping
from typing import ClassVar

from seamark.sim.control.manipulation.approach import (
    FALL,
    KZ,
    LOW_M,
    WORK,
    Approach,
    ArmCompensates,
    FirstLook,
    clipped,
)
from seamark.sim.control.manipulation.arm_data import Vector
from seamark.sim.control.observation import Observation
from seamark.sim.numerics.libm import PI

LIFT_M, RISE_M_S = 0.75, 0.12
CLOSE_S = 2.0
EMPTY_RAD = -0.03  # of a jaw that has closed farther than the handle lets it
CLOSE, LIFT = WORK, WORK + 1


class Recover(Approach):
    """The steps of a recovery."""

    SLOW_M = 0.15
    FEEL_M: ClassVar[float] = LOW_M  # of the tool above the grip, from where a touch ends the way
    ABOVE_M = 0.6  # where the hand does not hide the box
    SETTLE_S, DRIFT = 6.0, 0.06
    BOTTOM_M = -0.01
    HANDLE_M = 0.07
    HANDLE_RAD = 0.5 * PI

    def reset(self, level: Mapping[str, float | int]) -> None:
        """Forget everything."""
        super().reset(level)
        self.goal_depth = 0.0

    def _fall(self, off: float, above: float) -> None:
        super()._fall(off, above)
        if self.phase == FALL and self.touching and self.offset < self.FEEL_M:
            self._go(CLOSE)  # it stands on the box

    def _work(self, observation: Observation, error: Vector, joints: list[float]) -> None:
        if self.phase == CLOSE and self.since_s > CLOSE_S:
            self.goal_depth = self._depth(observation) - LIFT_M
            self._go(LIFT)
        elif self.phase == LIFT and self._empty(joints):
            self._again()

    def _empty(self, joints: list[float]) -> bool:
        return joints[self.jaw] < EMPTY_RAD

    def _jaw_speed(self, joints: list[float]) -> float:
        if self.phase >= CLOSE:
            return -self.kinematics.fastest[self.jaw]
        return super()._jaw_speed(joints)

    def _fly(self, error: Vector, yaw: float, observation: Observation) -> list[float]:
        if self.phase != LIFT:
            return super()._fly(error, yaw, observation)
        surge, sway, _ = super()._fly((0.0, 0.0, 0.0), yaw, observation)
        return [surge, sway, self._rise(observation)]

    def _rise(self, observation: Observation) -> float:
        """Return the heave that brings the box up, and holds it there."""
        return clipped(KZ * (self.goal_depth - self._depth(observation)), RISE_M_S)


class Scripted(Recover):
    """The vehicle alone goes where the hand is needed; the arm keeps one posture."""

    label = "Scripted: the vehicle brings the hand"


class Blind(FirstLook, Scripted):
    """Looks at the box at the start, then comes over it and down by dead reckoning."""

    label = "Blind after one second"
    ABOVE_M, SETTLE_S = 0.25, 0.0
    LOOK_S = 1.0


class ResolvedRate(ArmCompensates, Recover):
    """The arm takes off what the vehicle leaves of the error, at the rate of its joints."""

    label = "Resolved rate: vehicle and arm together"

    def _folded(self) -> bool:
        return self.phase == LIFT
