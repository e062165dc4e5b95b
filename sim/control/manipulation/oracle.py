"""Oracles of interventions: they see the truth and have no latency. Marks on the leaderboard."""

import math
from collections.abc import Mapping
from pkgutil import resolve_name
from types import SimpleNamespace
from typing import Any, ClassVar

from seamark.sim.control.manipulation import mission, recover, valve
from seamark.sim.control.manipulation.approach import FALL, WORK, Approach, clipped, turned
from seamark.sim.control.manipulation.arm_data import Vector
from seamark.sim.control.manipulation.kinematics import Matrix, applied, rotation
from seamark.sim.control.observation import Observation
from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.libm import PI, atan2
from seamark.sim.numerics.statistics import mean

KYAW, YAW_RAD_S = 0.6, 0.2  # [1/s, rad/s] of the heading
SMALL_RAD, BOW_RAD = 0.1, 0.4  # from the current: left alone, and to come down
WEAK_M_S = 0.05  # a current that needs no turn
CALM_M_S = 0.01  # of the vehicle's heave
AHEAD_S, SAMPLES = 12.0, 13  # over which the current is averaged


class Oracle(Approach):
    """Has the true states of vehicle, arm and work at every control step."""

    label = "Oracle (knows the truth)"

    def __init__(self, config: Mapping[str, Any]) -> None:
        super().__init__(config)
        self._settings = SimpleNamespace(**config)
        self._command = [0.0] * 4

    def attach(self, plant: Any, station: Array, point: tuple[float, float] | None) -> None:
        """Take the plant of a level."""
        controller = resolve_name(
            "seamark.sim.control.velocity_controller:VelocityController"
        )  # compiled: only for runs
        self._plant = plant
        self._grip_m: Vector = plant.grip_m
        self._law = controller(plant.vehicle, self._settings)

    def reset(self, level: Mapping[str, float | int]) -> None:
        """Hold the depth and heading of the start."""
        super().reset(level)
        self._measure()
        self._law.reset()

    def step(self, observation: Observation) -> list[float]:
        """Return the command; the thrusters have theirs from `commands`."""
        command = list(super().step(observation))
        self._command = command[:4]
        return command

    def commands(self) -> Array:
        """Return the thrusters' commands, (n,) in [-1, 1]."""
        self._measure()
        commands: Array = self._law.step(self._command, self.dt)
        return commands

    def _measure(self) -> None:
        measured, pose, velocity = self._law.measured[0], self._plant.pose(), self._plant.velocity()
        measured["velocity"], measured["fresh"] = velocity[:3], True
        measured["depth"], measured["yaw"], measured["yaw_rate"] = pose[2], pose[5], velocity[5]
        measured["tilt"], measured["tilt_rates"] = pose[3:5], velocity[3:5]

    def _attitude(self, observation: Observation) -> Vector:
        roll, pitch, yaw = self._plant.pose()[3:].tolist()
        return roll, pitch, yaw

    def _velocity(self, observation: Observation) -> Vector:
        u, v, w = self._plant.velocity()[:3].tolist()
        return u, v, w

    def _rates(self, observation: Observation) -> Vector:
        p, q, r = self._plant.velocity()[3:].tolist()
        return p, q, r

    def _joints(self, observation: Observation) -> list[float]:
        joints: list[float] = self._plant.joints().tolist()
        return joints

    def _depth(self, observation: Observation) -> float:
        return float(self._plant.pose()[2])

    def _reckon(self, velocity: Vector, yaw: float) -> None:
        self.place = self._plant.pose()[:2].tolist()

    def _look(self, observation: Observation, tilt: Matrix, yaw: float) -> None:
        """Take the true place of the grip and the true direction of the handle."""
        if self.phase < WORK:
            turn = rotation(*self._plant.work[3:6].tolist())
            x, y, z = applied(turn, self._grip_m)
            north, east, down = self._plant.work[:3].tolist()
            self.work = (north + x, east + y, down + z)
            self.handle = atan2(turn[1][1], turn[0][1])


