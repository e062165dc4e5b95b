"""Bow into the current: the vehicle turns about its tool to where the thrusters hold most."""

import math
from collections.abc import Mapping, Sequence
from pkgutil import resolve_name
from typing import Any

from seamark.sim.control.observation import Observation
from seamark.sim.control.position.kalman_filter import POSITION, VELOCITY
from seamark.sim.control.position.vehicle_model import AXES, VehicleModel
from seamark.sim.control.position.water_filter import WaterFilter
from seamark.sim.control.position.yaw_moment import YAW, YawMoment, wrapped
from seamark.sim.vehicles import load

CAMERA_M = (-0.2, -0.1, 0.95)  # place of the camera in the body: seamark.sim.camera.optics.MOUNT_M
TOOL_AHEAD_M = 1.0  # of the tool before it: seamark.sim.metrics.tool_point.TOOL_AHEAD_M
LATENCY_S = 0.1  # E: as for the regulator of `lqr.py`, so that one value suits all vehicles
# E: the best of scans on seeds 1001 to 1008 of currents-v2 with the true corners.
BANDWIDTH = 0.7  # of the position times the sum of lag and latency
WATER_M_S2 = 0.05  # noise density of the water's acceleration
CAMERA_DELAY_STEPS = 1
FLOW_1_S = 1.0  # how fast the current that the bow is turned by follows the estimate
TURN_1_S = 1.0  # natural frequency of the wanted heading
FASTEST_RAD_S = 0.4
LARGEST_TURN_RAD = 1.3  # with it the target stays in view of the camera
LARGEST_LEAD_RAD = 0.3  # of the wanted heading before the vehicle's
OTHER_SIDE_RAD = 0.2  # that the stern must be nearer than the bow to be turned instead
# Share of the thrust that the current takes at the heading of the station, from which the vehicle
# turns away, and from which it turns all the way.
TURNING_SHARES = (1.0, 1.5)
MARGIN = 1.2  # of the published limits, that moves may ask for: thrusters may be stronger
LEAST_ROOM = 0.2  # of a thruster, for surge and sway whatever the moment takes
SHORTFALL_1_S = 1.0  # how fast the force that thrusters fail to deliver is asked for in addition
Level = tuple[float, float]  # of the horizontal plane: north and east, or surge and sway


