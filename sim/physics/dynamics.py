"""The vehicle's equations of motion and their integration: RK4, 6 degrees of freedom.

    (M_RB + M_A) v_r' + C(v_r) v_r + D(v_r) v_r + g = thrust,   position' = R (v_r + R^T current)

Everything is written in the velocity v_r relative to the water, since Newton's laws hold in a
frame that moves with the water. If the water accelerates, the inertia force of that frame and the
pressure gradient act like gravity in another direction, which enters the restoring forces. A
contact engine cannot integrate this motion: an explicit added-mass force diverges within 0.1 s.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.lanes import sqrt
from seamark.sim.numerics.lent import Lent, taken
from seamark.sim.numerics.linear_algebra import inverse
from seamark.sim.physics.current import (
    Moving,
    Segment,
    Water,
    at_depth,
    flow,
    moving_in,
    segment_at,
)
from seamark.sim.physics.hydrodynamics import (
    add_coriolis,
    add_drag,
    add_restoring,
    write_rotation,
)
from seamark.sim.physics.thrusters import steady_thrust
from seamark.sim.vehicles import STANDARD_GRAVITY, Vehicle

RIGID = 13  # position 3, quaternion 4, velocity 6; thrusts follow


class Body(NamedTuple):
    """The parameters of a vehicle as the compiled code reads them."""

    mass: Array
    inverse_mass: Array
    added: Array
    linear: Array
    quadratic: Array
    allocation: Array
    net_weight: float
    moment: Array
    lag_rate: float


class Buffers(NamedTuple):
    """Memory of one thread for an integration step."""

    k1: Array  # (13 + n,) the rates of RK4's four stages
    k2: Array
    k3: Array
    k4: Array
    y: Array  # (13 + n,) the state of a stage
    rotation: Array  # (3, 3)
    relative: Array  # (6,) velocity relative to the water
    momentum: Array  # (6,)
    wrench: Array  # (6,)


class Span(NamedTuple):
    """The physics steps of one call."""

    first: int  # since the level began
    steps: int
    step_s: float
    gate: float  # [m] no step begins deeper


class Thrusters(NamedTuple):
    """The thrusters of one plant."""

    curve: Array  # (16,), see `thrusters.pack_curve`
    gains: Array  # (n,) real thrust over the nominal one
    target: Array  # (n,) [N] steady thrust of the command, written


class Fault(NamedTuple):
    """The thruster that does not do what it is told."""

    thruster: int  # -1 for none
    thrust: Array  # (1,) [N]


class Afloat(NamedTuple):
    """A vehicle in its water, with commands that are held."""

    state: Array  # (13 + n,), see `plant.Plant`
    command: Array  # (n,) in [-1, 1]
    step_s: float
    thrusters: Thrusters
    fault: Fault
    body: Body
    water: Water
    work: Buffers


def body_parameters(vehicle: Vehicle) -> Body:
    """Return the parameters of a vehicle; all that is constant over a run is computed here."""
    mass = vehicle.mass_rigid() + vehicle.mass_added()
    weight, buoyancy = vehicle.weight.scalar, vehicle.buoyancy.scalar
    centres = zip(vehicle.centre_of_gravity.value, vehicle.centre_of_buoyancy.value, strict=True)
    return Body(
        mass=mass,
        inverse_mass=inverse(mass),
        added=vehicle.mass_added(),
        linear=vehicle.linear_drag(),
        quadratic=vehicle.quadratic_drag(),
        allocation=vehicle.allocation(),
        net_weight=weight - buoyancy,
        moment=np.array([weight * g - buoyancy * b for g, b in centres]),
        lag_rate=1.0 / vehicle.lag.scalar,
    )


@njit(cache=True, error_model="numpy", inline="always")
def _into_body(rotation: Array, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Return a world vector in body axes."""
    return (
        rotation[0, 0] * x + rotation[1, 0] * y + rotation[2, 0] * z,
        rotation[0, 1] * x + rotation[1, 1] * y + rotation[2, 1] * z,
        rotation[0, 2] * x + rotation[1, 2] * y + rotation[2, 2] * z,
    )


@njit(cache=True, error_model="numpy", inline="always")
def _write_thrust(allocation: Array, x: Array, wrench: Array) -> None:
    """Write the wrench (6,) of all thrusters in the state `x`."""
    for i in range(6):
        push = 0.0
        for j in range(allocation.shape[1]):
            push += allocation[i, j] * x[RIGID + j]
        wrench[i] = push


