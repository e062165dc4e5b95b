"""Sliding mode: super-twisting on a surface with an integral, smoothed by a boundary layer."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

from seamark.sim.control.observation import Observation
from seamark.sim.control.position.vehicle_model import AXES, VehicleModel


class Controller:
    """Station keeping by a second-order sliding mode, without an estimate of the water.

        s = v - 2 λ e - λ² ∫ e,   z' = -k2 sat(s/φ)
        force = M (λ² e - 2 λ v - k1 sqrt|s| sat(s/φ) + z)

    The surface is that of Slotine and Li (1991, 7.1) with an integral, so that a bias of the DVL
    leaves no error. The law is super-twisting (Levant 1993; gains by Moreno and Osorio 2012:
    k1 = 1.5 sqrt(L), k2 = 1.1 L for disturbances that change by at most L [m/s³]); within the
    boundary layer φ the sign is replaced by a ramp. The acceleration becomes a velocity reference
    by the nominal model. The heading of the station is held by a P law.

    Config: `smc_surface_1_s` λ, `smc_water_m_s2`, `smc_boundary_m_s` φ, `heading_gain_1_s`.
    """

    label = "Sliding mode"

    def __init__(self, config: Mapping[str, Any]) -> None:
        self.surface, self.boundary = config["smc_surface_1_s"], config["smc_boundary_m_s"]
        self.heading_gain = config["heading_gain_1_s"]
        self.model = VehicleModel(config)
        rates = [config["smc_water_m_s2"] * share for share in self.model.sensitivity]  # L
        self.k1 = [1.5 * math.sqrt(rate) for rate in rates]
        self.k2 = [1.1 * rate for rate in rates]
        self.integral = [0.0, 0.0]  # [m s] of the error
        self.twist = [0.0, 0.0]  # [m/s²] z

    def reset(self, level: Mapping[str, float | int]) -> None:
        """Reset both integrals."""
        self.model.reset()
        self.integral = [0.0, 0.0]
        self.twist = [0.0, 0.0]

    def step(self, observation: Observation) -> Sequence[float]:
        """Return surge, sway, heave [m/s] and yaw rate [rad/s]."""
        self.model.update(observation)
        errors, speeds = observation.error.tolist(), observation.velocity.tolist()
        dt, rate = observation.dt, self.surface
        command = [0.0, 0.0, 0.0, -self.heading_gain * observation.attitude.item(2)]
        for axis in AXES:
            error, speed = errors[axis], speeds[axis]
            sliding = speed - 2.0 * rate * error - rate * rate * self.integral[axis]
            share = min(max(sliding / self.boundary, -1.0), 1.0)
            twisted = -self.k1[axis] * math.sqrt(abs(sliding)) * share + self.twist[axis]
            force = self.model.mass[axis] * (twisted - 2.0 * rate * speed + rate * rate * error)
            # Anti-windup: where the thrusters give no more, both integrals may only move back.
            if abs(force) < self.model.most_force[axis] or force * share > 0.0:
                self.twist[axis] -= self.k2[axis] * share * dt
                if observation.target_visible:
                    self.integral[axis] += error * dt
            command[axis] = self.model.reference(axis, force)
        return command
