"""Blind: dead reckoning by DVL and compass, without the camera. A mark that vision has to beat."""

from collections.abc import Mapping, Sequence
from pkgutil import resolve_name
from typing import Any

from seamark.sim.control.observation import Observation

KP, KI = 1.0, 0.3  # [1/s, 1/s²] E: the best of a scan on currents-v1 with an unbiased DVL
HEADING_GAIN_1_S = 0.5  # E


class Controller:
    """A PI law on the position that the DVL's velocity integrates to, and P on the heading.

    It knows neither where the target is nor the bias of the DVL, so it holds the position at which
    the level started and drifts away from it.
    """

    label = "Blind (DVL alone)"

    def __init__(self, config: Mapping[str, Any]) -> None:
        self.limit = config["reference_limit_m_s"]
        self.sincos = resolve_name("seamark.sim.numerics.libm:sincos")  # compiled: only for runs
        self.position = [0.0, 0.0]  # [m] north, east of the start, by dead reckoning
        self.integral = [0.0, 0.0]  # [m/s] north, east

    def reset(self, level: Mapping[str, float | int]) -> None:
        """Take the vehicle's position for the station."""
        self.position = [0.0, 0.0]
        self.integral = [0.0, 0.0]

    def step(self, observation: Observation) -> Sequence[float]:
        """Return surge, sway, heave [m/s] and yaw rate [rad/s]."""
        yaw = observation.attitude.item(2)
        sine, cosine = self.sincos(yaw)
        surge, sway = observation.velocity.item(0), observation.velocity.item(1)
        speeds = (cosine * surge - sine * sway, sine * surge + cosine * sway)
        wanted = [0.0, 0.0]
        for axis, speed in enumerate(speeds):
            self.position[axis] += speed * observation.dt
            self.integral[axis] -= KI * self.position[axis] * observation.dt
            self.integral[axis] = min(max(self.integral[axis], -self.limit), self.limit)
            wanted[axis] = self.integral[axis] - KP * self.position[axis]
        north, east = wanted
        command = (cosine * north + sine * east, cosine * east - sine * north)
        return [
            *(min(max(speed, -self.limit), self.limit) for speed in command),
            0.0,
            -HEADING_GAIN_1_S * yaw,
        ]
