"""PID: derivative from the DVL, anti-windup by back-calculation, heading held."""

from collections.abc import Mapping, Sequence
from typing import Any

from seamark.sim.control.observation import Observation

AXES = (0, 1)  # surge, sway
FILTER_S = 0.1  # [s] E: half of the time between two readings of the DVL
TRACKING_S = 1.0  # [s] Tt; E: about the time constant of the loop


class Controller:
    """Station keeping by a PID law, and the heading of the station by a P law.

        u = Kp e + I - Kd v,   I' = Ki e + (limited u - u) / Tt,   Tt = 1 s

    The error's derivative is the velocity of the DVL with the sign changed, which has less noise
    than the difference of two images, filtered by a first-order low-pass. Back-calculation lets the
    integral follow the limit (Åström and Hägglund 2006, Advanced PID Control, 3.5).

    Config: `pid_kp` [1/s], `pid_ki` [1/s²], `pid_kd` [1], `heading_gain_1_s`.
    """

    label = "PID"

    def __init__(self, config: Mapping[str, Any]) -> None:
        self.kp, self.ki, self.kd = config["pid_kp"], config["pid_ki"], config["pid_kd"]
        self.heading_gain = config["heading_gain_1_s"]
        self.limit = config["reference_limit_m_s"]
        self.integral = [0.0, 0.0]  # [m/s]
        self.speed = [0.0, 0.0]  # [m/s] filtered

    def reset(self, level: Mapping[str, float | int]) -> None:
        """Reset integral and filter."""
        self.integral = [0.0, 0.0]
        self.speed = [0.0, 0.0]

    def step(self, observation: Observation) -> Sequence[float]:
        """Return surge, sway, heave [m/s] and yaw rate [rad/s]."""
        errors, speeds = observation.error.tolist(), observation.velocity.tolist()
        dt, seen = observation.dt, observation.target_visible
        command = [0.0, 0.0, 0.0, -self.heading_gain * observation.attitude.item(2)]
        for axis in AXES:
            self.speed[axis] += (speeds[axis] - self.speed[axis]) * dt / (FILTER_S + dt)
            wanted = self.kp * errors[axis] + self.integral[axis] - self.kd * self.speed[axis]
            command[axis] = min(max(wanted, -self.limit), self.limit)
            rate = self.ki * errors[axis] if seen else 0.0
            self.integral[axis] += (rate + (command[axis] - wanted) / TRACKING_S) * dt
        return command
