"""The control loop of one level: sense, ask the program, act, record, step the world.

A row holds the state at the tick, the picture of that state, what was made of it, and the thrust
that acted at that moment; the new commands work from there on.
"""

import math
import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seamark.sim.control.observation import empty
from seamark.sim.engine.experiment import OnRows
from seamark.sim.engine.perception import perceive
from seamark.sim.engine.program import Command, Program
from seamark.sim.engine.world import World
from seamark.sim.recording.telemetry import INDEX, STEP_US, Recorder

_REFERENCE = slice(INDEX["ref_u"], INDEX["ref_r"] + 1)
Row = NDArray[np.float64]


class StateInvalid(Exception):
    """The simulation has left the range in which its numbers are finite: no trial can go on."""


def _invalid(t: float, what: str) -> StateInvalid:
    return StateInvalid(f"At {t:g} s of simulated time {what} is no longer finite.")


class LevelLoop:
    """Runs one level tick by tick."""

    def __init__(self, world: World, program: Program, *, trial: int, level: int) -> None:
        config = world.config
        self._world, self._program = world, program
        self._trial, self._level = trial, level
        self._ticks, self._dt = config.control_steps_per_level, config.control_period_s
        self._steps = config.physics_steps_per_control_step
        self._first_frame = level * self._ticks
        self._began = level * config.level_duration_s
        self._blurred = world.camera.effects.exposure_s > 0.0
        self._pose = np.zeros(6)
        self._observation = empty(len(world.plant.vehicle.thrusters))
        self._known = self._packed()
        self._step_us = 0.0

    def _packed(self) -> tuple[Any, Any, Any, Any, Any, Any]:
        """Return what `perceive` is given at every tick, but for the first and the last."""
        world = self._world
        tracking, plant = world.tracking, world.plant
        below_camera = world.target.height_m + world.camera.optics.mount_m[2]
        step = world.config.physics_step_s
        return (
            (self._trial, self._level, step, self._dt, below_camera),
            (tracking.view, world.camera.place(world.start), tracking.corners),
            (plant.state, self._pose, plant.water),
            world.sensors.suite(),
            world.sensors.noises(),
            world.keeper.record,
        )

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
        world, t = self._world, self._began + tick * self._dt
        if not world.plant.read_pose(self._pose):
            raise _invalid(t, "the vehicle's state")
        self._look(tick)
        self._perceive(tick, t, row)
        if tick == 0:
            self._begin()
        row[_REFERENCE] = reference = self._ask()
        row[STEP_US] = self._step_us
        commands = world.velocity_controller.step(reference, self._dt)
        if not all(map(math.isfinite, commands.tolist())):
            raise _invalid(t, "the thrusters' command")
        world.plant.advance(tick * self._steps, commands, self._steps)

    def _look(self, tick: int) -> None:
        pose, tracking = self._pose, self._world.tracking
        if self._blurred:
            pose = np.concatenate([pose, self._world.plant.velocity()])
        look = tracking.update if tick else tracking.start
        look(pose, self._first_frame + tick)

    def _perceive(self, tick: int, t: float, row: Row) -> None:
        """Measure, judge and aim; fill the row and the observation."""
        world = self._world
        altitude, echoes = world.bottom.sound(self._pose)
        contact_n = world.plant.contact_force()
        moment = (tick * self._steps, t, world.tracking.ok, altitude, echoes, contact_n)
        perceive(moment, *self._known, (row, self._observation, world.velocity_controller.measured))

    def _begin(self) -> None:
        config = self._world.config
        self._world.velocity_controller.reset()
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
