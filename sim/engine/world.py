"""The world of one level, built from configuration, conditions and random streams alone."""

import math
from dataclasses import dataclass, fields, replace
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from seamark.sim.camera.arm_camera import ON_ARM, ArmCamera
from seamark.sim.camera.bottom.painter import Tiles
from seamark.sim.camera.camera import Camera
from seamark.sim.camera.effects import Effects
from seamark.sim.camera.optics import MOUNT_M, Optics
from seamark.sim.camera.pipe_camera import PipeCamera
from seamark.sim.camera.standing_camera import StandingCamera
from seamark.sim.camera.target import Target, start_pose
from seamark.sim.camera.water import JERLOV, Water
from seamark.sim.control.observation import (
    ARM_CAMERA,
    SONAR,
    VEHICLE_CAMERA,
    ArmSize,
    arm_size,
)
from seamark.sim.control.station_keeper import Geometry, StationKeeper
from seamark.sim.control.velocity_controller import VelocityController
from seamark.sim.detectors import Detector
from seamark.sim.engine.dock_in_loop import Dock
from seamark.sim.engine.perception import SensorNoises, SensorRecords
from seamark.sim.engine.pipe_in_loop import PipeInLoop
from seamark.sim.engine.route_in_loop import Course
from seamark.sim.engine.search_in_loop import SearchInLoop
from seamark.sim.engine.tracker_in_loop import TrackerInLoop, Untracked, draw_start_error
from seamark.sim.engine.tracking_error import BOX_CENTRE, TOP_CENTRE
from seamark.sim.engine.trial_conditions import NOMINAL, TrialConditions
from seamark.sim.engine.vehicle_sonar import VehicleSonar, build_sonar
from seamark.sim.multibody.assembly import Mounting, fixed_box
from seamark.sim.multibody.hull import Hull
from seamark.sim.multibody.plant import ArmedPlant
from seamark.sim.multibody.workpiece import Workpiece
from seamark.sim.numerics.libm import PI, sincos
from seamark.sim.numerics.random_streams import Streams
from seamark.sim.physics import constants
from seamark.sim.physics.bullet import BulletEngine
from seamark.sim.physics.contact import Contact, MakeEngine, TargetBox
from seamark.sim.physics.current import Current
from seamark.sim.physics.pipe import Pipe
from seamark.sim.physics.plant import Plant
from seamark.sim.physics.terrain import Bottom, Relief, draw_relief
from seamark.sim.physics.thruster_faults import ThrusterFault
from seamark.sim.sensors.ahrs import Ahrs
from seamark.sim.sensors.altimeter import Altimeter
from seamark.sim.sensors.arm import ArmSensors
from seamark.sim.sensors.depth import DepthGauge
from seamark.sim.sensors.dvl import Dvl
from seamark.sim.settings.arm import ArmSettings
from seamark.sim.settings.experiment import ExperimentSettings
from seamark.sim.settings.search import FindingSettings
from seamark.sim.sonar.device import Device
from seamark.sim.trackers import Tracker
from seamark.sim.vehicles import Vehicle, load
from seamark.sim.vehicles.linkage import Linkage
from seamark.sim.vehicles.variation import varied


@dataclass(slots=True, kw_only=True)
class Sensors:
    """The sensors of the vehicle, each with its own stream."""

    dvl: Dvl
    depth: DepthGauge
    ahrs: Ahrs
    altimeter: Altimeter

    def records(self) -> SensorRecords:
        """Return their records, for compiled code."""
        return SensorRecords(
            self.dvl.record, self.depth.record, self.ahrs.record, self.altimeter.record
        )

    def noises(self) -> SensorNoises:
        """Return the noise of their readings, for compiled code."""
        return SensorNoises(self.dvl.noise, self.depth.noise, self.ahrs.noise, self.altimeter.noise)


