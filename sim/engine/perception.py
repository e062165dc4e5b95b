"""What is known at a tick, in one compiled call: the picture judged, all sensors, the aim.

From it come the row of telemetry, what the program is shown and what the velocity controller
measures. In Python the same took as long as drawing the picture.
"""

from typing import Any, NamedTuple

from numba import njit

from seamark.sim.control.observation import STARTS, THRUSTERS
from seamark.sim.control.station_keeper import aim
from seamark.sim.control.velocity_law import Records
from seamark.sim.engine.tracking_error import View, judge
from seamark.sim.physics.dynamics import RIGID, write_current
from seamark.sim.recording.telemetry import INDEX
from seamark.sim.sensors.sensors import (
    Record,
    measure_altitude,
    measure_attitude,
    measure_depth,
    measure_dvl,
)
from seamark.sim.vehicles import Array

Noises = tuple[Array, Array, Array, Array]
Suite = tuple[Records, Records, Records, Records]  # (1,) each: DVL, depth, attitude, altitude

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


class Moment(NamedTuple):
    """What changes from tick to tick beside the arrays; in this order, as a plain tuple."""

    tick: int  # physics steps since the level began
    t: float  # [s] since the trial began
    ok: bool  # whether the tracker has the target
    altitude: float  # [m] of the body's origin above the bottom
    echoes: int  # of the DVL's beams
    contact_n: float  # [N]


class Place(NamedTuple):
    """What stays the same over a level; in this order, as a plain tuple."""

    trial: int
    level: int
    step: float  # [s] of the physics
    dt: float  # [s] from tick to tick
    below_camera: float  # [m] altitude at which the camera would touch the target


@njit(cache=True, error_model="numpy")
def perceive(
    plain_moment: tuple[Any, ...],
    plain_place: tuple[Any, ...],
    seen: tuple[View, Array, Array],
    plant: tuple[Array, Array, tuple[Any, ...]],
    sensors: Suite,
    noises: Noises,
    keepers: Records,
    out: tuple[Array, Array, Records],
) -> None:
    """Measure, aim, and write what comes of it.

    Parameters
    ----------
    plain_moment, plain_place
        `Moment` and `Place`.
    seen
        `judgement.View`; the station (3,) [m]; the tracker's corners (8,) [px].
    plant
        Its state (13 + n,), pose (6,), the water as a plain tuple.
    sensors, noises
        Their records and the noise of their readings; changed: what they hold.
    keepers
        (1,) record of the station keeper, changed.
    out
        The row (WIDTH,), all but the program's reference and its time; the observation; what the
        velocity controller measures, (1,) record.
    """
    moment, place = Moment(*plain_moment), Place(*plain_place)
    view, station, corners = seen
    state, pose, water = plant
    row, observation, measured = out
    velocity, sounding = state[7:13], (moment.altitude, moment.echoes)
    dvl, depth, attitude, altitude = sensors[0][0], sensors[1][0], sensors[2][0], sensors[3][0]
    measure_dvl(dvl, noises[0], moment.tick, pose, velocity, sounding)
    measure_depth(depth, noises[1], moment.tick, pose, velocity, sounding)
    measure_attitude(attitude, noises[2], moment.tick, pose, velocity, sounding)
    measure_altitude(altitude, noises[3], moment.tick, pose, velocity, sounding)

    height = altitude.values[0] - place.below_camera
    aim(keepers[0], corners, moment.ok, height, (attitude.values[0], attitude.values[1]), place.dt)

    judge(pose, corners, moment.ok, view, station, row)
    write_current(moment.tick * place.step, water, state, row[_CURRENT : _CURRENT + 3])
    _record(moment, place, row)
    _record_motion(pose, state, row)
    for i in range(3):
        row[_ERROR + i], row[_DVL + i] = keepers[0].error[i], dvl.values[i]
    _measure(moment.tick, dvl, depth, attitude, measured[0])
    observation[_SEEN_T], observation[_SEEN_DT] = moment.t, place.dt
    _show_aim(keepers[0], observation)
    _show_sensors(dvl, depth, attitude, altitude, observation)
    observation[_SEEN_THRUST:] = state[RIGID:]


@njit(cache=True, error_model="numpy")
def _record(moment: Moment, place: Place, row: Array) -> None:
    row[_TRIAL], row[_LEVEL], row[_T] = place.trial, place.level, moment.t
    row[_CONTACT] = moment.contact_n


@njit(cache=True, error_model="numpy")
def _record_motion(pose: Array, state: Array, row: Array) -> None:
    """Write pose, velocity and thrusts to the row; 0 beyond the vehicle's own thrusters."""
    for i in range(6):
        row[_POSE + i], row[_VELOCITY + i] = pose[i], state[7 + i]
    row[_THRUST : _THRUST + THRUSTERS] = 0.0
    for i in range(state.size - RIGID):
        row[_THRUST + i] = state[RIGID + i]


@njit(cache=True, error_model="numpy")
def _measure(tick: int, dvl: Record, depth: Record, attitude: Record, measured: Record) -> None:
    """Fill the velocity controller's record, `velocity_law.MEASURED`."""
    for i in range(3):
        measured.velocity[i] = dvl.values[i]
    measured.depth = depth.values[0]
    measured.yaw, measured.yaw_rate = attitude.values[2], attitude.values[5]
    measured.fresh = dvl.valid and dvl.measured_at == tick
    for i in range(2):
        measured.tilt[i], measured.tilt_rates[i] = attitude.values[i], attitude.values[3 + i]


@njit(cache=True, error_model="numpy")
def _show_aim(keeper: Record, observation: Array) -> None:
    for i in range(3):
        observation[_SEEN_ERROR + i] = keeper.error[i]
    for i in range(2):
        observation[_SEEN_ERROR_PX + i] = keeper.error_px[i]
    observation[_SEEN_VISIBLE], observation[_SEEN_AGE] = keeper.visible, keeper.age_s


@njit(cache=True, error_model="numpy")
def _show_sensors(
    dvl: Record, depth: Record, attitude: Record, altitude: Record, observation: Array
) -> None:
    for i in range(3):
        observation[_SEEN_VELOCITY + i] = dvl.values[i]
    observation[_SEEN_VALID] = dvl.valid
    observation[_SEEN_DEPTH], observation[_SEEN_ALTITUDE] = depth.values[0], altitude.values[0]
    for i in range(6):
        observation[_SEEN_ATTITUDE + i] = attitude.values[i]
