"""The closed loop of one level: sense, step the program, record, command the thrusters, simulate.

A row of telemetry holds the state at the start of a control step, what was derived from the image
of that state, and the thrust acting at that moment. New commands take effect after it.
"""

import math
import time
from collections import deque

import numpy as np
from numpy.typing import NDArray

from seamark.sim.camera.scene import buffers_for
from seamark.sim.control.observation import COMMAND, SEARCH_NUMBERS, empty
from seamark.sim.engine.arm_in_loop import ArmInLoop
from seamark.sim.engine.delay import CommandDelay, ImageDelay
from seamark.sim.engine.dock_in_loop import DockInLoop
from seamark.sim.engine.images_in_loop import Exposure, images_of_program
from seamark.sim.engine.perception import LevelConstants, Moving, Senses, Tracked
from seamark.sim.engine.pipe_in_loop import PipeInLoop, PipeReport
from seamark.sim.engine.program import (
    Autopilot,
    BuiltIn,
    CameraProgram,
    Command,
    ImageProgram,
    Program,
    RouteOracle,
)
from seamark.sim.engine.route_in_loop import RouteInLoop
from seamark.sim.engine.search_in_loop import SearchInLoop, SearchReport
from seamark.sim.engine.sensing import NOT_FINITE, SEEN, TRACKED, Looking, measure, sense
from seamark.sim.engine.steering import NOT_FINITE as NOT_STEERED
from seamark.sim.engine.steering import Steering, steer
from seamark.sim.engine.world import World
from seamark.sim.numerics.compilation import SameTypes
from seamark.sim.numerics.lent import Lent
from seamark.sim.recording.telemetry import INDEX, STEP_US, OnRows, Recorder, width_for
from seamark.sim.trackers.template.level_buffers import bench_for, bench_size

VEHICLE = len(COMMAND)  # numbers of a command for the vehicle; those for an arm follow
_REFERENCE = slice(INDEX["ref_u"], INDEX["ref_r"] + 1)
Row = NDArray[np.float64]


class StateInvalid(Exception):
    """The simulation diverged: a number is no longer finite, so the trial cannot go on."""


def _invalid(t: float, what: str) -> StateInvalid:
    return StateInvalid(f"At {t:g} s of simulated time {what} is no longer finite.")