@dataclass(frozen=True, slots=True, kw_only=True)
class Arm:
    """The arm of a vehicle: the plant that moves both, and its sensors."""

    plant: ArmedPlant
    sensors: ArmSensors
    size: ArmSize


@dataclass(frozen=True, slots=True, kw_only=True)
class Conditions:
    """What makes up a level besides the configuration."""

    current: Current
    water: Water
    reference: Water | None = None  # of the image from which the tracker learns the target
    trial: TrialConditions = NOMINAL
    # [m] forward and starboard of the body's origin: what counts instead of the vehicle's pose
    tool_m: tuple[float, float] | None = None
    target: Target | None = None  # instead of the one of the settings
    workpiece: Workpiece | None = None  # what an arm works on; its face is the target
    bottom: Tiles | None = None  # a painted seabed instead of the plain one
    told_error_m: tuple[float, float] = (0.0, 0.0)  # north, east, of where the target is said to be
    encoder_bias: tuple[float, ...] = (0.0,)  # [rad] of each joint's, or of all
    course: Course | None = None  # what is to be followed
    dock: Dock | None = None  # what is to be entered
    start_above_m: float = 0.0  # of the start above its station


@dataclass(slots=True, kw_only=True)
class Craft:
    """The vehicle of one level with its sensors and controllers, without the camera's images."""

    config: ExperimentSettings
    station: NDArray[np.float64]  # (6,) pose [m, rad] that the camera should keep
    start: NDArray[np.float64]  # (6,) pose [m, rad]
    conditions: TrialConditions
    tool_m: tuple[float, float] | None
    target: Target
    told_m: NDArray[np.float64]  # (2,) north and east of the start: where the target is said to be
    optics: Optics
    plant: Plant
    sensors: Sensors
    keeper: StationKeeper
    velocity_controller: VelocityController
    bottom: Bottom
    contact: Contact | None
    arm: Arm | None
    course: Course | None
    dock: Dock | None

    def close(self) -> None:
        """Release what the contact engine holds."""
        if self.contact is not None:
            self.contact.close()


@dataclass(slots=True, kw_only=True)
class World(Craft):
    """Everything that moves or measures during one level."""

    camera: Camera
    tracking: Untracked
    sonar: VehicleSonar | None


def target_and_optics(config: ExperimentSettings) -> tuple[Target, Optics]:
    """Return the target and the camera's optics."""
    optics = Optics(
        width=config.camera_width_px,
        height=config.camera_height_px,
        focal_px=config.camera_focal_px,
        mount_m=config.camera_mount_m() or MOUNT_M,
    )
    box = config.target_shape()
    target = Target(
        length_m=box.length_m,
        width_m=box.width_m,
        height_m=box.height_m,
        lettered=box.lettered,
    )
    return target, optics


def program_optics(config: ExperimentSettings) -> dict[str, Optics | Device]:
    """Return each camera whose images a program is given, in their order; also the sonar."""
    _target, optics = target_and_optics(config)
    known: dict[str, Optics | Device] = {VEHICLE_CAMERA: optics, ARM_CAMERA: ON_ARM}
    if device := config.sonar_device():
        known[SONAR] = device
    return {camera: known[camera] for camera in config.cameras_of_program()}


def build_camera(  # noqa: PLR0913  # one for each thing that may be in view
    config: ExperimentSettings,
    water: Water,
    *,
    noise_seed: int,
    optics: Optics | None = None,
    target: Target | None = None,
    workpiece: Workpiece | None = None,
    bottom: Tiles | None = None,
    pipe: Pipe | None = None,
    dock: Dock | None = None,
) -> Camera:
    """Return the camera above the target: the part of a world that renders images.

    `optics` and `target` are used instead of those of the settings; `workpiece` is what the arm
    works on, and `bottom` the seabed that a camera beside an arm sees, if it is not the plain one;
    `pipe` is what lies on the bottom where one is followed, `dock` what stands around the target.
    """
    configured, usual = target_and_optics(config)
    target, optics = target or configured, optics or usual
    arm, effects = config.chosen_arm(), _effects(config)
    if pipe is not None:
        return PipeCamera(optics, water, target, pipe, noise_seed=noise_seed)
    vehicle = load(config.vehicle)
    if dock is not None:
        return StandingCamera(
            *(optics, water, target, dock.things, vehicle),
            noise_seed=noise_seed,
            effects=effects,
        )
    if arm is None:
        return Camera(optics, water, target, noise_seed=noise_seed, effects=effects)
    carried = vehicle, _mounted(arm, vehicle)
    return ArmCamera(
        *(optics, water, target, carried),
        workpiece=workpiece,
        noise_seed=noise_seed,
        effects=effects,
        bottom=bottom,
    )


