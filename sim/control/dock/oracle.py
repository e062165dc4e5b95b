"""Oracle of docks: knows the true state, the water and the vehicle; limited by thrust alone."""

import math
from collections.abc import Mapping, Sequence
from pkgutil import resolve_name
from typing import Any

import numpy as np

from seamark.sim.control.observation import Observation
from seamark.sim.numerics.arrays import Array

HOVER_M = 1.0  # above the seat; E, as all below
FAST_M_S, SINK_M_S, LAND_M_S = 0.8, 0.4, 0.03
SLOWING_1_S, PRESS_M = 0.6, 0.01  # of the speed by the height above the seat; below the seat
WAIT_M = 0.2  # behind the point that it follows, at which that waits
NEAR_M, NEAR_RAD = 0.1, 0.1


class Oracle:
    """Follows a point that moves over the dock and then down, by the true plant's inverse dynamics.

    A mark, not a ceiling: it is greedy, and does not plan for what the current will do.
    """

    label = "Oracle (knows the truth)"

    def __init__(self, config: Mapping[str, Any]) -> None:
        self._dt = config["control_period_s"]
        self._down_m = config["altitude_m"] + config["marker_m"][2] - config["rails_m"]

    def attach(self, plant: Any, station: Array, point: tuple[float, float] | None) -> None:
        """Take the plant of a level; the station is above the seat."""
        law = resolve_name("seamark.sim.control.inverse_dynamics:MovingGoal")
        self._plant, self._heading = plant, float(station[5])
        self._seat = np.array([station[0], station[1], station[2] + self._down_m])
        self._law = law(plant, station, self._dt)

    def reset(self, level: Mapping[str, float | int]) -> None:
        """Begin where the vehicle is."""
        self._place = self._plant.pose()[:3]
        self._sinks = False

    def step(self, observation: Observation) -> Sequence[float]:
        """Move the point on; return zero: the velocity controller is not used."""
        pose = self._plant.pose()
        off = (self._seat - pose[:3]).tolist()
        turn = self._heading - pose.item(5)
        turn -= 2.0 * math.pi * math.floor((turn + math.pi) / (2.0 * math.pi))
        if math.sqrt(off[0] ** 2 + off[1] ** 2) < NEAR_M and abs(turn) < NEAR_RAD:
            self._sinks = True
        goal, fastest = self._seat.copy(), FAST_M_S
        if self._sinks:
            goal[2] += PRESS_M
            fastest = min(LAND_M_S + SLOWING_1_S * max(off[2], 0.0), SINK_M_S)
        else:
            goal[2] -= HOVER_M
        way = goal - self._place
        length = math.sqrt(math.fsum(one * one for one in way.tolist()))
        behind = math.sqrt(math.fsum(one * one for one in (self._place - pose[:3]).tolist()))
        speed = min(fastest, length / self._dt) * max(0.0, 1.0 - behind / WAIT_M)
        velocity = way * (speed / max(length, 1e-9))
        self._place = self._place + velocity * self._dt
        self._law.aim(self._place, velocity, self._heading)
        return [0.0, 0.0, 0.0, 0.0]

    def commands(self) -> Array:
        """Return the thrusters' commands, (n,) in [-1, 1]."""
        commands: Array = self._law.commands()
        return commands
