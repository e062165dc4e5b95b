"""The motion of a block: eight vehicles side by side, by the functions that move a single one."""

from typing import Any, NamedTuple

import numpy as np
from numba import njit

from seamark.sim.fleet.tables import Bodies, Motion
from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.borrowed import borrowed
from seamark.sim.numerics.lanes import LANES, lanes_of, select
from seamark.sim.physics.current import Water, segment_at
from seamark.sim.physics.dynamics import RIGID, Body, runge_kutta_step
from seamark.sim.physics.thrusters import thrust_from_command


class Work(NamedTuple):
    """Memory of one thread; a plain tuple in this order."""

    state: Array  # (13 + k, 8)
    command: Array  # (k, 8)
    target: Array  # (k, 8) [N] steady thrusts
    first: Array  # (1, 8) physics steps since the level began
    middle: Array  # (1, 8) [s] the middle of the physics step
    segment: Array  # (5, 8), see current.Segment
    deep: Array  # (1, 8) whether the vehicle came below its gate: 0 or 1
    moves: Any  # (8,) bool: which vehicles are advanced
    k1: Array  # (13 + k, 8), as the following ones of `dynamics.Buffers`
    k2: Array
    k3: Array
    k4: Array
    y: Array
    rotation: Array  # (3, 3, 8)
    relative: Array  # (6, 8)
    momentum: Array
    wrench: Array


@njit(cache=True, error_model="numpy")
def block_buffers(size: int) -> tuple[Any, ...]:
    """Return a `Work` for states of this size."""
    thrusters = size - RIGID
    return (
        np.zeros((size, LANES)),
        np.zeros((thrusters, LANES)),
        np.zeros((thrusters, LANES)),
        np.zeros((1, LANES)),
        np.zeros((1, LANES)),
        np.zeros((5, LANES)),
        np.zeros((1, LANES)),
        np.zeros(LANES, np.bool_),
        np.zeros((size, LANES)),
        np.zeros((size, LANES)),
        np.zeros((size, LANES)),
        np.zeros((size, LANES)),
        np.zeros((size, LANES)),
        np.zeros((3, 3, LANES)),
        np.zeros((6, LANES)),
        np.zeros((6, LANES)),
        np.zeros((6, LANES)),
    )


@njit(cache=True, error_model="numpy", inline="always")
def load_vehicle(i: int, motion: Motion, first: int, work: Work) -> None:
    """Copy the state and the commands of a vehicle into its lane."""
    lane = i % LANES
    work.first[0, lane] = first
    for j in range(work.state.shape[0]):
        work.state[j, lane] = motion.state[i, j]
    for j in range(work.command.shape[0]):
        work.command[j, lane] = motion.command[i, j]


@njit(cache=True, error_model="numpy", inline="always")
def store_vehicle(i: int, motion: Motion, work: Work) -> bool:
    """Copy the new state of a vehicle back; not if it came below its gate: then return True."""
    lane = i % LANES
    if work.deep[0, lane] != 0.0:
        return True
    for j in range(work.state.shape[0]):
        motion.state[i, j] = work.state[j, lane]
    return False


@njit(cache=True, error_model="numpy")
def advance_block(
    block: int,
    law: int,
    steps_and_length: tuple[int, float],
    bodies: Bodies,
    motion: Motion,
    work: Work,
) -> None:
    """Advance the loaded vehicles by physics steps of a length [s], as `dynamics.integrate`.

    A vehicle that comes below its gate goes on freely, which is wrong, and is marked in `deep`.
    """
    bodies, motion, work = borrowed(bodies), borrowed(motion), borrowed(work)
    steps, step_s = steps_and_length
    state, target, deep = lanes_of(work.state), lanes_of(work.target), lanes_of(work.deep)
    first, middle, segment = lanes_of(work.first), lanes_of(work.middle), lanes_of(work.segment)
    command, gains = lanes_of(work.command), lanes_of(bodies.gains[block])
    curve = lanes_of(bodies.curve[block])
    for j in range(target.size):
        target[j] = thrust_from_command(command[j], curve) * gains[j]
    body, water = _body(block, bodies), _water(block, law, motion)
    gate = lanes_of(motion.gate)[block]
    buffers = _buffers(work)
    deep[0] = 0.0
    for done in range(steps):
        deep[0] = select(state[2] > gate, 1.0, deep[0])
        t = (first[0] + done) * step_s
        middle[0] = t + 0.5 * step_s
        _find_segments(block, motion, work)
        drift = (segment[0], segment[1], segment[2], segment[3], segment[4])
        runge_kutta_step(state, target, (t, step_s), body, (water, drift), buffers)


@njit(cache=True, error_model="numpy", inline="always")
def _find_segments(block: int, motion: Motion, work: Work) -> None:
    for lane in range(LANES):
        if work.moves[lane]:
            found = segment_at(work.middle[0, lane], motion.drift[block * LANES + lane])
            for j in range(len(found)):
                work.segment[j, lane] = found[j]


@njit(cache=True, error_model="numpy", inline="always")
def _buffers(work: Work) -> tuple[Any, ...]:
    """Return `dynamics.Buffers` for lanes."""
    return (
        lanes_of(work.k1),
        lanes_of(work.k2),
        lanes_of(work.k3),
        lanes_of(work.k4),
        lanes_of(work.y),
        lanes_of(work.rotation),
        lanes_of(work.relative),
        lanes_of(work.momentum),
        lanes_of(work.wrench),
    )


@njit(cache=True, error_model="numpy", inline="always")
def _body(block: int, bodies: Bodies) -> Body:
    return Body(
        lanes_of(bodies.mass[block]),
        lanes_of(bodies.inverse_mass[block]),
        lanes_of(bodies.added[block]),
        lanes_of(bodies.linear[block]),
        lanes_of(bodies.quadratic[block]),
        lanes_of(bodies.allocation[block]),
        lanes_of(bodies.net_weight)[block],
        lanes_of(bodies.moment[block]),
        lanes_of(bodies.lag_rate)[block],
    )


@njit(cache=True, error_model="numpy", inline="always")
def _water(block: int, law: int, motion: Motion) -> Water:
    """Return the water of a block; its drift is read vehicle by vehicle."""
    water = lanes_of(motion.water[block])
    return Water(
        law,
        water[0],
        water[1],
        water[2],
        water[3],
        water[4],
        water[5],
        water[6],
        water[7],
        water[8],
        motion.drift[0],
        water[9],
        water[10],
        water[11],
    )
