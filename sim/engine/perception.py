"""Perception of one control step in one compiled call: tracking error, sensors, position error.

It fills the row of telemetry, the program's observation and the measurements of the velocity
controller. In Python this took as long as rendering the image.
"""

from typing import NamedTuple

from numba import njit

from seamark.sim.control.observation import STARTS
from seamark.sim.control.station_keeper import update_position_error
from seamark.sim.control.velocity_law import Records
from seamark.sim.engine.delay import RESULT, arriving
from seamark.sim.engine.tracking_error import TargetView, write_tracking_error
from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.borrowed import borrowed
from seamark.sim.physics.current import Water
from seamark.sim.physics.dynamics import RIGID, write_current
from seamark.sim.physics.terrain import Mounds, sounding
from seamark.sim.recording.telemetry import (
    ARM_WIDTH,
    COMMON_THRUSTERS,
    DETECTION_WIDTH,
    DOCK_THRUSTERS,
    DOCK_WIDTH,
    INDEX,
    ROUTE_WIDTH,
    SEARCH_WIDTH,
    WIDTH,
    WORK_WIDTH,
)
from seamark.sim.sensors.ahrs import sample_attitude
from seamark.sim.sensors.altimeter import sample_altitude
from seamark.sim.sensors.depth import sample_depth
from seamark.sim.sensors.dvl import sample_dvl
from seamark.sim.sensors.sensor import Record

_TRIAL, _LEVEL, _T = INDEX["trial"], INDEX["level"], INDEX["t"]
_POSE, _VELOCITY, _CURRENT = INDEX["x"], INDEX["u"], INDEX["current_x"]
_ERROR, _DVL, _THRUST = INDEX["error_x"], INDEX["dvl_u"], INDEX["thrust_0"]
_CONTACT = INDEX["contact_n"]

_SEEN_T, _SEEN_DT = STARTS["t"], STARTS["dt"]
_SEEN_ERROR, _SEEN_ERROR_PX = STARTS["error"], STARTS["error_px"]
_SEEN_VISIBLE, _SEEN_AGE = STARTS["target_visible"], STARTS["target_age"]
_SEEN_VELOCITY, _SEEN_VALID = STARTS["velocity"], STARTS["velocity_valid"]
_SEEN_DEPTH, _SEEN_ALTITUDE = STARTS["depth"], STARTS["altitude"]
_SEEN_ATTITUDE, _SEEN_THRUST = STARTS["attitude"], STARTS["thrust"]


class StepInputs(NamedTuple):
    """The scalars that change from step to step."""

    step: int  # physics steps since the level began
    t: float  # [s] since the trial began
    ok: bool  # whether the tracker has the target now
    seen: bool  # whether it had it in the image that the station keeper gets now
    altitude: float  # [m] of the body's origin above the bottom
    echoes: int  # of the DVL's beams
    contact_n: float  # [N]


class LevelConstants(NamedTuple):
    """The scalars that are constant over a level."""

    trial: int
    level: int
    physics_step_s: float
    dt: float  # [s] control period
    below_camera: float  # [m] altitude at which the camera would touch the target


class Tracked(NamedTuple):
    """Where the target is and where the tracker has it."""

    target_view: TargetView
    station: Array  # (3,) [m] where the camera should be
    corners: Array  # (8,) [px] by the tracker, in this image
    seen_corners: Array  # (8,) [px] in the image that the station keeper gets now


class Moving(NamedTuple):
    """The vehicle and the water around it."""

    state: Array  # (13 + n,), see `plant.Plant`
    pose: Array  # (6,) [m, rad]
    water: Water


class SensorRecords(NamedTuple):
    """The sensors' records, (1,) each, which are updated."""

    dvl: Records
    depth: Records
    ahrs: Records
    altimeter: Records


class SensorNoises(NamedTuple):
    """The noise of the sensors' readings, (readings, values)."""

    dvl: Array
    depth: Array
    ahrs: Array
    altimeter: Array


