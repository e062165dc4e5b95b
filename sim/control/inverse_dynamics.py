"""Inverse dynamics of the true plant: the law of the oracle.

It sees what no vehicle can: true pose and velocity, the water's motion at every moment, true mass,
drag and thrusters. What keeps it from holding station is the thrust that there is, and its lag.

Of the desired acceleration a_d and the present one a, thrusts f' follow from

    M^-1 B (f' - f) = a_d - a

(acceleration control, Fossen 2021, ch. 16). Where the limits of the thrusters forbid it, weighted
least squares decide. The present acceleration is that of the plant's own equations, so no effect is
left out. The lag of a thruster is inverted over one control step.

Where only a point of the vehicle counts, such as a tool, the heading is free: the vehicle turns
about that point towards the current or away from it, whichever is nearer, since ahead its drag is
least and its thrust greatest (weather optimal positioning, Fossen and Strand 2001).
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from seamark.sim.control.allocation import allocate_within
from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.compilation import SameTypes
from seamark.sim.numerics.libm import PI, atan2, exp, sincos
from seamark.sim.physics.dynamics import RIGID
from seamark.sim.physics.plant import Plant
from seamark.sim.physics.thrusters import commands_for, pack_curve

FREQUENCY_1_S = 3.0  # E: natural frequency of the error, below the 5 1/s of the slowest thruster
DAMPING = 1.0
# E: importance of an acceleration by axis: a point 1 m ahead moves as much by 1 rad as by 1 m.
WEIGHTS = np.array([1.0, 1.0, 0.3, 0.1, 0.1, 1.0])
TURN_1_S = 1.0  # E: natural frequency of the heading while it follows the current
LARGEST_LEAD_RAD = 0.5  # E: largest heading error that is acted upon
LARGEST_TURN_RAD = 1.3  # E: with it the target stays in view of the camera
# [m/s] E: the heading follows the current from the first speed on, and wholly from the second
TURNING_SPEEDS = (0.15, 0.35)
REGULARISATION = 1e-9  # [1/(kg² ...)] smallest thrusts among all that are as good; E


class Goal(NamedTuple):
    """Where the vehicle should be."""

    station: Array  # (6,) [m, rad]
    ahead: float  # [m] the point that is held, forward and starboard of the body's origin
    side: float
    heading: float  # [rad]
    turn: float  # [1/s] natural frequency of the heading
    velocity: Array  # (3,) NED [m/s] of the point


class Thrusters(NamedTuple):
    """What the thrusters do, without an error."""

    effect: Array  # (6, n) acceleration per thrust
    gains: Array  # (n,) share of its thrust that each gives, 1 without a fault
    lowest: float  # [N] steady thrust
    highest: float
    kept: float  # share of the present thrust that is left after one step
    curve: Array  # (16,) packed


class InverseDynamics:
    """Thruster commands for one level, from the truth."""

    def __init__(
        self, plant: Plant, station: Array, dt: float, point: tuple[float, float] | None
    ) -> None:
        """Prepare the law.

        Parameters
        ----------
        plant
            The true plant.
        station : (6,) [m, rad]
            The pose to hold: x, y, z, roll, pitch, yaw.
        dt : float [s]
            Control period, over which a command is constant.
        point : (2,) [m]
            Forward and starboard of the body's origin: the point that is held, with the heading
            free; None to hold the pose.
        """
        self._plant, self._station = plant, np.array(station, dtype=np.float64)
        self._free = point is not None
        self._point = point or (0.0, 0.0)
        self._heading = float(station[5])
        self._velocity = np.zeros(3)
        vehicle = plant.vehicle
        forward, reverse = vehicle.curve.limits.value
        gains = plant.thruster_gains.copy()
        if plant.fault is not None:
            gains[plant.fault.thruster] *= plant.fault.efficiency
        self._thrusters = Thrusters(
            effect=_effect(plant.body.inverse_mass, vehicle.allocation()),
            gains=gains,
            lowest=-reverse,
            highest=forward,
            kept=exp(-dt / vehicle.lag.scalar),
            curve=pack_curve(vehicle.curve),
        )
        self._command = np.zeros(len(vehicle.thrusters))
        self._law = SameTypes(law)

    def commands(self) -> Array:
        """Return the commands for the next step, (n,) in [-1, 1]; reused at the next call."""
        plant, pose = self._plant, self._plant.pose()
        if self._free:
            self._turn(pose)
        turn = TURN_1_S if self._free else FREQUENCY_1_S
        goal = Goal(self._station, *self._point, self._heading, turn, self._velocity)
        self._law.call(
            plant.state, pose, goal, plant.acceleration(), self._thrusters, self._command
        )
        return self._command

    def _turn(self, pose: Array) -> None:
        """Choose the heading: towards the current or away from it, whichever is nearer."""
        north, east, _down = self._plant.current_world().tolist()
        yaw, own = pose.item(5), self._station.item(5)
        ahead = wrapped(atan2(east, north) - yaw)
        turn = ahead - PI * math.floor(ahead / PI + 0.5)  # to the nearer of bow and stern
        slow, fast = TURNING_SPEEDS
        share = min(max((math.hypot(north, east) - slow) / (fast - slow), 0.0), 1.0)
        wanted = share * wrapped(yaw + turn - own)
        self._heading = own + min(max(wanted, -LARGEST_TURN_RAD), LARGEST_TURN_RAD)


class MovingGoal(InverseDynamics):
    """The same for a place that moves, with a heading that is free."""

    def __init__(self, plant: Plant, station: Array, dt: float) -> None:
        """Prepare the law; see `InverseDynamics`."""
        super().__init__(plant, station, dt, (0.0, 0.0))

    def aim(self, place: Array, velocity: Array, heading: float | None) -> None:
        """Set where the vehicle should be and how fast, (3,) NED [m, m/s].

        `heading` [rad] is where its bow should be turned; None leaves it.
        """
        self._station[:3], self._velocity[:] = place, velocity
        if heading is not None:
            self._heading = heading

    def _turn(self, pose: Array) -> None:
        """Leave the heading as it was set."""


def _effect(inverse_mass: Array, allocation: Array) -> Array:
    """Return the acceleration per thrust, (6, n) [m/s² per N, rad/s² per N], without BLAS."""
    effect = np.zeros(allocation.shape)
    for i in range(6):
        for j in range(6):
            effect[i] += inverse_mass[i, j] * allocation[j]
    return effect


@njit(cache=True, error_model="numpy")
def wrapped(angle: float) -> float:
    """Return the angle within [-pi, pi)."""
    return angle - 2.0 * math.pi * math.floor((angle + math.pi) / (2.0 * math.pi))


@njit(cache=True, error_model="numpy")
def desired_acceleration(state: Array, pose: Array, goal: Goal, out: Array) -> None:
    """Write the acceleration that brings the vehicle to its goal to `out`, (6,) body frame.

    Second-order error dynamics of the point that is held and on each angle; roll and pitch are
    small.
    """
    station, ahead, side, turn = goal.station, goal.ahead, goal.side, goal.turn
    sine, cosine = sincos(pose[5])
    own_sine, own_cosine = sincos(station[5])
    north = station[0] + own_cosine * ahead - own_sine * side - pose[0]
    east = station[1] + own_sine * ahead + own_cosine * side - pose[1]
    stiffness, friction = FREQUENCY_1_S * FREQUENCY_1_S, 2.0 * DAMPING * FREQUENCY_1_S
    rate = state[12]
    out[5] = min(max(wrapped(goal.heading - pose[5]), -LARGEST_LEAD_RAD), LARGEST_LEAD_RAD)
    out[5] = turn * (turn * out[5] - 2.0 * DAMPING * rate)
    out[0] = stiffness * (cosine * north + sine * east - ahead)
    out[1] = stiffness * (cosine * east - sine * north - side)
    # Of the point, then of the origin: without the acceleration by turning about it.
    north, east, down = goal.velocity[0], goal.velocity[1], goal.velocity[2]
    surge, sway = cosine * north + sine * east, cosine * east - sine * north
    out[0] += -friction * (state[7] - rate * side - surge) + out[5] * side + rate * rate * ahead
    out[1] += -friction * (state[8] + rate * ahead - sway) - out[5] * ahead + rate * rate * side
    out[2] = stiffness * (station[2] - pose[2]) - friction * (state[9] - down)
    for i in (3, 4):
        out[i] = stiffness * wrapped(station[i] - pose[i]) - friction * state[7 + i]


@njit(cache=True, error_model="numpy")
def law(
    state: Array,
    pose: Array,
    goal: Goal,
    present: Array,
    thrusters: Thrusters,
    command: Array,
) -> None:
    """Write the commands, (n,) in [-1, 1].

    `present` is the acceleration with the present thrusts, (6,) body frame [m/s², rad/s²].
    """
    effect, gains, kept = thrusters.effect, thrusters.gains, thrusters.kept
    count = command.size
    change = np.empty(6)
    desired_acceleration(state, pose, goal, change)
    hessian, gradient = np.zeros((count, count)), np.zeros(count)
    thrust, lowest, highest = np.empty(count), np.empty(count), np.empty(count)
    for j in range(count):
        thrust[j] = state[RIGID + j]
        lowest[j] = kept * thrust[j] + (1.0 - kept) * gains[j] * thrusters.lowest
        highest[j] = kept * thrust[j] + (1.0 - kept) * gains[j] * thrusters.highest
        hessian[j, j] = REGULARISATION
    for i in range(6):
        wanted = change[i] - present[i]
        for j in range(count):
            wanted += effect[i, j] * thrust[j]
        for j in range(count):
            gradient[j] += WEIGHTS[i] * effect[i, j] * wanted
            for k in range(count):
                hessian[j, k] += WEIGHTS[i] * effect[i, j] * effect[i, k]
    allocate_within(hessian, gradient, lowest, highest, thrust)
    for j in range(count):
        steady = (thrust[j] - kept * state[RIGID + j]) / (1.0 - kept)
        thrust[j] = steady / gains[j] if gains[j] > 0.0 else 0.0
    commands_for(thrust, thrusters.curve, command)
