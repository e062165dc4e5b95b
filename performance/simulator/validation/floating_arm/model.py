"""The engine's BlueROV2 with its arm, whose joints follow the measured ones."""

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from performance.simulator.validation.floating_arm.records import STEP_S, Trial
from seamark.sim.multibody.assembly import Assembly, Mounting, assemble
from seamark.sim.multibody.mechanism import Motor, command_for, work_for
from seamark.sim.multibody.solver import Timing
from seamark.sim.multibody.step import Model, advance
from seamark.sim.multibody.tree import Frames, place
from seamark.sim.numerics.arrays import Array
from seamark.sim.physics.current import Current
from seamark.sim.physics.terrain import Bottom
from seamark.sim.vehicles import Quantity, load
from seamark.sim.vehicles.linkage_reading import load_linkage
from seamark.sim.vehicles.model import Place

VEHICLE, ARM = "bluerov2-heavy-v2", "alpha-like"
BASE_ZERO = 3.136  # [rad] axis e when the arm points ahead, as `frames` finds it
MOUNT_M = (0.19, 0.0, 0.11)  # estimate: below the front; it only changes the trim
JOINTS = ("shoulder", "upper arm", "forearm", "wrist")  # axes e, d, c, b
_TIMING = Timing(0.002, 10)
_SERVO_S = 0.02  # the joints are told where to be after each of these
_STEPS = round(_SERVO_S / _TIMING.step_s)
_STRONG = 1e4  # [N m] of motors that must follow
_DEPTH_M = -5.0  # of the start, above the level of reference: nothing is near
_SLOPE_SAMPLES = 6  # of the first attitudes, for the rates at the start
_WATER = Current(0.0).water
_GROUND = Bottom(1000.0).ground()


@dataclass(frozen=True, slots=True, kw_only=True)
class Parameters:
    """What is fitted: of the vehicle with the arm's base, without the arm's moving links."""

    righting: float  # [N m] weight times height of buoyancy above gravity
    trim_ahead: float  # [N m]
    trim_starboard: float  # [N m]
    roll_inertia: float  # [kg m²] rigid and added
    pitch_inertia: float  # [kg m²]
    roll_damping: float  # [N m s]
    pitch_damping: float  # [N m s]

    def values(self) -> Array:
        """Return the numbers in the order of their names."""
        return np.array([getattr(self, each.name) for each in fields(self)])


NAMES = tuple(each.name for each in fields(Parameters))
UNITS = ("N m", "N m", "N m", "kg m²", "kg m²", "N m s", "N m s")


def parameters(values: Sequence[float] | Array) -> Parameters:
    """Return parameters from their values in order."""
    return Parameters(**dict(zip(NAMES, map(float, values), strict=True)))


START = parameters((3.5, -0.2, 0.26, 0.45, 0.36, 0.2, 0.8))  # inertia and damping: the vehicle's
FITTED = parameters((3.214, -1.219, 0.2543, 1.28, 0.713, 1.09, 0.586))  # as `fit` finds them


def prepared(chosen: Parameters) -> tuple[Assembly, Model]:
    """Return the neutral vehicle with its arm, without contacts, friction and limits."""
    zero = Quantity(meaning="turn", value=(0.0, 0.0, 0.0), unit="rad", tag="E", source="level")
    point = Quantity(meaning="mounting", value=MOUNT_M, unit="m", tag="E", source="estimate")
    arm = Mounting(linkage=load_linkage(ARM), place=Place(point=point, turn=zero), on_vehicle=True)
    assembly = assemble(load(VEHICLE), [arm], bottom=False)
    mechanism = assembly.mechanism
    mechanism.pairs, mechanism.frictions, mechanism.limits = [], [], []
    mechanism.motors = [Motor(link=motor.link, effort=_STRONG) for motor in mechanism.motors]
    vehicle = mechanism.links[0]
    vehicle.net_weight -= sum(link.net_weight for link in mechanism.links)
    vehicle.moment = chosen.trim_ahead, chosen.trim_starboard, chosen.righting
    vehicle.rigid, vehicle.added = vehicle.rigid.copy(), vehicle.added.copy()
    for axis, inertia in ((3, chosen.roll_inertia), (4, chosen.pitch_inertia)):
        vehicle.added[axis, axis] = inertia - vehicle.rigid[axis, axis]
    linear = np.array(vehicle.linear)
    linear[3:5] = chosen.roll_damping, chosen.pitch_damping
    vehicle.linear = linear.tolist()
    return assembly, mechanism.model(_TIMING.step_s)


def predicted(chosen: Parameters, trial: Trial) -> Array:
    """Return roll and pitch, (n, 2) [rad], from the measured attitude at the start on."""
    assembly, model = prepared(chosen)
    state, command, work = assembly.state(model), command_for(model), work_for(model)
    coordinates = [assembly.coordinate(model, name) for name in JOINTS]
    motors = [assembly.motors.index(name) for name in JOINTS]
    targets = trial.joints - [BASE_ZERO, 0.0, 0.0, 0.0]
    roll, pitch = trial.attitude[0]
    state.q[2] = _DEPTH_M
    state.q[3:7] = _quaternion(roll, pitch)
    first = trial.attitude[:_SLOPE_SAMPLES]
    slopes = np.polyfit(STEP_S * np.arange(len(first)), first, 1)[0]
    state.v[3], state.v[4] = slopes[0], slopes[1]
    state.q[coordinates] = targets[0]
    angles = [(roll, pitch)]
    each = round(STEP_S / _SERVO_S)
    for k in range(1, len(targets)):
        for part in range(1, each + 1):
            wanted = targets[k - 1] + part / each * (targets[k] - targets[k - 1])
            command.speed[motors] = (wanted - state.q[coordinates]) / _SERVO_S
            done = ((k - 1) * each + part - 1) * _STEPS
            advance((done, _STEPS), _TIMING, model, state, command, _WATER, _GROUND, work)
        angles.append(_angles(*state.q[3:7]))
    return np.array(angles)


def balanced(chosen: Parameters, trial: Trial) -> Array:
    """Return roll and pitch, (n, 2) [rad], at which the same weights balance at each instant."""
    assembly, model = prepared(chosen)
    state, work = assembly.state(model), work_for(model)
    coordinates = [assembly.coordinate(model, name) for name in JOINTS]
    balances = []
    for joints in trial.joints - [BASE_ZERO, 0.0, 0.0, 0.0]:
        state.q[coordinates] = joints
        balances.append(_balance_of(model, state.q, work.frames))
    return np.array(balances)


def _balance_of(model: Model, q: Array, frames: Frames) -> tuple[float, float]:
    place(model.structure, model.links, q, frames)
    ahead, side, down = np.sum(
        [
            turn @ moment + weight * (position - q[:3])
            for turn, moment, weight, position in zip(
                frames.rotation, model.links.moment, model.links.net_weight, frames.position,
                strict=True,
            )
        ],
        axis=0,
    )  # fmt: skip
    return float(np.arctan2(side, down)), float(-np.arctan2(ahead, np.hypot(side, down)))


def _quaternion(roll: float, pitch: float) -> tuple[float, float, float, float]:
    (sr, sp), (cr, cp) = np.sin([0.5 * roll, 0.5 * pitch]), np.cos([0.5 * roll, 0.5 * pitch])
    return cr * cp, sr * cp, cr * sp, -sr * sp


def _angles(w: float, x: float, y: float, z: float) -> tuple[float, float]:
    roll = np.arctan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    return float(roll), float(np.arcsin(2.0 * (w * y - z * x)))
