"""A fleet: vehicles of one benchmark that do not meet, each in a level of its own."""

import math
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seamark.sim.camera.camera import Camera
from seamark.sim.camera.geometry import camera_pose
from seamark.sim.camera.target import start_pose
from seamark.sim.engine.images_in_loop import period_steps
from seamark.sim.engine.reward import goal
from seamark.sim.engine.tracking_error import BOX_CENTRE, TOP_CENTRE, TargetView
from seamark.sim.engine.world import Craft, World, readings_of, target_and_optics
from seamark.sim.fleet.images import FleetImages, ImageKind
from seamark.sim.fleet.steps import Shared, copy_columns, sense_all, step_all
from seamark.sim.fleet.tables import COMMAND_NUMBERS, WATER_NUMBERS, Sizes, Tables, empty_tables
from seamark.sim.fleet.views import (
    Found,
    Trackers,
    motions_of,
    show_all,
    track_all,
)
from seamark.sim.fleet.whole_steps import Scratch, step_and_see
from seamark.sim.numerics.arrays import Array, Flags, Integers
from seamark.sim.numerics.lanes import LANES
from seamark.sim.numerics.lent import lend
from seamark.sim.physics.current import grid_points, table_points
from seamark.sim.physics.pose import read_pose
from seamark.sim.physics.water_motion.tabulation import ROWS
from seamark.sim.registry import TRUTH
from seamark.sim.settings.station_keeping import StationKeepingSettings
from seamark.sim.trackers.template.level_buffers import bench_size
from seamark.sim.vehicles import load

LEAST_PER_THREAD = 32  # vehicles; a thread with fewer costs more than it saves
LEAST_WITH_EYES = 16  # that track or have images
_PARTS_PER_THREAD = 4  # in which a thread takes its vehicles


def unsupported(config: StationKeepingSettings) -> str:
    """Return why a fleet cannot run a configuration; empty if it can."""
    if config.chosen_arm() is not None:
        return "a vehicle with an arm (arm) needs the single environment"
    if config.cameras_of_program():
        return "images of the cameras (images) need the single environment"
    if config.fault_thruster >= 0:
        return "thruster faults (fault_thruster) need the single environment"
    if config.seabed_relief_m:
        return "mounds on the bottom (seabed_relief_m) need the single environment"
    if len(config.level_values()) != len(config.levels):
        return "a grid of settings needs the single environment"
    return ""