class Senses(NamedTuple):
    """All that a vehicle perceives with over one level."""

    physics_steps: int  # per control step
    constants: LevelConstants
    results: Array  # of the tracker, (late + 1, RESULT), see `delay.arriving`
    tracked: Tracked
    moving: Moving
    ground: Mounds
    relief: bool  # whether it has mounds
    sensors: SensorRecords
    noises: SensorNoises
    keepers: Records  # (1,) of the station keeper
    observation: Array
    measured: Records  # (1,) of the velocity controller


class StepOutputs(NamedTuple):
    """What perception writes."""

    row: Array  # of telemetry, except for the program's reference and step time, and an arm
    observation: Array  # of the program, except for an arm
    measured: Records  # (1,) of the velocity controller


@njit(cache=True, error_model="numpy")
def perceive(
    inputs: StepInputs,
    constants: LevelConstants,
    tracked: Tracked,
    moving: Moving,
    sensors: SensorRecords,
    noises: SensorNoises,
    keepers: Records,
    outputs: StepOutputs,
) -> None:
    """Sample all sensors, update the position error, and write the outputs.

    `keepers` is the record of the station keeper, (1,), which is updated.
    """
    tracked, moving, outputs = borrowed(tracked), borrowed(moving), borrowed(outputs)
    sensors, noises, keepers = borrowed(sensors), borrowed(noises), borrowed(keepers)
    state, pose = moving.state, moving.pose
    row, observation = outputs.row, outputs.observation
    velocity, sounding = state[7:13], (inputs.altitude, inputs.echoes)
    dvl, depth, attitude, altitude = (
        sensors.dvl[0],
        sensors.depth[0],
        sensors.ahrs[0],
        sensors.altimeter[0],
    )
    sample_dvl(dvl, noises.dvl, inputs.step, pose, velocity, sounding)
    sample_depth(depth, noises.depth, inputs.step, pose)
    sample_attitude(attitude, noises.ahrs, inputs.step, pose, velocity)
    sample_altitude(altitude, noises.altimeter, inputs.step, pose, sounding)

    height = altitude.values[0] - constants.below_camera
    tilt = (attitude.values[0], attitude.values[1])
    update_position_error(keepers[0], tracked.seen_corners, inputs.seen, height, tilt, constants.dt)

    write_tracking_error(
        pose, tracked.corners, inputs.ok, tracked.target_view, tracked.station, row
    )
    time_s = inputs.step * constants.physics_step_s
    write_current(time_s, moving.water, state, row[_CURRENT : _CURRENT + 3])
    _record_time_and_contact(inputs, constants, row)
    _record_motion(pose, state, row)
    for i in range(3):
        row[_ERROR + i], row[_DVL + i] = keepers[0].error[i], dvl.values[i]
    _fill_measured(inputs.step, dvl, depth, attitude, outputs.measured[0])
    observation[_SEEN_T], observation[_SEEN_DT] = inputs.t, constants.dt
    _observe_position_error(keepers[0], observation)
    _observe_sensors(dvl, depth, attitude, altitude, observation)
    for i in range(state.size - RIGID):
        observation[_SEEN_THRUST + i] = state[RIGID + i]


@njit(cache=True, error_model="numpy")
def perceive_with(
    senses: Senses, step: int, t: float, ok: bool, contact_n: float, row: Array
) -> bool:
    """Perceive a control step; return whether the image that has arrived shows the target.

    Parameters
    ----------
    step
        Control steps since the level began; the others are as in `StepInputs`.
    """
    tracked, pose = senses.tracked, senses.moving.pose
    late = senses.results.shape[0] - 1
    arrived = arriving(senses.results, step, late, tracked.corners, ok)
    for i in range(tracked.seen_corners.size):
        tracked.seen_corners[i] = arrived[i]
    seen: bool = arrived[RESULT - 1] != 0.0
    altitude, echoes = senses.ground.depth - pose[2], 4
    if senses.relief:
        altitude, echoes = sounding(pose, senses.ground)
    perceive(
        StepInputs(
            step=step * senses.physics_steps,
            t=t,
            ok=ok,
            seen=seen,
            altitude=altitude,
            echoes=echoes,
            contact_n=contact_n,
        ),
        senses.constants,
        tracked,
        senses.moving,
        senses.sensors,
        senses.noises,
        senses.keepers,
        StepOutputs(row, senses.observation, senses.measured),
    )
    return seen


