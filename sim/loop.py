"""The control loop of one level: sense, ask the program, act, record, step the world.

A row holds the state at the tick, the picture of that state, what was made of it, and the thrust
that acted at that moment; the new commands work from there on.
"""

import math
import time
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim.camera.geometry import look
from sim.observation import THRUSTERS, empty
from sim.program import Command, Program
from sim.sensors import Truth
from sim.station_keeper import Aim, crossing
from sim.telemetry import Recorder
from sim.tracking import Seen
from sim.velocity_controller import Sensed
from sim.world import World

Row = NDArray[np.float64]
OnRows = Callable[[NDArray[np.float64]], None]


class Known(NamedTuple):
    """What the sensors say at a tick."""

    sensed: Sensed  # the velocity controller's part
    valid: bool  # whether the DVL's last measurement succeeded
    altitude: float  # [m]
    attitude: list[float]  # roll, pitch, yaw [rad], p, q, r [rad/s]


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
        self._observation = empty()
        self._mount = np.array(world.camera.optics.mount_m)
        self._centre = world.camera.optics.principal_px
        self._station = _camera_place(world.start, self._mount)
        self._below_camera = world.target.height_m + float(self._mount[2])
        self._no_thrust = [0.0] * THRUSTERS
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

    def _tick(self, tick: int, row: Row) -> None:
        world = self._world
        pose, velocity = world.plant.pose(), world.plant.velocity()
        seen = self._look(tick, pose)
        known = self._sense(tick, pose, velocity)
        aim = world.keeper.step(
            seen.corners if seen.ok else None,
            height=known.altitude - self._below_camera,
            tilt=(known.attitude[0], known.attitude[1]),
            dt=self._dt,
        )
        thrust = world.plant.state[13 : 13 + THRUSTERS].tolist()
        thrust += self._no_thrust[len(thrust) :]
        self._tell(tick, aim, known, thrust)
        if tick == 0:
            self._begin(known.sensed)
        reference = self._ask()
        row[:] = (
            *(self._trial, self._level, self._began + tick * self._dt),
            *pose.tolist(),
            *velocity.tolist(),
            *world.plant.current_world().tolist(),
            *self._pictured(pose, seen, aim),
            *reference,
            *known.sensed.velocity,
            *thrust,
            self._step_us,
        )
        commands = world.velocity_controller.step(reference, known.sensed, self._dt)
        world.plant.advance(tick * self._steps, commands, self._steps)

    def _look(self, tick: int, pose: Row) -> Seen:
        tracking = self._world.tracking
        if tick == 0:
            return tracking.start(pose, self._first_frame)
        return tracking.update(pose, self._first_frame + tick)

    def _sense(self, tick: int, pose: Row, velocity: Row) -> Known:
        sensors, physics_tick = self._world.sensors, tick * self._steps
        truth = Truth(pose, velocity, self._world.target.seabed_m - float(pose[2]))
        speed, valid = sensors.dvl.measure(physics_tick, truth)
        depth, _ = sensors.depth.measure(physics_tick, truth)
        altitude, _ = sensors.altimeter.measure(physics_tick, truth)
        attitude, _ = sensors.ahrs.measure(physics_tick, truth)
        surge, sway, heave = speed.tolist()
        angles = attitude.tolist()
        fresh = valid and sensors.dvl.age(physics_tick) == 0
        sensed = Sensed((surge, sway, heave), float(depth[0]), angles[2], angles[5], fresh)
        return Known(sensed, valid, float(altitude[0]), angles)

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
                "count": len(config.levels),
                "duration_s": config.level_duration_s,
                "dt": self._dt,
                "t": self._began,
            }
        )

    def _ask(self) -> Command:
        # A copy: what a program does to its observation must not reach the next one.
        began = time.perf_counter_ns()
        reference = self._program.step(self._observation.copy())
        self._step_us = (time.perf_counter_ns() - began) * 1e-3
        return reference

    def _pictured(self, pose: Row, seen: Seen, aim: Aim) -> tuple[float, ...]:
        """Return the columns from `target_x` to `distance`."""
        u0, v0 = self._centre
        x, y, z = (_camera_place(pose, self._mount) - self._station).tolist()
        off_x, off_y = seen.target[0] - u0, seen.target[1] - v0
        return (
            *seen.target,
            *crossing(seen.corners),
            *seen.corners,
            *(seen.ok, seen.error_px),
            *aim.error,
            *(off_x, off_y, math.sqrt(off_x * off_x + off_y * off_y)),
            math.sqrt(x * x + y * y + z * z),
        )


def _camera_place(pose: Row, mount: Row) -> Row:
    """Return where the camera is, (3,) NED [m]."""
    rotation, place = np.empty((3, 3)), np.empty(3)
    look(pose, mount, rotation, place)
    return place
