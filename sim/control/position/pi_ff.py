"""PI with feed-forward of the water's force, which a disturbance observer estimates."""

from collections.abc import Mapping, Sequence
from typing import Any

from seamark.sim.control.observation import Observation
from seamark.sim.control.position.vehicle_model import AXES, DisturbanceObserver, VehicleModel


class Controller:
    """A PI law on the error, damped by the DVL, plus the reference that balances the water.

    The feed-forward is `VehicleModel.balance` of the estimated force with the sign changed; the
    integral removes what the nominal model gets wrong (disturbance-observer-based control, Chen
    et al. 2016). The heading of the station is held by a P law.

    Config: `pi_ff_kp` [1/s], `pi_ff_ki` [1/s²], `pi_ff_kd` [1], `pi_ff_observer_1_s`,
    `heading_gain_1_s`.
    """

    label = "PI with feed-forward"

    def __init__(self, config: Mapping[str, Any]) -> None:
        self.kp, self.ki, self.kd = config["pi_ff_kp"], config["pi_ff_ki"], config["pi_ff_kd"]
        self.heading_gain = config["heading_gain_1_s"]
        self.limit = config["reference_limit_m_s"]
        self.model = VehicleModel(config)
        self.observer = DisturbanceObserver(self.model, config["pi_ff_observer_1_s"])
        self.integral = [0.0, 0.0]  # [m/s]

    def reset(self, level: Mapping[str, float | int]) -> None:
        """Reset integral and observer."""
        self.integral = [0.0, 0.0]
        self.model.reset()
        self.observer.reset()

    def step(self, observation: Observation) -> Sequence[float]:
        """Return surge, sway, heave [m/s] and yaw rate [rad/s]."""
        self.model.update(observation)
        self.observer.update(observation)
        errors, speeds = observation.error.tolist(), observation.velocity.tolist()
        seen = observation.target_visible
        command = [0.0, 0.0, 0.0, -self.heading_gain * observation.attitude.item(2)]
        for axis in AXES:
            change = self.ki * errors[axis] * observation.dt if seen else 0.0
            forward = self.model.balance(axis, -self.observer.force[axis])
            feedback = self.kp * errors[axis] - self.kd * speeds[axis]
            wanted = feedback + self.integral[axis] + change + forward
            command[axis] = min(max(wanted, -self.limit), self.limit)
            # Anti-windup: at the limit the integral may only move back inside.
            if command[axis] == wanted or (wanted - command[axis]) * change < 0.0:
                self.integral[axis] += change
        return command
