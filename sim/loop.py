"""The control loop of one level: sense, ask the program, act, record, step the world.

A row holds the state at the tick, the picture of that state, what was made of it, and the thrust
that acted at that moment; the new commands work from there on.
"""

import math
import time
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim.experiments import OnRows
from sim.observation import THRUSTERS, empty
from sim.program import Command, Program
from sim.sensors import Truth
from sim.station_keeper import Aim
from sim.telemetry import Recorder
from sim.tracking import Seen, pictured
from sim.velocity_controller import Sensed
from sim.world import World

Row = NDArray[np.float64]


class StateInvalid(Exception):
    """The simulation has left the range in which its numbers are finite: no trial can go on."""


class Known(NamedTuple):
    """What the sensors say at a tick."""

    sensed: Sensed  # the velocity controller's part
    valid: bool  # whether the DVL's last measurement succeeded
    altitude: float  # [m]
    attitude: tuple[float, ...]  # roll, pitch, yaw [rad], p, q, r [rad/s]


class LevelLoop:
    """Runs one level tick by tick."""

    def __init__(self, world: World, program: Program, *, trial: int, level: int) -> None:
        config = world.config
        self._world, self._program = world, program
        self._trial, self._level = trial, level
        self._ticks, self._dt = config.ticks_per_level, config.control_period_s
        self._steps = config.steps_per_tick
        self._first_frame = level * self._ticks
        self._began = level * config.level_duration_s
        thrusters = len(world.plant.vehicle.thrusters)
        self._observation = empty(thrusters)
        self._centre = world.camera.optics.principal_px
        self._station = world.camera.truth(world.start)[-3:]
        self._below_camera = world.target.height_m + world.camera.optics.mount_m[2]
        self._no_thrust = [0.0] * (THRUSTERS - thrusters)
        self._step_us = 0.0

    def run(self, recorder: Recorder, on_rows: OnRows) -> None:
        """Run the level; rows go to `on_rows` whenever the recorder is full.

        Whatever the program raises passes through; the recorder then still has the rows so far.
        """
        for tick in range(self._ticks):
            row = recorder.next_row()
            self._tick(tick, row)
            if recorder.keep():
                on_rows(recorder.take())

    def close(self) -> None:
        """Give back what the world holds."""
        self._world.close()

    def _tick(self, tick: int, row: Row) -> None:
        world = self._world
        pose = world.plant.pose()
        placed, moving = pose.tolist(), world.plant.velocity().tolist()
        self._check(tick, "the vehicle's state", placed + moving)
        seen = self._look(tick, pose, moving)
        known = self._sense(tick, placed, moving)
        aim = world.keeper.step(
            seen.corners if seen.ok else None,
            height=known.altitude - self._below_camera,
            tilt=(known.attitude[0], known.attitude[1]),
            dt=self._dt,
        )
        thrust = world.plant.state[13:].tolist()
        self._tell(tick, aim, known, thrust)
        if tick == 0:
            self._begin(known.sensed)
        reference = self._ask()
        row[:] = (
            *(self._trial, self._level, self._began + tick * self._dt),
            *placed,
            *moving,
            *world.plant.current_world().tolist(),
            *pictured(seen, aim.error, self._centre, self._station),
            *reference,
            *known.sensed.velocity,
            *thrust,
            *self._no_thrust,
            world.plant.contact_force(),
            self._step_us,
        )
        commands = world.velocity_controller.step(reference, known.sensed, self._dt)
        self._check(tick, "the thrusters' command", commands.tolist())
        world.plant.advance(tick * self._steps, commands, self._steps)

    def _check(self, tick: int, what: str, values: Sequence[float]) -> None:
        """Raise StateInvalid unless all values are finite."""
        if not math.isfinite(math.fsum(map(abs, values))):
            t = self._began + tick * self._dt
            raise StateInvalid(f"At {t:g} s of simulated time {what} is no longer finite.")

    def _look(self, tick: int, pose: Row, velocity: list[float]) -> Seen:
        if self._world.camera.effects.exposure_s > 0:  # motion blur
            pose = np.array([*pose.tolist(), *velocity])
        tracking = self._world.tracking
        if tick == 0:
            return tracking.start(pose, self._first_frame)
        return tracking.update(pose, self._first_frame + tick)

    def _sense(self, tick: int, pose: list[float], velocity: list[float]) -> Known:
        sensors, physics_tick = self._world.sensors, tick * self._steps
        truth = Truth(pose, velocity, *self._world.bottom.sound(pose))
        (surge, sway, heave), valid = sensors.dvl.measure(physics_tick, truth)
        (depth,), _ = sensors.depth.measure(physics_tick, truth)
        (altitude,), _ = sensors.altimeter.measure(physics_tick, truth)
        attitude, _ = sensors.ahrs.measure(physics_tick, truth)
        fresh = valid and sensors.dvl.age(physics_tick) == 0
        roll, pitch, yaw, p, q, r = attitude
        tilt, rates = (roll, pitch), (p, q)
        sensed = Sensed((surge, sway, heave), depth, yaw, r, fresh, tilt, rates)
        return Known(sensed, valid, altitude, attitude)

    def _tell(self, tick: int, aim: Aim, known: Known, thrust: list[float]) -> None:
        """Fill the observation, in the order of `observation.FIELDS`."""
        self._observation[:] = (
            *(self._began + tick * self._dt, self._dt),
            *aim.error,
            *aim.error_px,
            *(aim.visible, aim.age_s),
            *known.sensed.velocity,
            *(known.valid, known.sensed.depth, known.altitude),
            *known.attitude,
            *thrust,
        )

    def _begin(self, sensed: Sensed) -> None:
        config = self._world.config
        self._world.velocity_controller.reset(sensed)
        self._program.reset(
            {
                "index": self._level,
                "count": len(config.level_values()),
                "duration_s": config.level_duration_s,
                "dt": self._dt,
                "t": self._began,
            }
        )

    def _ask(self) -> Command:
        began = time.perf_counter_ns()
        reference = self._program.step(self._observation)
        self._step_us = (time.perf_counter_ns() - began) * 1e-3
        return reference