@njit(cache=True, error_model="numpy", inline="always")
def _add_shear_inertia(
    shear: tuple[float, float, float], x: Array, added: Array, rotation: Array, wrench: Array
) -> None:
    """Add the added-mass force of moving vertically through sheared flow to `wrench`, (6,).

    The added mass responds to the relative velocity, which changes with depth; the hull and its
    buoyancy respond only to the acceleration of the water. S: Auton, Hunt and
    Prud'homme 1988 (J. Fluid Mech. 197), sphere in a weak shear; its lift along z is left out.
    `shear` is the change of the water's velocity with depth [1/s].
    """
    sinking = rotation[2, 0] * x[7] + rotation[2, 1] * x[8] + rotation[2, 2] * x[9]
    s0, s1, s2 = _into_body(rotation, sinking * shear[0], sinking * shear[1], sinking * shear[2])
    for i in range(6):
        wrench[i] += added[i, 0] * s0 + added[i, 1] * s1 + added[i, 2] * s2


@njit(cache=True, error_model="numpy", inline="always")
def _write_kinematics(x: Array, rotation: Array, out: Array) -> None:
    """Write the rates of position and quaternion to the first seven entries of `out`."""
    p, q, r = x[10], x[11], x[12]
    for i in range(3):
        out[i] = rotation[i, 0] * x[7] + rotation[i, 1] * x[8] + rotation[i, 2] * x[9]
    out[3] = 0.5 * (-x[4] * p - x[5] * q - x[6] * r)
    out[4] = 0.5 * (x[3] * p + x[5] * r - x[6] * q)
    out[5] = 0.5 * (x[3] * q + x[6] * p - x[4] * r)
    out[6] = 0.5 * (x[3] * r + x[4] * q - x[5] * p)


@njit(cache=True, error_model="numpy", inline="always")
def _derivative(
    x: Array,
    target: Array,
    moving: Moving,
    body: Body,
    work: Buffers,
    out: Array,
) -> None:
    """Write the state's rate of change (13 + n,) to `out`.

    There is no branch for water without shear and without vertical motion, since it would double
    the time of a step; zeros change no bit.
    """
    rotation, relative, momentum, wrench = work.rotation, work.relative, work.momentum, work.wrench
    stream_x, stream_y, stream_z, rise_x, rise_y, rise_z = moving[:6]
    shear_x, shear_y, shear_z, surge, sway = moving[6:]
    write_rotation(x[3], x[4], x[5], x[6], rotation)
    _write_thrust(body.allocation, x, wrench)
    _add_shear_inertia((shear_x, shear_y, shear_z), x, body.added, rotation, wrench)
    c0, c1, c2 = _into_body(rotation, stream_x, stream_y, stream_z)
    a0, a1, a2 = _into_body(rotation, rise_x, rise_y, rise_z)
    p, q, r = x[10], x[11], x[12]
    relative[0], relative[1], relative[2] = x[7] - c0, x[8] - c1, x[9] - c2
    relative[3], relative[4], relative[5] = p, q, r
    wrench[0] += surge
    wrench[1] += sway
    add_coriolis(body.mass, relative, momentum, wrench)
    add_drag(body.linear, body.quadratic, relative, wrench)
    g = STANDARD_GRAVITY
    down = (rotation[2, 0] - a0 / g, rotation[2, 1] - a1 / g, rotation[2, 2] - a2 / g)
    add_restoring(body.net_weight, body.moment, down, wrench)
    _write_kinematics(x, rotation, out)
    for i in range(6):
        rate = 0.0
        for j in range(6):
            rate += body.inverse_mass[i, j] * wrench[j]
        out[7 + i] = rate
    # Acceleration of the water in the rotating body frame.
    out[7] += a0 - (q * c2 - r * c1)
    out[8] += a1 - (r * c0 - p * c2)
    out[9] += a2 - (p * c1 - q * c0)
    for j in range(target.size):
        out[RIGID + j] = (target[j] - x[RIGID + j]) * body.lag_rate


@njit(cache=True, error_model="numpy")
def write_acceleration(
    t: float,
    state: Array,
    body: Body,
    water: Water,
    work: Buffers,
    out: Array,
) -> None:
    """Write the acceleration over ground at time t [s] to `out`, (6,) body frame [m/s², rad/s²].

    It is that of the thrusts in `state`.
    """
    target = state[RIGID:]  # the thrusts do not change
    _derivative(state, target, moving_in(t, state[2], water), body, work, work.k1)
    for i in range(6):
        out[i] = work.k1[7 + i]


def integration_buffers(size: int) -> Buffers:
    """Return what `advance_held` needs for a state of this size; two threads need two."""
    return Buffers(
        k1=np.empty(size),
        k2=np.empty(size),
        k3=np.empty(size),
        k4=np.empty(size),
        y=np.empty(size),
        rotation=np.empty((3, 3)),
        relative=np.empty(6),
        momentum=np.empty(6),
        wrench=np.empty(6),
    )


