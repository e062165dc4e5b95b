"""Inverse dynamics of the true plant: the law of the oracle.

It sees what no vehicle can: true pose and velocity, the water's motion at every moment, true mass,
drag and thrusters. What keeps it from holding station is the thrust that there is, and its lag.

Of the desired acceleration a_d and the present one a, thrusts f' follow from

    M^-1 B (f' - f) = a_d - a

(acceleration control, Fossen 2021, ch. 16). Where the limits of the thrusters forbid it, weighted
least squares decide. The present acceleration is that of the plant's own equations, so no effect is
left out. The lag of a thruster is inverted over one control step.
"""

import math

import numpy as np
from numba import njit

from seamark.sim.control.bounded_allocation import allocate_within
from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.libm import exp, sincos
from seamark.sim.physics.dynamics import RIGID
from seamark.sim.physics.plant import Plant
from seamark.sim.physics.thrusters import commands_for, pack_curve

FREQUENCY_1_S = 3.0  # E: natural frequency of the error, below the 5 1/s of the slowest thruster
DAMPING = 1.0
# E: importance of an acceleration by axis: a point 1 m ahead moves as much by 1 rad as by 1 m.
WEIGHTS = np.array([1.0, 1.0, 0.3, 0.1, 0.1, 1.0])
REGULARISATION = 1e-9  # [1/(kg² ...)] smallest thrusts among all that are as good; E


class InverseDynamics:
    """Thruster commands for one level, from the truth."""

    def __init__(self, plant: Plant, station: Array, dt: float) -> None:
        """Prepare the law.

        Parameters
        ----------
        plant
            The true plant.
        station : (6,) [m, rad]
            The pose to hold: x, y, z, roll, pitch, yaw.
        dt : float [s]
            Control period, over which a command is constant.
        """
        self._plant, self._station = plant, np.array(station, dtype=np.float64)
        vehicle = plant.vehicle
        self._effect = _effect(plant.inverse_mass(), vehicle.allocation())
        self._curve = pack_curve(vehicle.curve)
        self._kept = exp(-dt / vehicle.lag.scalar)  # share of a thrust after a step
        count = len(vehicle.thrusters)
        forward, reverse = vehicle.curve.limits.value
        self._limits = (-reverse, forward)
        self._gains = plant.thruster_gains.copy()
        if plant.fault is not None:
            self._gains[plant.fault.thruster] *= plant.fault.efficiency
        self._command = np.zeros(count)

    def commands(self) -> Array:
        """Return the commands for the next step, (n,) in [-1, 1]; reused at the next call."""
        plant = self._plant
        law(
            plant.state,
            plant.pose(),
            self._station,
            plant.acceleration(),
            (self._effect, self._gains, self._limits, self._kept, self._curve),
            self._command,
        )
        return self._command


def _effect(inverse_mass: Array, allocation: Array) -> Array:
    """Return the acceleration per thrust, (6, n) [m/s² per N, rad/s² per N], without BLAS."""
    effect = np.zeros(allocation.shape)
    for i in range(6):
        for j in range(6):
            effect[i] += inverse_mass[i, j] * allocation[j]
    return effect


@njit(cache=True, error_model="numpy")
def desired_acceleration(state: Array, pose: Array, station: Array, out: Array) -> None:
    """Write the acceleration that brings the vehicle to the station to `out`, (6,) body frame.

    Second-order error dynamics on each axis; roll and pitch are small.
    """
    stiffness, friction = FREQUENCY_1_S * FREQUENCY_1_S, 2.0 * DAMPING * FREQUENCY_1_S
    sine, cosine = sincos(pose[5])
    north, east = station[0] - pose[0], station[1] - pose[1]
    out[0] = stiffness * (cosine * north + sine * east)
    out[1] = stiffness * (cosine * east - sine * north)
    out[2] = stiffness * (station[2] - pose[2])
    for i in range(3):
        error = station[3 + i] - pose[3 + i]
        error -= 2.0 * math.pi * math.floor((error + math.pi) / (2.0 * math.pi))
        out[3 + i] = stiffness * error
    for i in range(6):
        out[i] -= friction * state[7 + i]


@njit(cache=True, error_model="numpy")
def law(
    state: Array,
    pose: Array,
    station: Array,
    present: Array,
    vehicle: tuple[Array, Array, tuple[float, float], float, Array],
    command: Array,
) -> None:
    """Write the commands, (n,) in [-1, 1].

    Parameters
    ----------
    present : (6,) body frame [m/s², rad/s²]
        Acceleration with the present thrusts.
    vehicle : tuple
        Acceleration per thrust, (6, n); the share of its thrust that each thruster gives, (n,), 1
        without a fault; lowest and highest steady thrust [N]; share of the present thrust that is
        left after one step; packed thruster curve.
    """
    effect, gains, limits, kept, curve = vehicle
    count = command.size
    change = np.empty(6)
    desired_acceleration(state, pose, station, change)
    hessian, gradient = np.zeros((count, count)), np.zeros(count)
    thrust, lowest, highest = np.empty(count), np.empty(count), np.empty(count)
    for j in range(count):
        thrust[j] = state[RIGID + j]
        lowest[j] = kept * thrust[j] + (1.0 - kept) * gains[j] * limits[0]
        highest[j] = kept * thrust[j] + (1.0 - kept) * gains[j] * limits[1]
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
    commands_for(thrust, curve, command)
