"""P: the velocity reference is proportional to the position error."""

from collections.abc import Mapping, Sequence
from typing import Any

from seamark.sim.control.observation import Observation


class Controller:
    """Station keeping by a proportional law on x and y (and z if asked).

    Config: `kp` [1/s], `control_heave`, `reference_limit_m_s`.
    """

    label = "P"

    def __init__(self, config: Mapping[str, Any]) -> None:
        self.kp = config["kp"]
        self.limit = config["reference_limit_m_s"]
        self.axes = 3 if config["control_heave"] else 2

    def reset(self, level: Mapping[str, float | int]) -> None:
        """Do nothing: there is no state."""

    def step(self, observation: Observation) -> Sequence[float]:
        """Return surge, sway, heave [m/s] and yaw rate [rad/s]."""
        command = [0.0, 0.0, 0.0, 0.0]
        for axis in range(self.axes):
            wanted = self.kp * observation.error[axis]
            command[axis] = min(max(wanted, -self.limit), self.limit)
        return command
