"""The motion of a block: eight vehicles side by side, by the functions that move a single one."""

from typing import NamedTuple

import numpy as np
from numba import njit

from seamark.sim.fleet.tables import WATER_NUMBERS, Bodies, Motion
from seamark.sim.numerics.arrays import Array, Flags
from seamark.sim.numerics.borrowed import borrowed
from seamark.sim.numerics.lanes import LANES, lanes_of, select
from seamark.sim.physics.current import SEGMENT, Water, segment_at, segment_of
from seamark.sim.physics.dynamics import RIGID, Body, Buffers, runge_kutta_step
from seamark.sim.physics.thrusters import thrust_from_command

TOP, SPACING = WATER_NUMBERS.index("top"), WATER_NUMBERS.index("spacing")


class Work(NamedTuple):
    """Memory of one thread."""

    state: Array  # (13 + k, 8)
    command: Array  # (k, 8)
    target: Array  # (k, 8) [N] steady thrusts
    first: Array  # (1, 8) physics steps since the level began
    middle: Array  # (1, 8) [s] the middle of the physics step
    segment: Array  # (1, SEGMENT, 8), see current.Segment
    deep: Array  # (1, 8) whether the vehicle came below its gate: 0 or 1
    moves: Flags  # (8,) which vehicles are advanced
    buffers: Buffers  # each with a last index of 8


@njit(cache=True, error_model="numpy")
def work_for(size: int) -> Work:
    """Return the memory for states of this size."""
    thrusters = size - RIGID
    return Work(
        state=np.zeros((size, LANES)),
        command=np.zeros((thrusters, LANES)),
        target=np.zeros((thrusters, LANES)),
        first=np.zeros((1, LANES)),
        middle=np.zeros((1, LANES)),
        segment=np.zeros((1, SEGMENT, LANES)),
        deep=np.zeros((1, LANES)),
        moves=np.zeros(LANES, np.bool_),
        buffers=Buffers(
            k1=np.zeros((size, LANES)),
            k2=np.zeros((size, LANES)),
            k3=np.zeros((size, LANES)),
            k4=np.zeros((size, LANES)),
            y=np.zeros((size, LANES)),
            rotation=np.zeros((3, 3, LANES)),
            relative=np.zeros((6, LANES)),
            momentum=np.zeros((6, LANES)),
            wrench=np.zeros((6, LANES)),
        ),
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
    buffers = lanes_of(work.buffers)
    deep[0] = 0.0
    for done in range(steps):
        deep[0] = select(state[2] > gate, 1.0, deep[0])
        t = (first[0] + done) * step_s
        middle[0] = t + 0.5 * step_s
        _find_segments(block, law, motion, work)
        piece = segment_of(segment, 0)
        runge_kutta_step(state, target, (t, step_s), body, (water, piece), buffers)


@njit(cache=True, error_model="numpy", inline="always")
def _find_segments(block: int, law: int, motion: Motion, work: Work) -> None:
    numbers = motion.water[block]
    for lane in range(LANES):
        if work.moves[lane]:
            grid, drift = (numbers[TOP, lane], numbers[SPACING, lane]), motion.drift
            t, depth = work.middle[0, lane], work.state[2, lane]
            piece = segment_at(t, depth, law, grid, drift[block * LANES + lane])
            for j in range(len(piece)):
                work.segment[0, j, lane] = piece[j]


@njit(cache=True, error_model="numpy", inline="always")
def _body(block: int, bodies: Bodies) -> Body:
    return Body(
        mass=lanes_of(bodies.mass[block]),
        inverse_mass=lanes_of(bodies.inverse_mass[block]),
        added=lanes_of(bodies.added[block]),
        linear=lanes_of(bodies.linear[block]),
        quadratic=lanes_of(bodies.quadratic[block]),
        allocation=lanes_of(bodies.allocation[block]),
        net_weight=lanes_of(bodies.net_weight)[block],
        moment=lanes_of(bodies.moment[block]),
        lag_rate=lanes_of(bodies.lag_rate)[block],
    )


@njit(cache=True, error_model="numpy", inline="always")
def _water(block: int, law: int, motion: Motion) -> Water:
    """Return the water of a block; its drift is read vehicle by vehicle."""
    return water_of(lanes_of(motion.water[block]), law, motion.drift[0])


@njit(cache=True, error_model="numpy", inline="always")
def water_of(numbers: Array, law: int, drift: Array) -> Water:
    """Return the water with these `tables.WATER_NUMBERS`: of one vehicle, or of lanes of them."""
    return Water(
        law=law,
        level=numbers[0],
        azimuth=numbers[1],
        azimuth_swing=numbers[2],
        azimuth_rate=numbers[3],
        speed_swing=numbers[4],
        speed_rate=numbers[5],
        force=numbers[6],
        azimuth_phase=numbers[7],
        speed_phase=numbers[8],
        drift=drift,
        shear=numbers[9],
        bottom=numbers[10],
        height=numbers[11],
        top=numbers[12],
        spacing=numbers[13],
    )