def _mounted(arm: Linkage, vehicle: Vehicle) -> Mounting:
    return Mounting(linkage=arm, place=vehicle.mounts[arm.name], on_vehicle=True)


def _effects(config: ExperimentSettings) -> Effects:
    return Effects(
        exposure_s=config.camera_exposure_s,
        light_level=config.light_level,
        caustics=config.caustics,
        lamp=config.lamp,
        lamp_cone_rad=config.lamp_cone_rad,
        snow_per_m3=config.snow_per_m3,
        scatter_rad=1e-3 * config.scatter_mrad,
        fish_per_min=config.fish_per_min,
        fish_length_m=config.fish_length_m,
        frame_s=config.control_period_s,
    )


def draw_noise_seed(random: Streams) -> int:
    """Return the seed of a level's image noise: the first number of its stream."""
    return int(random.camera.integers(2**63))


def build_world(
    config: ExperimentSettings,
    conditions: Conditions,
    random: Streams,
    *,
    tracker: Tracker | None = None,
    detector: Detector | None = None,
) -> World:
    """Return the world of one level, with the vehicle at its start.

    Parameters
    ----------
    tracker
        Used instead of the configured one.
    detector
        Likewise, where the target has to be found first.
    """
    craft = build_craft(config, conditions, random)
    noise_seed = draw_noise_seed(random)

    def camera_in(water: Water) -> Camera:
        return build_camera(
            config,
            water,
            noise_seed=noise_seed,
            target=conditions.target,
            workpiece=conditions.workpiece,
            bottom=conditions.bottom,
            pipe=None if conditions.course is None else conditions.course.pipe,
            dock=conditions.dock,
        )

    camera = camera_in(conditions.water)
    reference = None if conditions.reference is None else camera_in(conditions.reference)
    tracking: Untracked
    if isinstance(camera, PipeCamera):
        altitude_m, step_s = config.altitude_m, config.control_period_s
        tracking = PipeInLoop(camera, altitude_m=altitude_m, step_s=step_s)
    elif craft.course is not None:
        tracking = Untracked(camera)
    elif isinstance(config, FindingSettings):
        tracking = SearchInLoop(camera, config, tracker=tracker, detector=detector)
    else:
        tracking = build_tracking(config, camera, random, tracker=tracker, reference=reference)
    parts = {part.name: getattr(craft, part.name) for part in fields(Craft)}
    sonar = build_sonar(config, camera, random)
    return World(**parts, camera=camera, tracking=tracking, sonar=sonar)


