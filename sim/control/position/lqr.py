"""LQG: a Kalman filter of position, velocity, water and DVL bias, and a quadratic regulator."""

from collections.abc import Mapping, Sequence
from typing import Any

from seamark.sim.control.observation import Observation
from seamark.sim.control.position.kalman_filter import StateEstimator
from seamark.sim.control.position.vehicle_model import AXES, VehicleModel

LATENCY_S = 0.1  # E: of commands and images together


class Controller:
    """Station keeping by state feedback on the estimate, and a P law on the heading.

        force = -M (w² p + 2 w v + d)

    This minimises the integral of w^4 p² + 2 w² v² + a² for the double integrator that is left
    once d is balanced (the algebraic Riccati equation in closed form; Anderson and Moore 1990). The
    force becomes a velocity reference by the nominal model. Images are compared with the estimate
    of the moment at which they were taken.

    Config: `lqr_bandwidth`, `lqr_water_m_s2`, `lqr_delay_s`, `heading_gain_1_s`.
    """

    label = "LQG (Kalman filter)"

    def __init__(self, config: Mapping[str, Any]) -> None:
        self.heading_gain = config["heading_gain_1_s"]
        self.model = VehicleModel(config)
        self.bandwidth = config["lqr_bandwidth"] / (self.model.lag_s + LATENCY_S)  # [1/s] w
        self.estimator = StateEstimator(
            self.model,
            water_m_s2=config["lqr_water_m_s2"],
            delay_steps=round(config["lqr_delay_s"] / config["control_period_s"]),
        )

    def reset(self, level: Mapping[str, float | int]) -> None:
        """Forget the last level."""
        self.model.reset()
        self.estimator.reset()

    def step(self, observation: Observation) -> Sequence[float]:
        """Return surge, sway, heave [m/s] and yaw rate [rad/s]."""
        self.model.update(observation)
        self.estimator.update(observation)
        command = [0.0, 0.0, 0.0, -self.heading_gain * observation.attitude.item(2)]
        for axis in AXES:
            position, speed, water, _bias = self.estimator.filter.states[axis]
            wanted = -self.bandwidth * (self.bandwidth * position + 2.0 * speed) - water
            command[axis] = self.model.reference(axis, self.model.mass[axis] * wanted)
        return command
