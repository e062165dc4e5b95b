"""Oracle of routes: knows the true state, the water and the vehicle; limited by thrust alone."""

import math
from collections.abc import Mapping, Sequence
from pkgutil import resolve_name
from typing import Any

import numpy as np

from seamark.sim.control.observation import Observation
from seamark.sim.numerics.arrays import Array

TIME_SHARE = 0.85  # E: of the time that is left, which it means to take for the rest of the route
FASTEST_M_S = 0.6  # E
WAIT_M = 0.2  # E: behind the point that it follows, at which that waits
WEAK_M_S = 0.05  # of a flow that needs no turn


class Oracle:
    """Follows a point that moves along the route, by the inverse dynamics of the true plant.

    The point takes what is left of the time, and waits when the vehicle falls behind. The bow is
    turned against the flow that the vehicle will meet: the wanted velocity less the current's. A
    mark, not a ceiling: it is greedy, and does not plan for what the current will do.
    """

    label = "Oracle (knows the truth)"

    def __init__(self, config: Mapping[str, Any]) -> None:
        self._dt = config["control_period_s"]
        self._polyline = resolve_name("seamark.sim.numerics.polyline")  # compiled: only for runs
        self._atan2 = resolve_name("seamark.sim.numerics.libm:atan2")

    def attach(self, plant: Any, station: Array, point: tuple[float, float] | None) -> None:
        """Take the plant of a level."""
        law = resolve_name("seamark.sim.control.inverse_dynamics:MovingGoal")
        self._plant = plant
        self._law = law(plant, station, self._dt)

    def follow(self, route: Array) -> None:
        """Take the route of a level, (k, 3) NED [m]."""
        self._route, self._starts = route, self._polyline.starts_of(route)

    def reset(self, level: Mapping[str, float | int]) -> None:
        """Begin at the start of the route."""
        self._ends_s = level["t"] + level["duration_s"]
        self._along, self._place = 0.0, np.zeros(6)

    def step(self, observation: Observation) -> Sequence[float]:
        """Move the point on; return zero: the velocity controller is not used."""
        left_m = float(self._starts[-1]) - self._along
        left_s = max(self._ends_s - observation.t, self._dt)
        self._polyline.at_length(self._route, self._starts, self._along, self._place)
        off = (self._place[:3] - self._plant.pose()[:3]).tolist()
        behind = math.sqrt(math.fsum(error * error for error in off))
        speed = min(left_m / (TIME_SHARE * left_s), FASTEST_M_S, left_m / self._dt)
        speed *= max(0.0, 1.0 - behind / WAIT_M)
        self._along += speed * self._dt
        velocity = speed * self._place[3:]
        north, east = (velocity - self._plant.current_world())[:2].tolist()
        heading = None
        if math.sqrt(north * north + east * east) > WEAK_M_S:
            heading = self._atan2(east, north)
        self._law.aim(self._place[:3], velocity, heading)
        return [0.0, 0.0, 0.0, 0.0]

    def commands(self) -> Array:
        """Return the thrusters' commands, (n,) in [-1, 1]."""
        commands: Array = self._law.commands()
        return commands