class ClosedLoop:
    """Runs one level, one control step after the other."""

    def __init__(
        self,
        world: World,
        program: Program,
        *,
        trial: int,
        level: int,
        position: int | None = None,
    ) -> None:
        """Set up a level; `position` is its index in the trial's time, `level` unless given."""
        config = world.config
        self._world, self._program = world, program
        self._oracle = program.oracle if isinstance(program, BuiltIn) else None
        self._autopilot = program if isinstance(program, Autopilot) else None
        self._camera_program = program if isinstance(program, CameraProgram) else None
        self._image_program = program if isinstance(program, ImageProgram) else None
        self._trial, self._level = trial, level
        self._steps, self._dt = config.control_steps_per_level, config.control_period_s
        self._physics_steps = config.physics_steps_per_control_step
        self._position = level if position is None else position
        self._first_frame = self._position * self._steps
        self._start_s = self._position * config.level_duration_s
        self._seen = ImageDelay(world.conditions.camera_delay_steps)
        # Pose and velocity of the images from the one that the observation is of to the present one
        self._motions: deque[tuple[int, Row]] = deque(
            maxlen=world.conditions.camera_delay_steps + 1
        )
        self._delayed = CommandDelay(world.conditions.command_delay_steps)
        self._motion_blur = world.camera.effects.exposure_s > 0.0
        self._thrusters = len(world.plant.vehicle.thrusters)
        self._contact_n = 0.0
        self._pose = np.zeros(6)
        size, cameras = world.arm.size if world.arm else None, config.cameras_of_program()
        told = config.told()
        self.observation = empty(self._thrusters, size, images=bool(cameras), **told)
        of_arm = slice(len(empty(self._thrusters)), len(empty(self._thrusters, size)))
        self._arm = None
        if world.arm is not None:
            self._arm = ArmInLoop(world.arm, self.observation[of_arm], self._seen.corners)
        self._search = self._search_from(of_arm.stop)
        self._route = self._route_from(of_arm.stop)
        self._dock = self._dock_from(of_arm.stop)
        self.images = images_of_program(world) if cameras else None
        self._step_us = 0.0
        self._senses = Lent(self._all_senses())
        self._looking: Lent[Looking] | None = None
        self._measure_row, self._sense_row = SameTypes(measure), SameTypes(sense)
        self._steering, self._steer = self._steers(), SameTypes(steer)

    def _all_senses(self) -> Senses:
        world, config = self._world, self._world.config
        constants = LevelConstants(
            trial=self._trial,
            level=self._level,
            physics_step_s=config.physics_step_s,
            dt=self._dt,
            below_camera=world.target.height_m + world.camera.optics.mount_m[2],
        )
        tracked = Tracked(
            target_view=world.tracking.target_view,
            station=world.camera.position(world.station),
            corners=world.tracking.corners,
            seen_corners=self._seen.corners,
        )
        return Senses(
            physics_steps=self._physics_steps,
            constants=constants,
            results=self._seen.results,
            tracked=tracked,
            moving=Moving(world.plant.state, self._pose, world.plant.water),
            ground=world.bottom.ground(),
            relief=world.bottom.relief is not None,
            sensors=world.sensors.records(),
            noises=world.sensors.noises(),
            keepers=world.keeper.record,
            observation=self.observation,
            measured=world.velocity_controller.measured,
        )

    def _search_from(self, first: int) -> SearchReport | None:
        """Return the search, if there is one; its part of the observation begins at `first`."""
        world = self._world
        if not isinstance(world.tracking, SearchInLoop) or not world.config.searches():
            return None
        seen = self.observation[first : first + SEARCH_NUMBERS]
        late = world.conditions.camera_delay_steps
        return SearchReport(world.tracking, seen, told_m=world.told_m, late=late)

    def _route_from(self, first: int) -> RouteInLoop | None:
        """Return the route, if there is one; its part of the observation begins at `first`."""
        world = self._world
        if world.course is None:
            return None
        pipe = None
        if isinstance(world.tracking, PipeInLoop):
            late = world.conditions.camera_delay_steps
            pipe = PipeReport(world.tracking, self._seen, world.optics, late=late)
        return RouteInLoop(
            *(world.course, self.observation, first, world.start[:3]),
            steps=self._steps,
            step_s=self._dt,
            pipe=pipe,
        )

    def _dock_from(self, first: int) -> DockInLoop | None:
        """Return the dock, if there is one; its part of the observation begins at `first`."""
        world = self._world
        if world.dock is None or not isinstance(world.tracking, SearchInLoop):
            return None
        return DockInLoop(
            *(world.dock, world.tracking, self.observation, first),
            late=world.conditions.camera_delay_steps,
            steps=self._steps,
            step_s=self._dt,
        )

    def run(self, on_rows: OnRows) -> None:
        """Run the level; rows go to `on_rows`, the last ones even if the program raises."""
        width = self.width()
        recorder = Recorder(on_rows, width=width)
        try:
            for step in range(self._steps):
                row = recorder.next_row()
                self.sense(step, row)
                self.act(step, row)
                recorder.commit()
        finally:
            recorder.flush()

    def width(self) -> int:
        """Return how many columns its rows have."""
        arm = self._world.arm
        work = arm is not None and len(arm.plant.work) > 0
        search = self._search is not None
        alone = {"route": self._route is not None, "dock": self._dock is not None}
        return width_for(self._thrusters, arm=arm is not None, work=work, search=search, **alone)

    def close(self) -> None:
        """Release what the world holds."""
        self._world.close()

    def sense(self, step: int, row: Row) -> None:
        """Fill `observation` and the row, but for what the program decides at this control step.

        Raises
        ------
        StateInvalid
            The vehicle's state is no longer finite.
        """
        t = self._start_s + step * self._dt
        if self._looking is not None:
            self._look(self._looking, step, t, row)
        else:
            self._track(step, t)
            self._measure(step, t, row)
        if self.images is not None:
            self.images.step(Exposure(step, t, self.motion(), self._first_frame + step))
            self.observation[-1] = self.images.t

    def _look(self, looking: Lent[Looking], step: int, t: float, row: Row) -> None:
        """Read the pose, track and measure in one call, which takes half of the time of three."""
        found = self._sense_row.call(
            self._senses, looking, step, self._first_frame + step, t, self._contact_n, row
        )
        if found == NOT_FINITE:
            raise _invalid(t, "the vehicle's state")
        self._world.tracking.ok, self._seen.ok = found & TRACKED != 0, found & SEEN != 0

    def _looks(self) -> Lent[Looking] | None:
        """Return what `_look` needs from now on; None if camera or tracker are not that simple."""
        world = self._world
        sight = None if self._camera_program else world.tracking.sight()
        if sight is None:
            return None
        optics = world.camera.optics
        looking = Looking(
            sight=sight,
            motion=np.zeros(12),
            blurred=self._motion_blur,
            buffers=buffers_for(optics.width),
            canvas=np.zeros((optics.height, optics.width), np.uint8),
            bench=bench_for(bench_size(sight.memory.levels)),
        )
        return Lent(looking)

    def act(self, step: int, row: Row) -> None:
        """Ask the program, complete the row, and advance the vehicle to the next control step.

        Raises
        ------
        StateInvalid
            A command of a thruster is not finite.
        """
        if step == 0:
            self._reset()
        if self.images is not None and self._image_program is not None:
            self.images.show_to(self._image_program)
        reference = self._program_step()
        row[_REFERENCE], row[STEP_US] = reference[:VEHICLE], self._step_us
        arrived = self._delayed.step(reference)
        if self._steering is not None:
            self._advance(self._steering, step, arrived[:VEHICLE])
            return
        if self._arm is not None:
            self._arm.command(reference[VEHICLE:], arrived[VEHICLE:], row)
        plant, steps = self._world.plant, self._physics_steps
        if self._autopilot is not None:
            self._fly(self._autopilot, step * steps)
            return
        commands = self.commands(arrived[:VEHICLE])
        if not all(map(math.isfinite, commands.tolist())):
            raise _invalid(self._start_s + step * self._dt, "the thrusters' command")
        plant.advance(step * steps, commands, steps)
        self._contact_n = plant.contact_force()

    def _steers(self) -> Lent[Steering] | None:
        """Return what `_advance` needs; None if more than the velocity controller moves things."""
        plant, controller = self._world.plant, self._world.velocity_controller
        reference_alone = self._oracle is None and self._autopilot is None and self._arm is None
        if not reference_alone or plant.fault is not None:
            return None
        steering = Steering(
            self._dt,
            controller.measured,
            *controller.records(),
            thrusters=controller.thrusters,
            thrust=np.zeros(self._thrusters),
            afloat=plant.afloat,
        )
        return Lent(steering)

    def _advance(self, steering: Lent[Steering], step: int, reference: Command) -> None:
        """Control and advance the vehicle in one call, which takes half of the time of two."""
        plant, steps = self._world.plant, self._physics_steps
        first = step * steps
        surge, sway, heave, yaw_rate = map(float, reference)
        gate = plant.begin(first, steps)
        done = self._steer.call(steering, surge, sway, heave, yaw_rate, first, steps, gate)
        if done == NOT_STEERED:
            raise _invalid(self._start_s + step * self._dt, "the thrusters' command")
        plant.finish(first, done, steps)
        self._contact_n = plant.contact_force()

    def _fly(self, autopilot: Autopilot, first_step: int) -> None:
        """Advance the vehicle by a control step, with commands of its own for each physics step."""
        plant, steps = self._world.plant, self._physics_steps
        contact_n = 0.0
        for step in range(first_step, first_step + steps):
            plant.advance(step, autopilot.thrusters(plant), 1)
            contact_n += plant.contact_force()
        self._contact_n = contact_n / steps

    def seen_corners(self) -> tuple[Row, bool]:
        """Return the tracked corners that have arrived, (8,) [px], and whether they are valid."""
        return self._seen.corners, self._seen.ok

    def motion(self) -> Row:
        """Return what an image depends on: pose and velocity, (12,), an arm and its workpiece."""
        parts = [self._pose, self._world.plant.velocity()]
        return np.concatenate([*parts, *(self._arm.motion() if self._arm else ())])

    def _track(self, step: int, t: float) -> None:
        """Read the pose and give the tracker its image."""
        tracking = self._world.tracking
        if not self._world.plant.read_pose(self._pose):
            raise _invalid(t, "the vehicle's state")
        pose = self._pose
        if self._motion_blur or self._arm is not None:
            pose = self.motion()
        if self._camera_program is not None:
            self._motions.append((self._first_frame + step, pose.copy()))
        track = tracking.update if step else tracking.start
        track(pose, self._first_frame + step)
        if step == 0:
            self._looking = self._looks()

    def _measure(self, step: int, t: float, row: Row) -> None:
        """Sample the sensors and update the position error; fill the row and the observation."""
        ok = bool(self._world.tracking.ok)
        self._seen.ok = self._measure_row.call(self._senses, step, t, ok, self._contact_n, row)
        if self._arm is not None:
            self._arm.measure(step, row)
        if self._search is not None:
            self._search.measure(row)
        if self._route is not None:
            self._route.measure(step, self._pose, row)
        if self._dock is not None:
            self._dock.measure(step, self._pose, row)

    def _image(self) -> NDArray[np.uint8]:
        """Return the image that the station keeper has now, in blue, green, red."""
        frame, pose = self._motions[0]
        return self._world.camera.colour(pose, frame)

    def _reset(self) -> None:
        config = self._world.config
        self._world.velocity_controller.reset()
        if self._oracle is not None:
            world = self._world
            self._oracle.attach(world.plant, world.station, world.tool_m)
            if isinstance(self._oracle, RouteOracle) and world.course is not None:
                self._oracle.follow(world.course.route_m)
        if self._camera_program is not None:
            self._camera_program.look_through(self._image)
        self._program.reset(
            {
                "index": self._position,
                "count": len(config.level_values()),
                "duration_s": config.level_duration_s,
                "dt": self._dt,
                "t": self._start_s,
            }
        )

    def commands(self, reference: Command) -> NDArray[np.float64]:
        """Return the thrusters' commands, (n,) in [-1, 1], for a reference that has arrived."""
        if self._oracle is not None:
            return self._oracle.commands()
        return self._world.velocity_controller.step(reference, self._dt)

    def _program_step(self) -> Command:
        before = time.perf_counter_ns()
        reference = self._program.step(self.observation)
        self._step_us = (time.perf_counter_ns() - before) * 1e-3
        return reference
