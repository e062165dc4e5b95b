"""The end of a control step in one compiled call: velocity controller, thrusters, equations.

In Python, what holds these together took twice as long as they do.
"""

import math
from typing import NamedTuple

from numba import njit

from seamark.sim.control import velocity_law
from seamark.sim.control.velocity_law import Records
from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.lent import Lent, taken
from seamark.sim.physics.dynamics import Afloat, advance_afloat

NOT_FINITE = -1


class Steering(NamedTuple):
    """What moves a vehicle as its program wants."""

    dt: float  # [s] control period
    measured: Records  # (1,) of the velocity controller, as are the next four
    settings: Records  # (1,)
    axes: Records  # (3,)
    holds: Records  # (4,)
    thrusters: velocity_law.Thrusters
    thrust: Array  # (n,) [N] wanted, written
    afloat: Afloat


@njit(cache=True, error_model="numpy")
def steer(
    lent: Lent[Steering],
    surge: float,
    sway: float,
    heave: float,
    yaw_rate: float,
    first: int,
    steps: int,
    gate: float,
) -> int:
    """Control the velocity, and advance the vehicle by physics steps; return how many were made.

    `NOT_FINITE` if a command of a thruster is not; then nothing moves. The others are as in
    `dynamics.integrate`, and the reference [m/s, rad/s] as in `velocity_law.Reference`.
    """
    steering = taken(lent)
    command = steering.afloat.command
    velocity_law.step(
        velocity_law.Reference(surge, sway, heave, yaw_rate),
        steering.measured,
        steering.dt,
        steering.settings,
        steering.axes,
        steering.holds,
        steering.thrusters,
        velocity_law.Outputs(steering.thrust, command),
    )
    for i in range(command.size):
        if not math.isfinite(command[i]):
            return NOT_FINITE
    return advance_afloat(steering.afloat, first, steps, gate)