@njit(cache=True, error_model="numpy")
def integrate(
    state: Array,
    target: Array,
    span: Span,
    body: Body,
    water: Water,
    work: Buffers,
) -> int:
    """Advance `state` in place by up to `span.steps` RK4 steps; return the number of steps made.

    It stops before a step that would begin deeper than the gate.
    """
    for done in range(span.steps):
        if state[2] > span.gate:
            return done
        t = (span.first + done) * span.step_s
        middle, grid = t + 0.5 * span.step_s, (water.top, water.spacing)
        segment = segment_at(middle, state[2], water.law, grid, water.drift)
        runge_kutta_step(state, target, (t, span.step_s), body, (water, segment), work)
    return span.steps


@njit(cache=True, error_model="numpy", inline="always")
def runge_kutta_step(
    state: Array,
    target: Array,
    t_and_step: tuple[float, float],
    body: Body,
    water_and_segment: tuple[Water, Segment],
    work: Buffers,
) -> None:
    """Advance `state`, of one vehicle or of lanes of them, in place by one step from time t [s]."""
    (t, step_s), (water, segment) = t_and_step, water_and_segment
    law = (water.law, water.shear, water.bottom, water.height)
    k1, k2, k3, k4, y = work.k1, work.k2, work.k3, work.k4, work.y
    size = state.size
    middle, end = t + 0.5 * step_s, t + step_s
    halfway = flow(middle, water, segment)
    moving = at_depth(t, state[2], flow(t, water, segment), law, segment)
    _derivative(state, target, moving, body, work, k1)
    for i in range(size):
        y[i] = state[i] + 0.5 * step_s * k1[i]
    moving = at_depth(middle, y[2], halfway, law, segment)
    _derivative(y, target, moving, body, work, k2)
    for i in range(size):
        y[i] = state[i] + 0.5 * step_s * k2[i]
    moving = at_depth(middle, y[2], halfway, law, segment)
    _derivative(y, target, moving, body, work, k3)
    for i in range(size):
        y[i] = state[i] + step_s * k3[i]
    moving = at_depth(end, y[2], flow(end, water, segment), law, segment)
    _derivative(y, target, moving, body, work, k4)
    for i in range(size):
        state[i] = state[i] + step_s / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i])
    _normalise(state)


@njit(cache=True, error_model="numpy")
def advance_held(afloat: Lent[Afloat], first: int, steps: int, gate: float) -> int:
    """Advance the state with constant commands, as `integrate`; -1 if one is not a number."""
    return advance_afloat(taken(afloat), first, steps, gate)


@njit(cache=True, error_model="numpy", inline="always")
def advance_afloat(afloat: Afloat, first: int, steps: int, gate: float) -> int:
    """Advance a vehicle as `advance_held`."""
    state, command, step_s, thrusters, fault, body, water, work = afloat
    target = thrusters.target
    if not steady_thrust(command, thrusters.curve, target):
        return -1
    if fault.thruster >= 0:
        target[fault.thruster] = fault.thrust[0]
    for i in range(target.size):
        target[i] *= thrusters.gains[i]
    return integrate(state, target, Span(first, steps, step_s, gate), body, water, work)


@njit(cache=True, error_model="numpy")
def _normalise(state: Array) -> None:
    w, x, y, z = state[3], state[4], state[5], state[6]
    length = sqrt(w * w + x * x + y * y + z * z)
    state[3], state[4], state[5], state[6] = w / length, x / length, y / length, z / length


@njit(cache=True, error_model="numpy")
def add_impulse(state: Array, inverse_mass: Array, impulse: Array) -> None:
    """Change the velocity of `state` in place by an impulse, (6,) body frame about the origin."""
    for i in range(6):
        for j in range(6):
            state[7 + i] += inverse_mass[i, j] * impulse[j]


@njit(cache=True, error_model="numpy")
def write_current(t: float, water: Water, state: Array, out: Array) -> None:
    """Write the water's velocity at time t [s] to `out`, (3,) NED; see `Plant.current_world`."""
    moving = moving_in(t, state[2], water)
    surge, sway = moving[9], moving[10]
    out[0], out[1], out[2] = moving[0], moving[1], moving[2]
    if surge > 0.0 or sway > 0.0:
        forward = math.sqrt(surge / water.force)
        starboard = math.sqrt(sway / water.force)
        rotation = np.empty((3, 3))
        write_rotation(state[3], state[4], state[5], state[6], rotation)
        for i in range(3):
            out[i] = rotation[i, 0] * forward + rotation[i, 1] * starboard
