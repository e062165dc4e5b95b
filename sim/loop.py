"""The control loop of one level: sense, ask the program, act, record, step the world.

A row holds the state at the tick, the picture of that state, what was made of it, and the thrust
that acted at that moment; the new commands work from there on.
"""

import math
import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from sim.camera.geometry import look
from sim.observation import STARTS, THRUSTERS, empty
from sim.program import Command, Program
from sim.sensors import Truth
from sim.station_keeper import Aim, crossing
from sim.telemetry import INDEX, STEP_US, Recorder
from sim.tracking import Seen
from sim.velocity_controller import Sensed
from sim.world import World

Row = NDArray[np.float64]
_TARGET, _THRUST = INDEX["target_x"], INDEX["thrust_0"]
OnRows = Callable[[NDArray[np.float64]], None]


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
        self._observation[STARTS["dt"]] = self._dt
        self._mount = np.array(world.camera.optics.mount_m)
        self._centre = world.camera.optics.principal_px
        self._station = _camera_place(world.start, self._mount)
        self._below_camera = world.target.height_m + float(self._mount[2])
        self._tilt = (0.0, 0.0)
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
        sensed, altitude = self._sense(tick, pose, velocity)
        aim = world.keeper.step(
            seen.corners if seen.ok else None,
            height=altitude - self._below_camera,
            tilt=self._tilt,
            dt=self._dt,
        )
        self._tell(tick, aim)
        if tick == 0:
            self._begin(sensed)
        reference = self._ask()
        self._record(row, (pose, velocity), seen, aim, reference)
        commands = world.velocity_controller.step(reference, sensed, self._dt)
        world.plant.advance(tick * self._steps, commands, self._steps)

    def _look(self, tick: int, pose: Row) -> Seen:
        tracking = self._world.tracking
        if tick == 0:
            return tracking.start(pose, self._first_frame)
        return tracking.update(pose, self._first_frame + tick)

    def _sense(self, tick: int, pose: Row, velocity: Row) -> tuple[Sensed, float]:
        """Measure; what only the program needs goes straight into the observation."""
        sensors, physics_tick = self._world.sensors, tick * self._steps
        truth = Truth(pose, velocity, self._world.target.seabed_m - float(pose[2]))
        speed, valid = sensors.dvl.measure(physics_tick, truth)
        depth, _ = sensors.depth.measure(physics_tick, truth)
        altitude, _ = sensors.altimeter.measure(physics_tick, truth)
        attitude, _ = sensors.ahrs.measure(physics_tick, truth)
        values = self._observation
        values[STARTS["velocity"] : STARTS["velocity"] + 3] = speed
        values[STARTS["velocity_valid"]] = valid
        values[STARTS["depth"]] = depth[0]
        values[STARTS["altitude"]] = altitude[0]
        values[STARTS["attitude"] : STARTS["attitude"] + 6] = attitude  # rates follow
        roll, pitch, yaw, _p, _q, yaw_rate = attitude.tolist()
        self._tilt = (roll, pitch)
        surge, sway, heave = speed.tolist()
        fresh = valid and sensors.dvl.age(physics_tick) == 0
        sensed = Sensed((surge, sway, heave), float(depth[0]), yaw, yaw_rate, fresh)
        return sensed, float(altitude[0])

    def _tell(self, tick: int, aim: Aim) -> None:
        """Complete the observation."""
        values = self._observation
        values[STARTS["t"]] = self._began + tick * self._dt
        at = STARTS["error"]
        values[at], values[at + 1], values[at + 2] = aim.error
        at = STARTS["error_px"]
        values[at], values[at + 1] = aim.error_px
        values[STARTS["target_visible"]] = aim.visible
        values[STARTS["target_age"]] = aim.age_s
        thrust = self._world.plant.state[13 : 13 + THRUSTERS]
        values[STARTS["thrust"] : STARTS["thrust"] + len(thrust)] = thrust

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

    def _record(
        self, row: Row, motion: tuple[Row, Row], seen: Seen, aim: Aim, reference: Command
    ) -> None:
        """Write the row in the order of `telemetry.COLUMNS`."""
        pose, velocity = motion
        plant, (u0, v0) = self._world.plant, self._centre
        x, y, z = _camera_place(pose, self._mount) - self._station
        off_x, off_y = seen.target[0] - u0, seen.target[1] - v0
        row[0], row[1], row[2] = self._trial, self._level, self._observation[STARTS["t"]]
        row[3:9] = pose
        row[9:15] = velocity
        row[15:18] = plant.current_world()
        row[_TARGET:_THRUST] = (
            *seen.target,
            *crossing(seen.corners),
            *seen.corners,
            seen.ok,
            seen.error_px,
            *aim.error,
            off_x,
            off_y,
            math.sqrt(off_x * off_x + off_y * off_y),
            math.sqrt(x * x + y * y + z * z),
            *reference,
            *self._observation[STARTS["velocity"] : STARTS["velocity"] + 3],
        )
        thrust = plant.state[13 : 13 + THRUSTERS]
        row[_THRUST:STEP_US] = 0.0
        row[_THRUST : _THRUST + len(thrust)] = thrust
        row[STEP_US] = self._step_us


def _camera_place(pose: Row, mount: Row) -> Row:
    """Return where the camera is, (3,) NED [m]."""
    rotation, place = np.empty((3, 3)), np.empty(3)
    look(pose, mount, rotation, place)
    return place
