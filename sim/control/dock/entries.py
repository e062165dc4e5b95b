"""Ways into a dock: over it, then down, by what the vehicle hears and sees of it."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

from seamark.sim.control.dock.sight import DockSight
from seamark.sim.control.observation import Observation
from seamark.sim.control.position.vehicle_model import AXES, DisturbanceObserver, VehicleModel
from seamark.sim.control.track.navigation import to_body

# All E, by trial on seeds that no benchmark uses.
HOVER_M = 1.1  # above the seat: the keel is 0.45 m above the mouth
GAIN_1_S, FASTEST_M_S = 0.5, 0.6
INTEGRAL_1_S2, MOST_INTEGRAL_M_S = 0.05, 0.5
SINK_M_S, LAND_M_S, LAND_M = 0.15, 0.06, 0.15
CLIMB_M_S, HEAVE_GAIN_1_S = 0.25, 0.5
PRESS_M = 0.03  # below the seat, at which it aims
YAW_GAIN_1_S, YAW_RAD_S = 0.8, 0.3
NEAR_M = 1.0  # of the axis, within which it sinks to where it hovers
CONE = 0.35  # by how much of the height above the pocket it may be off while it sinks
ALIGNED_M, ALIGNED_RAD, ALIGNED_S = 0.08, 0.08, 1.0
ASTRAY_M, POCKET_M = 0.3, 0.3  # off the axis, above the pocket: it climbs and tries again
UNSEEN_S = 3.0
OBSERVER_1_S, FLOW_1_S, SPEED_GAIN_1_S = 1.0, 0.2, 1.0


class Straight:
    """PI on the way to the axis of the dock, and down as far as it is near the axis."""

    label = "Straight down: PI by acoustic answers, lamps and marker"
    looks = True
    fixes: int | None = None

    def __init__(self, config: Mapping[str, Any]) -> None:
        self._config = config

    def reset(self, level: Mapping[str, float | int]) -> None:
        """Begin a level with nothing known of the dock."""
        self._sight = DockSight(self._config, looks=self.looks, fixes=self.fixes)
        self._integral = [0.0, 0.0]  # [m/s] north, east

    def step(self, observation: Observation) -> Sequence[float]:
        """Return surge, sway, heave [m/s] and yaw rate [rad/s]."""
        sight = self._sight
        sight.update(observation)
        turn = observation.dock_heading - observation.attitude.item(2)
        turn -= 2.0 * math.pi * math.floor((turn + math.pi) / (2.0 * math.pi))
        rate = min(max(YAW_GAIN_1_S * turn, -YAW_RAD_S), YAW_RAD_S)
        if not sight.known:
            return [0.0, 0.0, 0.0, rate]
        off = math.sqrt(math.fsum(one * one for one in sight.position))
        heave = self._heave(off, abs(turn), observation.dt)
        surge, sway = self._level(observation, off)
        return [surge, sway, heave, rate]

    def _to(self, height_m: float) -> float:
        """Return the heave that brings the vehicle to a height above its seat."""
        above = self._sight.above_m
        fastest = LAND_M_S if above < LAND_M else SINK_M_S
        return min(max(HEAVE_GAIN_1_S * (above - height_m), -CLIMB_M_S), fastest)

    def _heave(self, off_m: float, turn_rad: float, dt: float) -> float:
        """Return the velocity down [m/s]."""
        above = self._sight.above_m
        if off_m < CONE * max(above - POCKET_M, POCKET_M) and turn_rad < 2.0 * ALIGNED_RAD:
            return self._to(-PRESS_M)
        if off_m < NEAR_M and above > HOVER_M:
            return self._to(HOVER_M)
        return min(self._to(HOVER_M), 0.0)

    def _wanted(self, off_m: float) -> tuple[float, float]:
        """Return the velocity north and east by the error alone [m/s]."""
        north, east = self._sight.position
        share = min(GAIN_1_S, FASTEST_M_S / max(off_m, 1e-6))
        return -share * north, -share * east

    def _level(self, observation: Observation, off_m: float) -> tuple[float, float]:
        """Return the references of surge and sway [m/s]."""
        wanted = self._wanted(off_m)
        if off_m < NEAR_M:
            for axis in AXES:
                change = -INTEGRAL_1_S2 * self._sight.position[axis] * observation.dt
                whole = self._integral[axis] + change
                self._integral[axis] = min(max(whole, -MOST_INTEGRAL_M_S), MOST_INTEGRAL_M_S)
        north, east = (one + more for one, more in zip(wanted, self._integral, strict=True))
        return to_body(north, east, self._sight.yaw)


class Acoustic(Straight):
    """The same without a camera."""

    label = "By acoustic answers alone"
    looks = False


class Blind(Acoustic):
    """The same by the first answer and dead reckoning. A mark that senses have to beat."""

    label = "Blind after the first acoustic answer"
    fixes = 1


class Staged(Straight):
    """Aligned above the mouth, then down; back up and again where it goes astray.

    The thrusters balance the drag of the current, as a disturbance observer has it.
    """

    label = "Staged: aligned above the mouth, current estimated"

    def __init__(self, config: Mapping[str, Any]) -> None:
        super().__init__(config)
        self._model = VehicleModel(config)
        self._observer = DisturbanceObserver(self._model, OBSERVER_1_S)

    def reset(self, level: Mapping[str, float | int]) -> None:
        """Begin a level with neither dock nor current known."""
        super().reset(level)
        self._model.reset()
        self._observer.reset()
        self._water = [0.0, 0.0]  # [m/s] velocity of the current, north and east
        self._aligned_s, self._entering = 0.0, False

    def _heave(self, off_m: float, turn_rad: float, dt: float) -> float:
        sight = self._sight
        if self._entering:
            high = sight.above_m > POCKET_M
            if high and (off_m > ASTRAY_M or sight.seen_s > UNSEEN_S):
                self._entering, self._aligned_s = False, 0.0
            else:
                return self._to(-PRESS_M)
        near = off_m < ALIGNED_M and turn_rad < ALIGNED_RAD and sight.seen_s < UNSEEN_S
        low = abs(sight.above_m - HOVER_M) < 0.1
        self._aligned_s = self._aligned_s + dt if near and low else 0.0
        self._entering = self._aligned_s >= ALIGNED_S
        if off_m < NEAR_M:
            return self._to(HOVER_M)
        return min(self._to(HOVER_M), 0.0)

    def _level(self, observation: Observation, off_m: float) -> tuple[float, float]:
        model, yaw = self._model, self._sight.yaw
        sine, cosine = yaw
        model.update(observation)
        self._observer.update(observation)
        speeds, forces = observation.velocity.tolist(), self._observer.force
        surge, sway = (speeds[axis] - model.speed_of(axis, -forces[axis]) for axis in AXES)
        flow = (cosine * surge - sine * sway, sine * surge + cosine * sway)
        for axis in AXES:
            self._water[axis] += FLOW_1_S * observation.dt * (flow[axis] - self._water[axis])
        north, east = self._wanted(off_m)
        to_north, to_east = self._water
        wanted, water = to_body(north, east, yaw), to_body(to_north, to_east, yaw)
        references = []
        for axis in AXES:
            push = model.drag(axis, wanted[axis] - water[axis])
            push += model.mass[axis] * SPEED_GAIN_1_S * (wanted[axis] - speeds[axis])
            references.append(model.reference(axis, push))
        return references[0], references[1]
