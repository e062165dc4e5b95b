"""Oracles of interventions: they see the truth and have no latency. Marks on the leaderboard."""

from collections.abc import Mapping
from pkgutil import resolve_name
from types import SimpleNamespace
from typing import Any

from seamark.sim.control.manipulation import recover, valve
from seamark.sim.control.manipulation.approach import WORK, Approach
from seamark.sim.control.manipulation.kinematics import Matrix, Vector, applied, rotation
from seamark.sim.control.observation import Observation
from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.libm import atan2


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


class RecoverOracle(Oracle, recover.ResolvedRate):
    """`recover.ResolvedRate` that sees the truth."""


class ValveOracle(Oracle, valve.ResolvedRate):
    """`valve.ResolvedRate` that sees the truth."""