def build_craft(config: ExperimentSettings, conditions: Conditions, random: Streams) -> Craft:
    """Return the vehicle of one level at its start, without its camera."""
    target, optics = target_and_optics(config)
    target = conditions.target or target
    station, trial = start_pose(optics, target, config.altitude_m), conditions.trial
    start = _start(optics, station, trial)
    start[2] -= conditions.start_above_m
    nominal = load(config.vehicle)  # all that the velocity controller knows
    vehicle = varied(nominal, trial.vehicle)
    centre = (target.north_m, target.east_m)
    bottom = Bottom(target.seabed_m, _relief(config, random), centre=centre)
    moved = _Moved(vehicle, conditions, bottom, target)
    arm = _arm(config, moved, random)
    plant, contact = (arm.plant, None) if arm else _plant(config, moved)
    plant.reset(start)
    return Craft(
        config=config,
        station=station,
        start=start,
        conditions=trial,
        tool_m=conditions.tool_m,
        target=target,
        told_m=target.top_centre()[:2] - start[:2] + conditions.told_error_m,
        optics=optics,
        plant=plant,
        sensors=_sensors(config, trial, random),
        keeper=StationKeeper(
            Geometry(
                focal_px=optics.focal_px,
                centre_px=optics.principal_px,
                height_m=config.altitude_m,
                size_m=(target.length_m, target.width_m),
            ),
            range_from=config.range_from,
            level_out_tilt=config.level_out_tilt,
        ),
        velocity_controller=VelocityController(nominal, config),
        bottom=bottom,
        contact=contact,
        arm=arm,
        course=conditions.course,
        dock=conditions.dock,
    )


class _Moved(NamedTuple):
    """What a plant moves, and where."""

    vehicle: Vehicle
    conditions: Conditions
    bottom: Bottom
    target: Target


def _plant(config: ExperimentSettings, moved: _Moved) -> tuple[Plant, Contact | None]:
    """Return the plant of a vehicle without an arm."""
    contact = _contact(config, moved) if config.contact else None
    plant = Plant(
        moved.vehicle,
        moved.conditions.current,
        step_s=config.physics_step_s,
        contact=contact,
        fault=_fault(config),
        thruster_gains=moved.conditions.trial.thruster_gains,
    )
    return plant, contact


def _arm(config: ExperimentSettings, moved: _Moved, random: Streams) -> Arm | None:
    """Return the arm of the vehicle, if it has one, and the plant that moves both."""
    linkage, conditions = config.chosen_arm(), moved.conditions
    if linkage is None or not isinstance(config, ArmSettings):
        return None
    mountings = [_mounted(linkage, moved.vehicle)]
    if config.contact and conditions.workpiece is None:
        mountings.append(fixed_box(_box(moved.target)))
    plant = ArmedPlant(
        moved.vehicle,
        mountings,
        moved.conditions.current,
        moved.bottom if config.contact else None,
        step_s=config.physics_step_s,
        fault=_fault(config),
        thruster_gains=conditions.trial.thruster_gains,
        workpiece=conditions.workpiece,
    )
    efforts = [link.joint.effort for link in linkage.links]
    sensors = ArmSensors(
        random.arm,
        readings=config.control_steps_per_level + 1,  # the state in which the level ends, too
        efforts=np.array([effort.scalar for effort in efforts if effort]),
        scale=config.arm_noise,
        encoder_bias=np.array(conditions.encoder_bias),
    )
    return Arm(plant=plant, sensors=sensors, size=arm_size(linkage))


def build_tracking(
    config: ExperimentSettings,
    camera: Camera,
    random: Streams,
    *,
    tracker: Tracker | None = None,
    reference: Camera | None = None,
) -> TrackerInLoop:
    """Return the given or else the configured tracker in the loop, with its start error."""
    error = draw_start_error(config.start_error_px, random)
    target = BOX_CENTRE if config.target_truth == "uwsim" else TOP_CENTRE
    return TrackerInLoop(camera, config, error, tracker=tracker, reference=reference, target=target)


def _start(
    optics: Optics, station: NDArray[np.float64], trial: TrialConditions
) -> NDArray[np.float64]:
    """Return the pose (6,) at the start of a level; the camera is off its station by the offset."""
    heading = station[5] + trial.start_heading_rad
    x, y, _z = optics.mount_m
    before, after = sincos(station[5]), sincos(heading)
    turn_s, turn_c = before[0] - after[0], before[1] - after[1]
    start = station.copy()
    start[0] += trial.start_offset_m[0] + (turn_c * x - turn_s * y)
    start[1] += trial.start_offset_m[1] + (turn_s * x + turn_c * y)
    start[5] = heading
    return start


