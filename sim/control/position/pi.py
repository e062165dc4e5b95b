"""PI: proportional and integral, with anti-windup at the limit of the reference."""

from collections.abc import Mapping, Sequence
from typing import Any

from seamark.sim.control.observation import Observation


class Controller:
    """Station keeping by a PI law on x and y (and z if asked).

    Config: `kp` [1/s], `ki` [1/s^2], `control_heave`, `reference_limit_m_s`.
    """

    label = "PI"

    def __init__(self, config: Mapping[str, Any]) -> None:
        self.kp = config["kp"]
        self.ki = config["ki"]
        self.limit = config["reference_limit_m_s"]
        self.axes = 3 if config["control_heave"] else 2
        self.integral = [0.0, 0.0, 0.0]  # [m/s] contribution to the reference

    def reset(self, level: Mapping[str, float | int]) -> None:
        """Reset the integral."""
        self.integral = [0.0, 0.0, 0.0]

    def step(self, observation: Observation) -> Sequence[float]:
        """Return surge, sway, heave [m/s] and yaw rate [rad/s]."""
        command = [0.0, 0.0, 0.0, 0.0]
        errors, visible, dt = observation.error, observation.target_visible, observation.dt
        for axis in range(self.axes):
            error = float(errors[axis])
            change = self.ki * error * dt if visible else 0.0
            wanted = self.kp * error + self.integral[axis] + change
            command[axis] = min(max(wanted, -self.limit), self.limit)
            # Anti-windup: at the limit the integral may only move back inside.
            if command[axis] == wanted or (wanted - command[axis]) * change < 0.0:
                self.integral[axis] += change
        return command
