"""What the model-based controllers know of their vehicle: its nominal numbers, as published.

Only surge and sway: depth and tilt are held by the velocity controller. The true vehicle may differ
(benchmarks draw its mass, drag and thrusters), and how strong the water is nobody tells.
"""

import math
from collections.abc import Mapping
from operator import mul
from pkgutil import resolve_name
from typing import Any

from seamark.sim.control.observation import Observation
from seamark.sim.vehicles import load

AXES = (0, 1)  # surge, sway
USUAL_M_S = 0.3  # E: speed of the water at which drag is linearised
VELOCITY_OBSERVER_1_S = 5.0  # as in seamark.sim.control.velocity_controller


class VehicleModel:
    """Mass, drag and thrusters of surge and sway, and the inverse of the velocity controller.

    The velocity controller predicts the velocity by thrust and drag between two readings of the
    DVL, without knowing the water; to tell its force in advance, the model predicts the same.
    """

    def __init__(self, config: Mapping[str, Any]) -> None:
        vehicle = load(config["vehicle"])
        inertia = vehicle.mass_rigid() + vehicle.mass_added()
        self.mass = [inertia.item(axis, axis) for axis in AXES]  # [kg] with added mass
        self.added = [vehicle.mass_added().item(axis, axis) for axis in AXES]  # [kg] of it
        self._linear = vehicle.linear_drag()[:2].tolist()
        self._quadratic = vehicle.quadratic_drag()[:2].tolist()
        self._allocation = vehicle.allocation()[:2].tolist()
        self.lag_s = vehicle.lag.scalar  # of the thrusters
        forward, reverse = vehicle.curve.limits.value
        self.most_force = [  # [N] of all thrusters together, forward and starboard
            sum(share * (forward if share > 0.0 else -reverse) for share in row)
            for row in self._allocation
        ]
        self._bandwidth = config["velocity_bandwidth_1_s"]
        self._limit = config["reference_limit_m_s"]
        drags = zip(self._linear, self._quadratic, self.mass, strict=True)
        self.sensitivity = [(a + 2.0 * b * USUAL_M_S) / mass for a, b, mass in drags]  # [1/s]
        exp = resolve_name("seamark.sim.numerics.libm:exp")  # compiled: only for runs
        self._correction = 1.0 - exp(-VELOCITY_OBSERVER_1_S / config["dvl_rate_hz"])
        self._lag_s = (1.0 / self._correction - 0.5) / config["dvl_rate_hz"]
        self.reset()

    def reset(self) -> None:
        """Start a level: the vehicle rests."""
        self.force = [0.0, 0.0]  # [N] of the thrusters on surge and sway
        self.fresh = False  # whether the DVL has a new reading
        self._predicted = [0.0, 0.0]  # [m/s] as the velocity controller predicts
        self._measured: list[float] = []

    def update(self, observation: Observation) -> None:
        """Take the observation of a step."""
        thrust, measured = observation.thrust.tolist(), observation.velocity.tolist()
        self.fresh = observation.velocity_valid and measured != self._measured
        self._measured = measured
        self.force = [sum(map(mul, row, thrust)) for row in self._allocation]
        for axis in AXES:
            speed = self._predicted[axis]
            push = self.force[axis] - self.drag(axis, speed)
            speed += push / self.mass[axis] * observation.dt
            if self.fresh:
                speed += self._correction * (measured[axis] - speed)
            self._predicted[axis] = speed

    def drag(self, axis: int, speed: float) -> float:
        """Return the drag of an axis [N] at a speed through the water [m/s]."""
        slope: float = self._linear[axis] + self._quadratic[axis] * abs(speed)
        return slope * speed

    def speed_of(self, axis: int, drag: float) -> float:
        """Return the speed through the water [m/s] at which an axis has this drag [N]."""
        if drag == 0.0:
            return 0.0  # also where there is no linear drag
        slope, curvature = self._linear[axis], self._quadratic[axis]
        root = math.sqrt(slope * slope + 4.0 * curvature * abs(drag))
        return math.copysign(2.0 * abs(drag) / (slope + root), drag)

    def reference(self, axis: int, force: float) -> float:
        """Return the velocity reference [m/s] with which the thrusters give a force [N] now.

        The inverse of force = drag(reference) + mass bandwidth (reference - predicted velocity).
        """
        return self._reference(axis, force, self._predicted[axis])

    def balance(self, axis: int, force: float) -> float:
        """Return the velocity reference [m/s] with which a resting vehicle keeps up a force [N].

        While the thrusters push against the water, the predicted velocity rises until the DVL
        corrects it; `_lag_s` times the acceleration is its mean.
        """
        return self._reference(axis, force, force / self.mass[axis] * self._lag_s)

    def _reference(self, axis: int, force: float, predicted: float) -> float:
        gain = self.mass[axis] * self._bandwidth
        slope, curvature = gain + self._linear[axis], self._quadratic[axis]
        whole = force + gain * predicted
        root = math.sqrt(slope * slope + 4.0 * curvature * abs(whole))
        size = 2.0 * abs(whole) / (slope + root)
        return math.copysign(min(size, self._limit), whole)


class DisturbanceObserver:
    """The force of the water on surge and sway, from thrust and the change of the velocity.

    A first-order filter of M v' - thrust that needs no derivative (momentum observer, De Luca and
    Mattone 2003; Chen et al. 2000): with the state z, d = z + L M v and z' = -L (d + thrust). A
    constant bias of the DVL does not enter.
    """

    def __init__(self, model: VehicleModel, bandwidth_1_s: float) -> None:
        self._model, self._bandwidth = model, bandwidth_1_s
        self._state: list[float] | None = None
        self.force = [0.0, 0.0]  # [N]

    def reset(self) -> None:
        """Forget the water of the last level."""
        self._state, self.force = None, [0.0, 0.0]

    def update(self, observation: Observation) -> None:
        """Take one step, after the model did."""
        speeds = observation.velocity.tolist()
        momentum = [self._bandwidth * self._model.mass[axis] * speeds[axis] for axis in AXES]
        state = self._state if self._state is not None else [-value for value in momentum]
        for axis in AXES:
            self.force[axis] = state[axis] + momentum[axis]
            rate = -self._bandwidth * (self.force[axis] + self._model.force[axis])
            state[axis] += rate * observation.dt
        self._state = state