class Controller:
    """A regulator on the estimate about a pose that turns with the current.

        force = M (a_r - w² (p - p_r) - 2 w (v - v_r)) - water + shortfall

    p_r, v_r and a_r are those of a vehicle whose tool stays where it is while its heading follows
    the current (weather optimal positioning, Fossen and Strand 2001). A Kalman filter that knows
    how a hull turns in water estimates the current (`water_filter`), an observer the moment that
    turns the hull (`yaw_moment`). As the observation has the real thrusts, the force that weak
    thrusters fail to deliver is known, and asked for in addition. Moments go first: forces are
    reduced, all alike, to the room that they leave in each thruster.

    It uses what every program is told, and no setting.
    """

    label = "Bow into the current"

    def __init__(self, config: Mapping[str, Any]) -> None:
        vehicle = load(config["vehicle"])
        self.model = VehicleModel(config)
        self.bandwidth = BANDWIDTH / (self.model.lag_s + LATENCY_S)  # [1/s] w
        self.filter = WaterFilter(
            self.model, CAMERA_M, water_m_s2=WATER_M_S2, delay_steps=CAMERA_DELAY_STEPS
        )
        self.yaw = YawMoment(vehicle, self.model)
        allocator = resolve_name("seamark.sim.control.allocation:allocator")  # compiled
        rows = allocator(vehicle).tolist()
        self._shares = [(row[0], row[1], row[YAW]) for row in rows if row[0] or row[1]]
        self._forward, self._reverse = vehicle.curve.limits.value  # [N]
        self._sincos = resolve_name("seamark.sim.numerics.libm:sincos")
        self._atan2 = resolve_name("seamark.sim.numerics.libm:atan2")
        self.reset({})

    def reset(self, level: Mapping[str, float | int]) -> None:
        """Forget the last level."""
        self.model.reset()
        self.filter.reset()
        self.yaw.reset()
        self._flow = [0.0, 0.0]  # [m/s] the current, north, east
        self._aim = 0.0  # [rad] the heading with bow or stern in the current
        self._heading: float | None = None  # [rad] wanted; None before the first observation
        self._rate = 0.0  # [rad/s] of it
        self._asked = [0.0, 0.0]  # [N] as thrusters with the lag would deliver it
        self._shortfall = [0.0, 0.0]  # [N]

    def step(self, observation: Observation) -> Sequence[float]:
        """Return surge, sway, heave [m/s] and yaw rate [rad/s]."""
        self.model.update(observation)
        self.filter.update(observation)
        yaw, turning, dt = observation.attitude.item(2), observation.rates.item(2), observation.dt
        turned = self._sincos(yaw)
        self._look_at_water(turned, dt)
        heading = self._turn(yaw, dt)
        rate = self.yaw.rate(heading, yaw, turning, dt)
        water = self.filter.pushes(turning)
        wanted = [
            self.model.mass[axis] * rise - water[axis]
            for axis, rise in enumerate(self._rise(heading, turned))
        ]
        asked, share = self._within([w + s for w, s in zip(wanted, self._shortfall, strict=True)])
        self._compare(wanted, share, dt)
        surge, sway = (self.model.reference(axis, asked[axis]) for axis in AXES)
        return [surge, sway, 0.0, rate]

    def _look_at_water(self, turned: Level, dt: float) -> None:
        """Follow the current over ground."""
        through, states = self.filter.through(), self.filter.states
        water = [past + state[VELOCITY] for past, state in zip(through, states, strict=True)]
        for axis, speed in enumerate(_to_world(water, turned)):
            self._flow[axis] += FLOW_1_S * dt * (speed - self._flow[axis])

    def _turn(self, yaw: float, dt: float) -> tuple[float, float, float]:
        """Return the wanted heading [rad], its rate and its acceleration after a step."""
        north, east = self._flow
        ahead = self._atan2(-east, -north) - self._aim
        self._aim = wrapped(self._aim + ahead - math.pi * math.floor(ahead / math.pi + 0.5))
        other = wrapped(self._aim + math.pi)
        if abs(other) + OTHER_SIDE_RAD < abs(self._aim):
            self._aim = other
        slow, fast = TURNING_SHARES
        share = min(max((self._taken() - slow) / (fast - slow), 0.0), 1.0)
        wanted = min(max(share * self._aim, -LARGEST_TURN_RAD), LARGEST_TURN_RAD)
        heading = yaw if self._heading is None else self._heading
        lead = min(max(wrapped(heading - yaw), -LARGEST_LEAD_RAD), LARGEST_LEAD_RAD)
        heading = yaw + lead
        rise = TURN_1_S * (TURN_1_S * (wanted - heading) - 2.0 * self._rate)
        rate = min(max(self._rate + rise * dt, -FASTEST_RAD_S), FASTEST_RAD_S)
        rise, self._rate = (rate - self._rate) / dt, rate
        self._heading = heading + rate * dt
        return self._heading, rate, rise

    def _taken(self) -> float:
        """Return the share of its thrust that the current takes of the busiest thruster."""
        surge, sway = (self.model.drag(axis, self._flow[axis]) for axis in AXES)
        most: float = max(abs(a * surge + b * sway) for a, b, _yaw in self._shares)
        return most / self._reverse

    def _rise(self, heading: tuple[float, float, float], turned: Level) -> list[float]:
        """Return the acceleration of the origin over ground [m/s²] on surge and sway."""
        angle, rate, rise = heading
        sine, cosine = self._sincos(angle)
        reach, square = TOOL_AHEAD_M, rate * rate
        places = _to_body((reach * (1.0 - cosine), -reach * sine), turned)
        speeds = _to_body((reach * rate * sine, -reach * rate * cosine), turned)
        rises = _to_body(
            (
                reach * (rise * sine + square * cosine),
                reach * (square * sine - rise * cosine),
            ),
            turned,
        )
        ahead, side, _down = CAMERA_M
        swept = (-rate * side, rate * ahead)  # [m/s] the camera, by turning about the origin
        swinging = (rise * side + square * ahead, square * side - rise * ahead)
        wanted = []
        for axis, state in enumerate(self.filter.states):
            off = state[POSITION] - places[axis]
            speed = state[VELOCITY] + swept[axis] - speeds[axis]
            back = self.bandwidth * (self.bandwidth * off + 2.0 * speed)
            wanted.append(rises[axis] + swinging[axis] - back)
        return wanted

    def _within(self, forces: Sequence[float]) -> tuple[list[float], float]:
        """Return the forces that thrusters have room for beside the moment, and their share."""
        share, moment = 1.0, self.yaw.moment
        for by_surge, by_sway, by_yaw in self._shares:
            own, taken = by_surge * forces[0] + by_sway * forces[1], by_yaw * moment
            room = MARGIN * self._forward - taken if own > 0.0 else MARGIN * self._reverse + taken
            room = max(room, LEAST_ROOM * self._forward)
            if abs(own) > room:
                share = min(share, room / abs(own))
        return [share * force for force in forces], share

    def _compare(self, wanted: Sequence[float], share: float, dt: float) -> None:
        """Note what the thrusters fail to deliver, unless more was wanted than they have."""
        passed = dt / (self.model.lag_s + LATENCY_S + dt)
        for axis in AXES:
            self._asked[axis] += passed * (share * wanted[axis] - self._asked[axis])
            if share == 1.0:
                short = self._asked[axis] - self.model.force[axis]
                self._shortfall[axis] += SHORTFALL_1_S * dt * short


def _to_body(vector: Sequence[float], turned: Level) -> Level:
    """Return a vector over ground, north and east, along surge and sway."""
    (sine, cosine), (north, east) = turned, vector
    return cosine * north + sine * east, cosine * east - sine * north


def _to_world(vector: Sequence[float], turned: Level) -> Level:
    """Return a vector along surge and sway, north and east."""
    (sine, cosine), (surge, sway) = turned, vector
    return cosine * surge - sine * sway, sine * surge + cosine * sway