class Fleet:
    """The vehicles and all they have, in tables; `craft` of a vehicle is what it was made of."""

    def __init__(
        self,
        config: StationKeepingSettings,
        count: int,
        *,
        tool_m: tuple[float, float] | None,
        by_thrusters: bool,
        threads: int | None = None,
        images: ImageKind | None = None,
    ) -> None:
        """Set up a fleet; its vehicles begin when they are placed.

        Parameters
        ----------
        tool_m
            The point of the body that counts, forward and starboard [m]; None: the camera.
        by_thrusters
            Whether actions are commands of the thrusters.
        threads
            At most so many; None: one per core. A thread has at least `LEAST_PER_THREAD` vehicles,
            or `LEAST_WITH_EYES`.
        images
            What `images` are like; None: there are none.

        Raises
        ------
        ValueError
            The configuration has something that only a single vehicle can have.
        """
        if reason := unsupported(config):
            raise ValueError(reason)
        self.count = count
        self._truth, self._dt = config.tracker == TRUTH, config.control_period_s
        with_eyes = images is not None or not self._truth
        most = max(1, count // (LEAST_WITH_EYES if with_eyes else LEAST_PER_THREAD))
        self._threads = min(threads or len(os.sched_getaffinity(0)), most)
        self._pool = ThreadPoolExecutor(max(1, self._threads - 1), "fleet")
        self.steps_per_level = config.control_steps_per_level
        self.craft: list[Craft | None] = [None] * count
        self.tables: Tables = empty_tables(_sizes(config, count, by_thrusters=by_thrusters))
        self._shared = _shared(config, tool_m, by_thrusters=by_thrusters)
        self._trackers: Trackers | None = None  # those that a compiled loop gives their images
        self._blurred = config.camera_exposure_s > 0.0
        self._images: FleetImages | None = None
        if images is not None:
            self._images = FleetImages(
                count,
                images,
                every=period_steps(config.control_period_s),
                slots=self.tables.progress.images.shape[1],
            )

    def place(
        self,
        i: int,
        craft: Craft,
        *,
        start_s: float,
        trial_level: tuple[int, int],
        start_error: Array,
        camera: Camera | None = None,
    ) -> None:
        """Put a vehicle at the start of a level.

        Parameters
        ----------
        start_s
            Time of the trial at which the level begins.
        start_error : (8,) [px]
            Of the corners that the tracker is given.
        camera
            That of the images, if the fleet has them.
        """
        if self._images is not None and camera is not None:
            self._images.place(i, camera)
        if (old := self.craft[i]) is not None:
            old.close()
        self.craft[i] = craft
        bodies, motion, instruments, controllers, progress, outputs = self.tables
        plant, conditions = craft.plant, craft.conditions
        block, lane = divmod(i, LANES)
        table: Any
        body = (*plant.body, plant.thruster_gains, plant.curve)
        for table, values in zip(bodies, body, strict=True):
            table[block, ..., lane] = _padded(values, table.shape[1:-1])
        motion.state[i] = _padded(plant.state, motion.state.shape[1:])
        motion.gate[block, lane] = math.inf if craft.contact is None else craft.contact.gate_depth
        water = plant.current.water
        motion.law[i], motion.drift[i] = water.law, water.drift
        motion.water[block, :, lane] = [getattr(water, name) for name in WATER_NUMBERS]
        for table, record in zip(instruments.records, craft.sensors.records(), strict=True):
            table[i] = record[0]
        for table, noise in zip(instruments.noises, craft.sensors.noises(), strict=True):
            table[i] = noise
        instruments.keeper[i] = craft.keeper.record[0]
        settings, axes, holds = craft.velocity_controller.records()
        controllers.measured[i] = craft.velocity_controller.measured[0]
        controllers.settings[i], controllers.axes[i] = settings[0], axes
        controllers.holds[i] = holds
        known = craft.velocity_controller.thrusters
        for table, values in zip(controllers.thrusters, known, strict=True):
            table[i] = _padded(values, table.shape[1:])
        controllers.limits[i] = plant.vehicle.curve.limits.value
        controllers.thruster_count[i] = len(plant.vehicle.thrusters)
        progress.step[i], progress.trial_level[i], progress.start_s[i] = 0, trial_level, start_s
        progress.late[i] = conditions.camera_delay_steps, conditions.command_delay_steps
        outputs.diverged[i] = outputs.touching[i] = False
        outputs.contact_n[i], outputs.rows[i], outputs.observation[i] = 0.0, 0.0, 0.0
        outputs.corners[i] = 0.0
        progress.start_error[i] = start_error

    def begin(self, chosen: Flags) -> None:
        """Sense the start of a level with the chosen vehicles, (n,), just placed."""
        self._sense(chosen)

    def step(self, chosen: Flags, actions: Array) -> None:
        """Take the actions, (n, numbers), of the chosen vehicles and simulate a control step.

        Afterwards observations, rows and rewards are those of the new state. A vehicle whose
        simulation diverged keeps its last ones.
        """
        one_by_one = not self._truth and self._trackers is None  # trackers of other libraries
        if one_by_one or (self._truth and self._images is None):
            self._in_threads(step_all, chosen, actions, self._shared, self.tables)
        else:
            fleet = self._shared, self.tables, self._scratch(chosen)
            shown = self._images.shown(copied=True) if self._images else (None, None, None)
            self._in_threads(step_and_see, actions, fleet, self._trackers, *shown)
        touching = chosen & self.tables.outputs.touching
        for i in np.flatnonzero(touching).tolist():
            self._advance_in_contact(i)
        remaining = (chosen if one_by_one else touching) & ~self.tables.outputs.diverged
        if remaining.any():
            self._sense(remaining)

    def _scratch(self, chosen: Flags) -> Scratch:
        return Scratch(
            going=chosen.copy(),
            seeing=np.zeros(self.count, np.bool_),
            motions=np.zeros((self.count, 12)),
            frames=self._first_frames(),
            blurred=self._blurred,
        )

    def _sense(self, chosen: Flags) -> None:
        """Track, sense, and render the images that arrive, with vehicles that have moved."""
        self._track(chosen)
        self._in_threads(sense_all, chosen, self._shared, self.tables)
        if self._images is not None:
            motions, finite = self._motions(chosen & ~self.tables.outputs.diverged)
            present, progress = (motions, self._frames()), self.tables.progress
            self._in_threads(show_all, finite, present, progress, *self._images.shown())

    def telemetry(self, columns: NDArray[np.int64]) -> Array:
        """Return columns (k,) of the vehicles' rows of telemetry, (n, k), in a new array."""
        out = np.empty((self.count, columns.size))
        self._at_once(copy_columns, columns, self.tables.outputs.rows, out)
        return out

    @property
    def images(self) -> FleetImages:
        """The newest images, if the fleet has any; a step replaces them."""
        if self._images is None:
            raise LookupError("this fleet has no images")
        return self._images

    def seen_corners(self) -> Array:
        """Return the corners that have arrived [px], and whether they are valid, (n, 9)."""
        progress = self.tables.progress
        seen = np.maximum(progress.step - progress.late[:, 0], 0) % progress.images.shape[1]
        corners: Array = progress.images[np.arange(self.count), seen]
        return corners

    def _in_threads(self, compiled: Callable[..., None], *arrays: Any) -> None:
        """Call a compiled function for all vehicles, some of them at a time in each thread.

        Whichever thread is done takes the next ones: not all vehicles take equally long, nor all
        processors.
        """
        blocks = self.tables.bodies.net_weight.shape[0]
        count = min(blocks, self._threads * _PARTS_PER_THREAD) if self._threads > 1 else 1
        parts = iter([(blocks * k // count, blocks * (k + 1) // count) for k in range(count)])

        def work() -> None:
            for first, last in parts:
                compiled(first, last, *arrays)

        calls = [self._pool.submit(work) for _ in range(self._threads - 1)]
        work()
        for call in calls:
            call.result()

    def _at_once(self, compiled: Callable[..., None], *arrays: Any) -> None:
        """Call a compiled function for all vehicles that takes no longer than to wake a thread."""
        compiled(0, self.tables.bodies.net_weight.shape[0], *arrays)

    def _track(self, chosen: Flags) -> None:
        """Give each chosen vehicle's tracker its image; nothing if the tracker is the truth."""
        if self._truth:
            return
        motions, chosen = self._motions(chosen)
        frames, outputs = self._frames(), self.tables.outputs
        starting = chosen & (self.tables.progress.step == 0)
        one_by_one = starting if self._trackers else chosen
        for i in np.flatnonzero(one_by_one).tolist():
            tracking = self._world(i).tracking
            seen = motions[i] if self._blurred else motions[i, :6]
            track = tracking.start if starting[i] else tracking.update
            track(seen, int(frames[i]))
            outputs.corners[i], outputs.visible[i] = tracking.corners, tracking.ok
            if starting[i]:
                self._lend_tracker(i)
        if self._trackers and (going := chosen & ~starting).any():
            found = Found(outputs.corners, outputs.visible)
            self._in_threads(track_all, going, motions, frames, self._trackers, found)

    def _world(self, i: int) -> World:
        craft = self.craft[i]
        if not isinstance(craft, World):
            raise LookupError("a vehicle whose tracker is the ground truth has no camera")
        return craft

    def _lend_tracker(self, i: int) -> None:
        """Let the compiled loop have a tracker that has just started, if it can take its like."""
        world = self._world(i)
        sight = world.tracking.sight()
        if sight is None:
            return
        optics, words = world.camera.optics, lend(sight)
        if self._trackers is None:
            self._trackers = Trackers(
                words=np.zeros((self.count, words.size), np.int64),
                like=sight,
                size=(optics.width, optics.height),
                bench_size=0,
            )
        self._trackers.words[i] = words
        needed = max(self._trackers.bench_size, bench_size(sight.memory.levels))
        self._trackers = self._trackers._replace(bench_size=needed)

    def _motions(self, chosen: Flags) -> tuple[Array, Flags]:
        """Return where the chosen vehicles are and how they move, (n, 12), and whose are finite."""
        motions, finite = np.zeros((self.count, 12)), np.zeros(self.count, np.bool_)
        states = self.tables.motion.state
        self._at_once(motions_of, chosen, states, self._blurred, motions, finite)
        return motions, finite

    def _frames(self) -> Integers:
        """Return the numbers of the present images, (n,), since the trials began."""
        return self._first_frames() + self.tables.progress.step

    def _first_frames(self) -> Integers:
        """Return the numbers of the images at the beginning of the levels, (n,)."""
        return np.rint(self.tables.progress.start_s / self._dt).astype(np.int64)

    def picture(self, i: int) -> NDArray[np.uint8]:
        """Return what the camera of a vehicle sees, (H, W, 3) blue, green, red.

        Raises
        ------
        LookupError
            The vehicle has no camera: its tracker is the ground truth.
        """
        camera, pose = self._world(i).camera, np.zeros(6)
        read_pose(self.tables.motion.state[i], pose)
        motion = np.concatenate([pose, self.tables.motion.state[i, 7:13]])
        return camera.colour(motion, int(self._frames()[i]))

    def _advance_in_contact(self, i: int) -> None:
        """Repeat a control step of a vehicle that may touch something with its own plant."""
        craft, motion, outputs = self.craft[i], self.tables.motion, self.tables.outputs
        if craft is None:
            raise RuntimeError("a vehicle that was never placed cannot touch anything")
        plant, steps = craft.plant, self._shared.physics_steps
        size, thrusters = len(plant.state), len(plant.vehicle.thrusters)
        plant.state[:] = motion.state[i, :size]  # still that before the step
        first = (int(self.tables.progress.step[i]) - 1) * steps
        plant.advance(first, motion.command[i, :thrusters].copy(), steps)
        motion.state[i, :size] = plant.state
        outputs.contact_n[i], outputs.touching[i] = plant.contact_force(), False

    def close(self) -> None:
        """Release what the vehicles hold."""
        for craft in self.craft:
            if craft is not None:
                craft.close()
        self.craft = [None] * self.count
        self._pool.shutdown()


def _padded(values: Any, shape: tuple[int, ...]) -> Any:
    """Return values at the beginning of an array of zeros of this shape."""
    if np.shape(values) == shape:
        return values
    array = np.zeros(shape)
    array[tuple(slice(length) for length in np.shape(values))] = values
    return array


def _sizes(config: StationKeepingSettings, count: int, *, by_thrusters: bool) -> Sizes:
    thrusters = max(len(load(name).thrusters) for name in config.vehicles())
    slots = [1 + getattr(config, f"{what}_delay_steps", 0) for what in ("camera", "command")]
    return Sizes(
        vehicles=count,
        thrusters=thrusters,
        command=thrusters if by_thrusters else COMMAND_NUMBERS,
        image_slots=slots[0],
        command_slots=slots[1],
        drift=_drift_shape(config),
        readings=readings_of(config),
    )


def _drift_shape(config: StationKeepingSettings) -> tuple[int, int]:
    """Return the shape of `current.Water.drift`, the same for all levels and trials."""
    if config.is_tabulated():
        return ROWS, table_points(config.level_duration_s)
    return 2, grid_points(config.level_duration_s)


def _shared(
    config: StationKeepingSettings, tool_m: tuple[float, float] | None, *, by_thrusters: bool
) -> Shared:
    target, optics = target_and_optics(config)
    station = start_pose(optics, target, config.altitude_m)
    mount = np.array(optics.mount_m)
    aim = goal(load(config.vehicles()[0]), station, optics.mount_m, tool_m)
    points = [target.top_corners(), target.top_centre()[None], target.origin()[None]]
    return Shared(
        physics_steps=config.physics_steps_per_control_step,
        physics_step_s=config.physics_step_s,
        dt=config.control_period_s,
        below_camera=target.height_m + optics.mount_m[2],
        bottom_m=float(target.seabed_m),
        width_px=float(optics.width),
        height_px=float(optics.height),
        target_view=TargetView(
            points=np.concatenate(points),
            intrinsics=optics.intrinsics(),
            mount=mount,
            target=BOX_CENTRE if config.target_truth == "uwsim" else TOP_CENTRE,
        ),
        station=_camera_position(station, mount),
        goal=aim.kind,
        tool=aim.tool,
        tool_station=aim.station,
        by_thrusters=by_thrusters,
        truth=config.tracker == TRUTH,
    )


def _camera_position(pose: Array, mount: Array) -> Array:
    rotation, position = np.empty((3, 3)), np.empty(3)
    camera_pose(pose, mount, rotation, position)
    return position
