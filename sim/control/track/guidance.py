"""Guidance along a route by line of sight: steer for a point of it ahead, at a set speed.

Fossen 2021, ch. 12.3 to 12.6; the point is that of `guide.Guide`.
"""

import math
from collections.abc import Mapping, Sequence
from pkgutil import resolve_name
from typing import Any

from seamark.sim.control.observation import PIPE, ROUTE_POINTS, Observation
from seamark.sim.control.position.vehicle_model import AXES, DisturbanceObserver, VehicleModel
from seamark.sim.control.track.navigation import measured, to_body
from seamark.sim.numerics.arrays import Array

HEADING_GAIN_1_S, YAW_RAD_S = 0.8, 0.4  # E
SLOW_1_S = 0.7  # [1/s] speed for each metre that is left to the end; E
# E: nearer to the end, and with less to turn the bow to, the heading stays.
NEAR_M, WEAK_M_S = 0.3, 0.1
FLOW_1_S, OBSERVER_1_S = 0.3, 1.0  # E: of the estimate of the current, and of the force behind it
SPEED_GAIN_1_S = 1.0  # E
Level = tuple[float, float]  # of the horizontal plane: north and east, or surge and sway


class LineOfSight:
    """Course and heading towards a point `lookahead_m` ahead on the route; depth likewise.

    Config: `route`, `speed_m_s`, `lookahead_m`, `start_error_m`.
    """

    label = "Line of sight"
    fixes, sees = True, True

    def __init__(self, config: Mapping[str, Any]) -> None:
        self._speed, self._lookahead = config["speed_m_s"], config["lookahead_m"]
        self._start_error = config["start_error_m"]
        self._on_pipe = self.sees and config["route"] == PIPE
        # Compiled: only for runs.
        self._sincos = resolve_name("seamark.sim.numerics.libm:sincos")
        self._atan2 = resolve_name("seamark.sim.numerics.libm:atan2")

    def reset(self, level: Mapping[str, float | int]) -> None:
        """Begin a level at the start of its route."""
        self._guide: Any = None  # until the route is known

    def step(self, observation: Observation) -> Sequence[float]:
        """Return surge, sway, heave [m/s] and yaw rate [rad/s]."""
        if self._guide is None:
            self._guide = self._new_guide(observation.route.reshape(ROUTE_POINTS, 3))
        yaw = observation.attitude.item(2)
        sine, cosine = self._sincos(yaw)
        self._guide.update(measured(observation, sine, cosine))
        north, east, down = self._velocity(observation.dt)
        wanted = to_body(north, east, (sine, cosine))
        self._look_at_water(observation, sine, cosine)
        rate = self._yaw_rate(self._bow((north, east)), yaw)
        return [*self._level(observation, wanted, sine, cosine), down, rate]

    def _new_guide(self, route: Array) -> Any:
        """Return what knows the way ahead, given the told route, (k, 3) [m]."""
        if self._on_pipe:
            along_pipe = resolve_name("seamark.sim.control.track.pipe_guide:PipeGuide")
            return along_pipe(route, self._lookahead)
        guide = resolve_name("seamark.sim.control.track.guide:Guide")
        return guide(route, self._lookahead, self._start_error, fixes=self.fixes)

    def _velocity(self, dt: float) -> list[float]:
        """Return the velocity that is wanted, north, east, down [m/s]."""
        north, east, down, distance = self._guide.to_aim()
        ends = self._guide.left_m < self._lookahead
        speed = min(self._speed, SLOW_1_S * distance) if ends else self._speed
        share = speed / max(distance, 1e-6)
        return [share * north, share * east, share * down]

    def _look_at_water(self, observation: Observation, sine: float, cosine: float) -> None:
        """Estimate the current: not here."""

    def _bow(self, wanted: Level) -> Level:
        """Return a vector north, east to which the bow should turn: the wanted velocity."""
        return wanted

    def _level(
        self, observation: Observation, wanted: Level, sine: float, cosine: float
    ) -> Sequence[float]:
        """Return the references of surge and sway for velocities that are wanted [m/s]."""
        return wanted

    def _yaw_rate(self, bow: Level, yaw: float) -> float:
        """Return the yaw rate that turns the bow."""
        north, east = bow
        if self._guide.left_m < NEAR_M and math.sqrt(north * north + east * east) < WEAK_M_S:
            return 0.0
        error: float = self._atan2(east, north) - yaw
        error -= 2.0 * math.pi * math.floor(error / (2.0 * math.pi) + 0.5)
        return min(max(HEADING_GAIN_1_S * error, -YAW_RAD_S), YAW_RAD_S)


