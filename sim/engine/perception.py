"""Perception of one control step in one compiled call: tracking error, sensors, position error.

It fills the row of telemetry, the program's observation and the measurements of the velocity
controller. In Python this took as long as rendering the image.
"""

from typing import Any, NamedTuple

from numba import njit

from seamark.sim.control.observation import STARTS
from seamark.sim.control.station_keeper import update_position_error
from seamark.sim.control.velocity_law import Records
from seamark.sim.engine.tracking_error import View, write_tracking_error
from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.borrowed import borrowed
from seamark.sim.physics.dynamics import RIGID, write_current
from seamark.sim.recording.telemetry import COMMON_THRUSTERS, INDEX, WIDTH
from seamark.sim.sensors.ahrs import sample_attitude
from seamark.sim.sensors.altimeter import sample_altitude
from seamark.sim.sensors.depth import sample_depth
from seamark.sim.sensors.dvl import sample_dvl
from seamark.sim.sensors.sensor import Record

# Of DVL, depth gauge, AHRS and altimeter: their records, (1,) each, and their noise.
SensorRecords = tuple[Records, Records, Records, Records]
SensorNoises = tuple[Array, Array, Array, Array]

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
    """The scalars that change from step to step; passed in this order, as a plain tuple."""

    step: int  # physics steps since the level began
    t: float  # [s] since the trial began
    ok: bool  # whether the tracker has the target now
    seen: bool  # whether it had it in the image that the station keeper gets now
    altitude: float  # [m] of the body's origin above the bottom
    echoes: int  # of the DVL's beams
    contact_n: float  # [N]


class LevelConstants(NamedTuple):
    """The scalars that are constant over a level; passed in this order, as a plain tuple."""

    trial: int
    level: int
    physics_step_s: float
    dt: float  # [s] control period
    below_camera: float  # [m] altitude at which the camera would touch the target


@njit(cache=True, error_model="numpy")
def perceive(
    plain_inputs: tuple[Any, ...],
    plain_constants: tuple[Any, ...],
    tracked: tuple[View, Array, Array, Array],
    plant: tuple[Array, Array, tuple[Any, ...]],
    sensors: SensorRecords,
    noises: SensorNoises,
    keepers: Records,
    outputs: tuple[Array, Array, Records],
) -> None:
    """Sample all sensors, update the position error, and write the outputs.

    Parameters
    ----------
    plain_inputs, plain_constants
        `StepInputs` and `LevelConstants`.
    tracked
        `tracking_error.View`; the station (3,) [m]; the tracker's corners (8,) [px] in this image,
        and in the image that the station keeper gets now.
    plant
        Its state (13 + n,), pose (6,), the water as a plain tuple.
    sensors, noises
        The records, which are updated, and the noise of the readings.
    keepers
        (1,) record of the station keeper, updated.
    outputs
        The row of telemetry, written except for the program's reference and step time; the
        observation; the measurements of the velocity controller, (1,) record.
    """
    inputs, constants = StepInputs(*plain_inputs), LevelConstants(*plain_constants)
    view, station, corners, seen_corners = borrowed(tracked)
    state, pose, water = borrowed(plant)
    row, observation, measured = borrowed(outputs)
    sensors, noises, keepers = borrowed(sensors), borrowed(noises), borrowed(keepers)
    velocity, sounding = state[7:13], (inputs.altitude, inputs.echoes)
    dvl, depth, attitude, altitude = sensors[0][0], sensors[1][0], sensors[2][0], sensors[3][0]
    sample_dvl(dvl, noises[0], inputs.step, pose, velocity, sounding)
    sample_depth(depth, noises[1], inputs.step, pose)
    sample_attitude(attitude, noises[2], inputs.step, pose, velocity)
    sample_altitude(altitude, noises[3], inputs.step, pose, sounding)

    height = altitude.values[0] - constants.below_camera
    tilt = (attitude.values[0], attitude.values[1])
    update_position_error(keepers[0], seen_corners, inputs.seen, height, tilt, constants.dt)

    write_tracking_error(pose, corners, inputs.ok, view, station, row)
    time_s = inputs.step * constants.physics_step_s
    write_current(time_s, water, state, row[_CURRENT : _CURRENT + 3])
    _record_time_and_contact(inputs, constants, row)
    _record_motion(pose, state, row)
    for i in range(3):
        row[_ERROR + i], row[_DVL + i] = keepers[0].error[i], dvl.values[i]
    _fill_measured(inputs.step, dvl, depth, attitude, measured[0])
    observation[_SEEN_T], observation[_SEEN_DT] = inputs.t, constants.dt
    _observe_position_error(keepers[0], observation)
    _observe_sensors(dvl, depth, attitude, altitude, observation)
    observation[_SEEN_THRUST:] = state[RIGID:]


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
        column = _THRUST + i if i < COMMON_THRUSTERS else WIDTH + i - COMMON_THRUSTERS
        row[column] = state[RIGID + i]


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
