"""The oracle of connect-v1: it sees the truth and has no latency. A mark on the leaderboard."""

from collections.abc import Mapping

from seamark.sim.control.manipulation import connector
from seamark.sim.control.manipulation.kinematics import Matrix
from seamark.sim.control.manipulation.oracle import Oracle
from seamark.sim.control.observation import Observation


class ConnectorOracle(Oracle, connector.ResolvedRate):
    """`connector.ResolvedRate` that sees the truth, and knows that the receptacle is at the origin.

    It needs not look, and keeps the heading of its start.
    """

    ABOVE_M, SETTLE_S = 0.25, 0.0

    def reset(self, level: Mapping[str, float | int]) -> None:
        """Know where the connector is."""
        super().reset(level)
        self._plant.measure_work()
        self.parked_m = float(self._plant.work[2])
        self.goal = 0.0

    def _look(self, observation: Observation, tilt: Matrix, yaw: float) -> None:
        super()._look(observation, tilt, yaw)
        if self.phase > connector.LIFT:
            self.work = (0.0, 0.0, self.parked_m)

    def _again(self) -> None:
        super()._again()
        self.goal = 0.0
