"""The oracle of connect-v1: it sees the truth and has no latency. A mark on the leaderboard."""

from collections.abc import Mapping

from seamark.sim.control.manipulation import connector
from seamark.sim.control.manipulation.approach import FALL
from seamark.sim.control.manipulation.arm_data import Vector
from seamark.sim.control.manipulation.kinematics import (
    Matrix,
    applied,
    column,
    dot,
    plus,
    rotation,
    times,
)
from seamark.sim.control.manipulation.oracle import AgainstCurrent
from seamark.sim.control.observation import Observation

SWING_S = 1.0  # over which the place of a swinging tip is averaged


class ConnectorOracle(AgainstCurrent, connector.ResolvedRate):
    """`connector.ResolvedRate` that sees the truth, and knows that the receptacle is at the origin.

    It needs not look, knows how the connector hangs in the hand, and turns bow or stern into the
    current to come while nothing else holds the connector.
    """

    ABOVE_M, SETTLE_S = 0.25, 0.0
    KEEPS_HEADING = frozenset(
        {FALL, connector.CLOSE, connector.LIFT, connector.INSERT, connector.OPEN}
    )

    def reset(self, level: Mapping[str, float | int]) -> None:
        """Know where the connector is, and so the receptacle."""
        super().reset(level)
        self._plant.measure_work()
        x, y, z, *attitude = self._plant.work[:6].tolist()
        self.into = column(rotation(*attitude), 2)
        tip = plus((x, y, z), times(self.into, connector.TIP_M))
        self.mouth_m = dot(tip, self.into) / self.into[2]  # depth

    def _look(self, observation: Observation, tilt: Matrix, yaw: float) -> None:
        super()._look(observation, tilt, yaw)
        if self.phase > connector.LIFT:
            self.work = (0.0, 0.0, self.mouth_m - connector.TIP_M)

    def _work(self, observation: Observation, error: Vector, joints: list[float]) -> None:
        super()._work(observation, error, joints)
        if self.phase in self.CARRIES and self.tries == 0 and self.height > 0.0:
            self._aim(joints)

    def _aim(self, joints: list[float]) -> None:
        """Bring the true tip over the receptacle, not that of a connector that hangs straight."""
        pose, work = self._plant.pose().tolist(), self._plant.work.tolist()
        straight = applied(rotation(*pose[3:]), self._of_tip.tool(joints).point)
        hanging = applied(rotation(*work[3:6]), (0.0, 0.0, connector.TIP_M))
        (north, east), share = self.held_at, self.dt / SWING_S
        north += share * (pose[0] + straight[0] - work[0] - hanging[0] - north)
        east += share * (pose[1] + straight[1] - work[1] - hanging[1] - east)
        self.held_at = north, east
        self.beside = self.held_at

    def _go(self, phase: int) -> None:
        super()._go(phase)
        if phase == connector.INSERT:
            self.lowest, self.stands_s = self.height, 0.0

    def _parked(self) -> Vector:
        return 0.0, 0.0, 0.0  # the work is the handle