def _relief(config: ExperimentSettings, random: Streams) -> Relief | None:
    if not config.seabed_relief_m:
        return None
    return draw_relief(
        random.bottom, height_m=config.seabed_relief_m, flat_m=config.seabed_flat_radius_m
    )


def configured_water(config: ExperimentSettings) -> Water:
    """Return the water of a configuration."""
    if config.water_type == "grey":
        water = Water.grey(config.water_attenuation_1_m, law=config.water_law)
    else:
        grey = Water.grey(0.0, law=config.water_law)  # for the veil of this law
        water = replace(grey, attenuation=JERLOV[config.water_type])
    return replace(water, read_sigma_grey=config.camera_noise_grey)


def _periods(config: ExperimentSettings) -> tuple[int, int]:
    """Return the physics steps between two readings: of depth or altitude, and of the AHRS."""
    slow, fast = (
        max(1, round(period.scalar / config.physics_step_s))
        for period in (constants.DEPTH_PERIOD_S, constants.AHRS_PERIOD_S)
    )
    return slow, fast


def readings_of(config: ExperimentSettings) -> tuple[int, int, int, int]:
    """Return how many readings a level has: of DVL, depth gauge, AHRS and altimeter."""
    steps = config.control_steps_per_level * config.physics_steps_per_control_step
    slow, fast = _periods(config)
    few = steps // slow + 1
    return steps // config.dvl_period_steps + 1, few, steps // fast + 1, few


def _sensors(config: ExperimentSettings, trial: TrialConditions, random: Streams) -> Sensors:
    slow, fast = _periods(config)
    velocities, few, many, _few = readings_of(config)
    u, v, w = (config.dvl_bias_m_s + bias for bias in trial.dvl_bias_m_s)
    return Sensors(
        dvl=Dvl(
            random.dvl,
            readings=velocities,
            period_steps=config.dvl_period_steps,
            sigma=config.dvl_sigma_m_s,
            bias=(u, v, w),
            scale_error=config.dvl_scale_error,
            dropout=config.dvl_dropout,
            least_altitude_m=config.dvl_least_altitude_m,
        ),
        depth=DepthGauge(random.depth, readings=few, period_steps=slow, sigma=config.depth_sigma_m),
        ahrs=Ahrs(
            random.ahrs,
            readings=many,
            period_steps=fast,
            sigma=config.ahrs_sigma_rad,
            bias=trial.ahrs_bias_rad,
        ),
        altimeter=Altimeter(random.altimeter, readings=few, period_steps=slow),
    )


def _contact(config: ExperimentSettings, moved: _Moved) -> Contact:
    """Return the contacts with the bottom and the target."""
    engine: MakeEngine = BulletEngine if config.contacts == "pybullet" else Hull
    dock, top_m = moved.conditions.dock, math.inf
    if dock is not None:
        engine, top_m = partial(Hull, things=dock.things), dock.top_m
    return Contact(moved.vehicle, moved.bottom, box=_box(moved.target), engine=engine, top_m=top_m)


def _box(target: Target) -> TargetBox:
    """Return the target, which cannot be pushed away.

    An image is a function of the vehicle's pose alone, so the box stays where it is rendered.
    """
    north, east, down = target.origin().tolist()
    return TargetBox(
        centre=(north, east, down),
        yaw=target.heading_rad + 0.5 * PI,  # the length lies across the heading
        size=(target.length_m, target.width_m, target.height_m),
        fixed=True,
    )


def _fault(config: ExperimentSettings) -> ThrusterFault | None:
    if config.fault_thruster < 0:
        return None
    return ThrusterFault(
        thruster=config.fault_thruster,
        efficiency=config.fault_efficiency,
        delay_steps=round(config.fault_delay_s / config.physics_step_s),
        from_step=round(config.fault_from_s / config.physics_step_s),
    )
