"""Yaw moments through the heading hold of the velocity controller, and what works against them.

The hold is a PID on a set point that the yaw rate reference moves. It is soft, so that the water on
an oblique hull and unequal thrusters turn the vehicle before its integral answers. Its law is
public, so a program can keep its state and ask for the rate with which it gives a moment.
"""

import math
from typing import Any

from seamark.sim.control.position.vehicle_model import VehicleModel
from seamark.sim.vehicles import Vehicle

# As in seamark.sim.control.velocity_controller and velocity_law.
FREQUENCY_1_S, DAMPING, INTEGRAL_1_S = 2.0, 0.9, 0.3
LARGEST_LEAD_RAD, FASTEST_RAD_S = 0.5, 0.6
BANDWIDTH_1_S = 3.0  # E: of the heading
OBSERVER_1_S = 4.0  # E: of the moment that is not the thrusters'
LATENCY_S = 0.05  # E: of a command
ROOM = 0.8  # E: share of the greatest moment that is asked for
YAW = 5


class YawMoment:
    """The rate reference with which the heading follows a path, and the moment that it takes."""

    def __init__(self, vehicle: Vehicle, model: VehicleModel) -> None:
        self._lag = model.lag_s + LATENCY_S
        inertia = (vehicle.mass_rigid() + vehicle.mass_added()).item(YAW, YAW)
        self._inertia = inertia  # [kg m²]
        stiffness = inertia * FREQUENCY_1_S * FREQUENCY_1_S
        friction = inertia * 2.0 * DAMPING * FREQUENCY_1_S
        self._hold = (stiffness, friction, stiffness * INTEGRAL_1_S)
        levers = [abs(lever) for lever in vehicle.allocation()[YAW].tolist()]
        self._most = ROOM * sum(levers) * min(vehicle.curve.limits.value)
        self.reset()

    def reset(self) -> None:
        """Start a level: the hold has the heading that it finds."""
        self._target: float | None = None  # [rad] of the hold
        self._integral = 0.0  # [N m] of the hold
        self._given = 0.0  # [N m] by the thrusters, as commanded
        self._state: float | None = None  # [N m] of the observer
        self.moment = 0.0  # [N m] wanted

    def rate(
        self, heading: tuple[float, float, float], yaw: float, turning: float, dt: float
    ) -> float:
        """Return the yaw rate reference [rad/s].

        Parameters
        ----------
        heading : (3,) [rad, rad/s, rad/s²]
            The wanted heading, its rate and its acceleration.
        yaw, turning : [rad, rad/s]
            As measured.
        """
        if self._target is None or self._state is None:
            self._target, self._state = yaw, -OBSERVER_1_S * self._inertia * turning
        wanted, wanted_rate, acceleration = heading
        disturbance = self._state + OBSERVER_1_S * self._inertia * turning
        self._state -= OBSERVER_1_S * (disturbance + self._given) * dt
        rise = acceleration + 2.0 * BANDWIDTH_1_S * (wanted_rate - turning)
        rise += BANDWIDTH_1_S * BANDWIDTH_1_S * wrapped(wanted - yaw)
        moment = self._inertia * rise - disturbance
        self.moment = min(max(moment, -self._most), self._most)
        return self._through_hold(yaw, turning, dt)

    def _through_hold(self, yaw: float, turning: float, dt: float) -> float:
        """Return the reference at which the hold gives the moment, and take its step."""
        stiffness, friction, rate = self._hold
        off = wrapped((self._target or 0.0) - yaw)
        needed = self.moment - (stiffness + rate * dt) * off - self._integral + friction * turning
        reference = needed / (friction + (stiffness + rate * dt) * dt)
        reference = min(max(reference, -FASTEST_RAD_S), FASTEST_RAD_S)
        error = min(max(off + reference * dt, -LARGEST_LEAD_RAD), LARGEST_LEAD_RAD)
        self._target = yaw + error
        self._integral += rate * error * dt
        gives = stiffness * error + friction * (reference - turning) + self._integral
        self._given += (gives - self._given) * (dt / (self._lag + dt))
        return reference


def wrapped(angle: Any) -> float:
    """Return the angle within [-pi, pi)."""
    turned: float = angle - 2.0 * math.pi * math.floor(angle / (2.0 * math.pi) + 0.5)
    return turned