class Blind(LineOfSight):
    """Line of sight by dead reckoning alone. A mark that fixes and camera have to beat."""

    label = "Blind (DVL and compass alone)"
    fixes, sees = False, False


class IntegralLineOfSight(LineOfSight):
    """Line of sight with the integral of the cross-track error, against what pushes off the route.

    The integral grows by the share of the lookahead in the distance to the point aimed at, which
    keeps it from winding up far off the route (Børhaug, Pavlov and Pettersen 2008; Caharija et al.
    2016). Config: also `integral_gain`.
    """

    label = "Integral line of sight"

    def __init__(self, config: Mapping[str, Any]) -> None:
        super().__init__(config)
        self._gain = config["integral_gain"]

    def reset(self, level: Mapping[str, float | int]) -> None:
        """Begin a level without an integral."""
        super().reset(level)
        self._integral = [0.0, 0.0, 0.0]  # [m/s] NED

    def _velocity(self, dt: float) -> list[float]:
        wanted = super()._velocity(dt)
        off = (self._guide.here[:3] - self._guide.position).tolist()
        square = math.fsum(error * error for error in off)
        rate = self._lookahead**2 / (self._lookahead**2 + square) * self._gain
        ahead = self._guide.here[3:].tolist()
        for axis in range(3):
            self._integral[axis] += rate * off[axis] * dt
        along = math.fsum(a * b for a, b in zip(self._integral, ahead, strict=True))
        across = [self._integral[axis] - along * ahead[axis] for axis in range(3)]
        self._integral = [min(max(one, -self._speed), self._speed) for one in across]
        return [one + more for one, more in zip(wanted, self._integral, strict=True)]


class IntoFlow(IntegralLineOfSight):
    """Integral line of sight with the bow against the flow that the hull meets.

    That is the wanted velocity less the current's: ahead a hull has the least drag and its
    thrusters the most push. The force of the water, as a disturbance observer has it, is drag; its
    inverse gives the velocity through the water, and with the DVL's the current.
    """

    label = "Integral line of sight, bow into the flow"

    def __init__(self, config: Mapping[str, Any]) -> None:
        super().__init__(config)
        self._model = VehicleModel(config)
        self._observer = DisturbanceObserver(self._model, OBSERVER_1_S)

    def reset(self, level: Mapping[str, float | int]) -> None:
        """Begin a level with no current known."""
        super().reset(level)
        self._model.reset()
        self._observer.reset()
        self._current = [0.0, 0.0]  # [m/s] north, east

    def _look_at_water(self, observation: Observation, sine: float, cosine: float) -> None:
        self._model.update(observation)
        self._observer.update(observation)
        speeds, forces = observation.velocity.tolist(), self._observer.force
        surge, sway = (speeds[axis] - self._model.speed_of(axis, -forces[axis]) for axis in AXES)
        seen = (cosine * surge - sine * sway, sine * surge + cosine * sway)
        for axis in AXES:
            self._current[axis] += FLOW_1_S * observation.dt * (seen[axis] - self._current[axis])

    def _bow(self, wanted: Level) -> Level:
        return wanted[0] - self._current[0], wanted[1] - self._current[1]

    def _level(
        self, observation: Observation, wanted: Level, sine: float, cosine: float
    ) -> Sequence[float]:
        """Return the references with which the thrusters balance the drag at the wanted speeds."""
        north, east = self._current
        water = to_body(north, east, (sine, cosine))
        references = []
        for axis in AXES:
            error = wanted[axis] - observation.velocity.item(axis)
            drag = self._model.drag(axis, wanted[axis] - water[axis])
            push = drag + self._model.mass[axis] * SPEED_GAIN_1_S * error
            references.append(self._model.reference(axis, push))
        return references