class IntoCurrent(Oracle):
    """Turns its bow into the mean current of the next seconds, about the tool.

    A Girona 500 resists from ahead more than twice the current that it resists from abeam. Small
    angles it leaves alone, because its thrusters give the same force either to turn or to push.
    """

    KEEPS_HEADING: ClassVar[frozenset[int]]  # phases in which the work does not let it turn

    def reset(self, level: Mapping[str, float | int]) -> None:
        """Hold the depth and heading of the start."""
        super().reset(level)
        self._ends_s = level["t"] + level["duration_s"]

    def step(self, observation: Observation) -> list[float]:
        """Return the command."""
        left_s = max(self._ends_s - observation.t, 0.0)
        step_s = min(AHEAD_S, left_s) / (SAMPLES - 1)
        flows = [self._plant.current_world(step_s * k).tolist() for k in range(SAMPLES)]
        self._flow = [mean([flow[axis] for flow in flows]) for axis in (0, 1)]
        return super().step(observation)

    def _turn(self, joints: list[float], tilt: Matrix, yaw: float) -> float:
        return self._yaw_rate()

    def _yaw_rate(self) -> float:
        if self.phase in self.KEEPS_HEADING:
            return 0.0
        return clipped(KYAW * self._to_turn(), YAW_RAD_S)

    def _fly(self, error: Vector, yaw: float, observation: Observation) -> list[float]:
        """Return surge, sway and heave; the vehicle turns about the tool."""
        surge, sway, heave = super()._fly(error, yaw, observation)
        ahead, side, _ = self.kinematics.tool(self._joints(observation)).point
        rate = self._yaw_rate()
        return [surge + rate * side, sway - rate * ahead, heave]

    def _ready(self) -> bool:
        return super()._ready() and abs(self._to_turn()) < BOW_RAD - SMALL_RAD

    def _to_turn(self) -> float:
        """Return how far it is to turn now [rad]."""
        off = self._off_the_bow()
        return off - clipped(off, SMALL_RAD)

    def _off_the_bow(self) -> float:
        """Return the direction from which the water comes in the mean, from the bow [rad]."""
        north, east = self._flow
        if north * north + east * east < WEAK_M_S * WEAK_M_S:
            return 0.0
        ahead, side = turned((-north, -east, 0.0), -self._plant.pose()[5])
        return atan2(side, ahead)


class AgainstCurrent(IntoCurrent):
    """Turns the stern into the current if that is nearer at the start, and knows the force of it.

    A current that swings about the bow changes its force across the hull faster than one from
    abeam, and the velocity controller, which is not told, learns of that too late.
    """

    def reset(self, level: Mapping[str, float | int]) -> None:
        """Hold the depth and heading of the start."""
        super().reset(level)
        self._stern: bool | None = None  # until there is a current
        self._known_n = [0.0, 0.0]

    def commands(self) -> Array:
        """Return the thrusters' commands, (n,) in [-1, 1]."""
        self._feed_forward()
        return super().commands()

    def _feed_forward(self) -> None:
        """Tell the velocity controller at once how the force of the current changes."""
        north, east, down = self._plant.current_world().tolist()
        water = turned((north, east, down), -self._plant.pose()[5])
        speeds = self._plant.velocity().tolist()
        for axis, record in enumerate(self._law.records()[1][:2]):
            now_n = _drag(record, speeds[axis]) - _drag(record, speeds[axis] - water[axis])
            record["disturbance"] += now_n - self._known_n[axis]
            self._known_n[axis] = now_n

    def _off_the_bow(self) -> float:
        off = super()._off_the_bow()
        if self._stern is None and off != 0.0:
            self._stern = abs(off) > 0.5 * PI
        return off - math.copysign(PI, off) if self._stern and off != 0.0 else off


class RecoverOracle(IntoCurrent, recover.ResolvedRate):
    """`recover.ResolvedRate` that sees the truth and turns its bow into the current to come."""

    # It need not look or feel, and knows the depth.
    ABOVE_M, SLOW_M, BOTTOM_M, SETTLE_S, FEEL_M = 0.25, 0.3, 0.02, 0.0, 0.0
    KEEPS_HEADING = frozenset({FALL, recover.CLOSE})  # the jaws stay across the handle

    def _go(self, phase: int) -> None:
        """Go to a phase; the jaws wait until the vehicle, which they would stop, is at rest."""
        if phase != recover.CLOSE or abs(self._plant.velocity()[2]) < CALM_M_S:
            super()._go(phase)


class MissionOracle(mission.Delivery, RecoverOracle):
    """`RecoverOracle` that knows where the box is, and brings it back."""


class ValveOracle(AgainstCurrent, valve.ResolvedRate):
    """`valve.ResolvedRate` that sees the truth and turns bow or stern into the current to come.

    It turns as far as the wrist has room for its whole way then.
    """

    KEEPS_HEADING = frozenset({FALL, valve.TURN, valve.LEAVE})

    def reset(self, level: Mapping[str, float | int]) -> None:
        """Hold the depth and heading of the start."""
        super().reset(level)
        self._turn_rad = 0.0

    def _before(self, joints: list[float], tilt: Matrix, yaw: float) -> tuple[float, float]:
        way, askew = super()._before(joints, tilt, yaw)
        turn = super()._to_turn()
        self._turn_rad = turn + self._room(way - turn)[1]
        return way, askew

    def _to_turn(self) -> float:
        return self._turn_rad


def _drag(axis: Any, speed: float) -> float:
    """Return the nominal drag of an axis of the velocity controller [N]."""
    return float((axis["linear"] + axis["quadratic"] * abs(speed)) * speed)