@njit(cache=True, error_model="numpy")
def _record_time_and_contact(inputs: StepInputs, constants: LevelConstants, row: Array) -> None:
    row[_TRIAL], row[_LEVEL], row[_T] = constants.trial, constants.level, inputs.t
    row[_CONTACT] = inputs.contact_n


@njit(cache=True, error_model="numpy")
def _record_motion(pose: Array, state: Array, row: Array) -> None:
    """Write pose, velocity and thrusts to the row."""
    for i in range(6):
        row[_POSE + i], row[_VELOCITY + i] = pose[i], state[7 + i]
    row[_THRUST : _THRUST + COMMON_THRUSTERS] = 0.0
    for i in range(state.size - RIGID):
        row[thrust_column(i, row.size)] = state[RIGID + i]


@njit(cache=True, error_model="numpy", inline="always")
def thrust_column(thruster: int, width: int) -> int:
    """Return where a row of this width has the thrust of a thruster; see `telemetry.columns`."""
    if thruster < COMMON_THRUSTERS:
        return _THRUST + thruster
    detections = DETECTION_WIDTH if width >= WIDTH + DETECTION_WIDTH else 0
    first = WIDTH if width - detections < WIDTH + ARM_WIDTH else WIDTH + ARM_WIDTH
    docks = WIDTH + DOCK_WIDTH + DOCK_THRUSTERS - COMMON_THRUSTERS
    if WIDTH + ROUTE_WIDTH <= width - detections < docks:
        first += ROUTE_WIDTH
    if docks <= width - detections < WIDTH + ARM_WIDTH:
        first += DOCK_WIDTH
    if width - detections >= WIDTH + ARM_WIDTH + WORK_WIDTH:
        first += WORK_WIDTH
    if width - detections >= WIDTH + ARM_WIDTH + WORK_WIDTH + SEARCH_WIDTH:
        first += SEARCH_WIDTH
    first += detections
    return first + thruster - COMMON_THRUSTERS


@njit(cache=True, error_model="numpy")
def _fill_measured(
    step: int, dvl: Record, depth: Record, attitude: Record, measured: Record
) -> None:
    """Fill the record of the velocity controller, `velocity_law.MEASURED`."""
    for i in range(3):
        measured.velocity[i] = dvl.values[i]
    measured.depth = depth.values[0]
    measured.yaw, measured.yaw_rate = attitude.values[2], attitude.values[5]
    measured.fresh = dvl.valid and dvl.measured_at == step
    for i in range(2):
        measured.tilt[i], measured.tilt_rates[i] = attitude.values[i], attitude.values[3 + i]


@njit(cache=True, error_model="numpy")
def _observe_position_error(keeper: Record, observation: Array) -> None:
    for i in range(3):
        observation[_SEEN_ERROR + i] = keeper.error[i]
    for i in range(2):
        observation[_SEEN_ERROR_PX + i] = keeper.error_px[i]
    observation[_SEEN_VISIBLE], observation[_SEEN_AGE] = keeper.visible, keeper.age_s


@njit(cache=True, error_model="numpy")
def _observe_sensors(
    dvl: Record, depth: Record, attitude: Record, altitude: Record, observation: Array
) -> None:
    for i in range(3):
        observation[_SEEN_VELOCITY + i] = dvl.values[i]
    observation[_SEEN_VALID] = dvl.valid
    observation[_SEEN_DEPTH], observation[_SEEN_ALTITUDE] = depth.values[0], altitude.values[0]
    for i in range(6):
        observation[_SEEN_ATTITUDE + i] = attitude.values[i]
