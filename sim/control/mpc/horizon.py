"""The horizon: what the next moves of the thrusters do to the position, and which are best.

Each axis is a double integrator behind the lag of the thrusters,

    p' = v,   v' = a + d,   a' = (u - a) / lag

with an acceleration u that is asked of the thrusters and a disturbance d that stays. Over the
horizon T the moves u, held over blocks of growing length, minimise

    ∫ w^4 (p - r)² + 2 w² (v - r')² + (u + d - r'')² dt + terminal cost

around the reference r, within the limits of each thruster. u = r'' - d is the target without an
offset (Maeder, Borrelli and Morari 2009, Automatica 45(10); Rawlings, Mayne and Diehl 2017, 1.5 and
2.5); the blocks are those of Cagienard et al. 2007. The terminal cost is that of an endless horizon
without limits and lag, for which the algebraic Riccati equation has a closed form: without lag and
limits the first move is -(w² p + 2 w v + d).
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit

from seamark.sim.control.mpc import qp
from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.compilation import SameTypes
from seamark.sim.numerics.libm import exp

# E: where the blocks of moves end, as shares of the horizon; a change of the next step counts most.
BLOCK_ENDS = (0.025, 0.05, 0.1, 0.2, 0.4, 0.6, 0.8, 1.0)


AxisState = tuple[float, float, float]  # position [m], speed [m/s], acceleration by thrust [m/s²]


class Step(NamedTuple):
    """One control step of an axis, in closed form."""

    dt: float  # [s]
    kept: float  # share of the thrust that is left of the one before
    speed_by_lag: float  # [s] change of speed by a - u
    way_by_lag: float  # [s²] change of position by a - u


class Prediction(NamedTuple):
    """What moves do, and what that costs."""

    step: Step
    lag: float  # [s]
    block_of: Array  # (N,) int64: the block of each control step
    positions: Array  # (N, blocks) [s²] by a move of 1 m/s²
    speeds: Array  # (N, blocks) [s], the last one with what the lag adds after the horizon
    weights: Array  # (N, 3) of p², v² and 2 p v; the last row has the terminal cost, too


class Program(NamedTuple):
    """What does not change from one control step to the next."""

    problem: qp.Problem
    prediction: Prediction
    thrusts: Array  # (m, axes) of each thruster for 1 m/s² of each axis


class Situation(NamedTuple):
    """What the moves start from."""

    states: Array  # (axes, 3) position [m], speed [m/s], acceleration by the present thrust [m/s²]
    disturbances: Array  # (axes,) [m/s²]
    low: Array  # (m,) the least that each thruster can give, in the unit of `thrusts`
    high: Array  # (m,)


@dataclass(frozen=True, slots=True, kw_only=True)
class Tuning:
    """What a horizon is made of."""

    dt: float  # [s] control period
    steps: int  # N control steps
    lag_s: float  # of the thrusters
    bandwidth_1_s: float  # w


@njit(cache=True, error_model="numpy")
def advance(step: Step, state: AxisState, move: float, disturbance: float) -> AxisState:
    """Return position [m], speed [m/s] and acceleration by thrust [m/s²] one step later."""
    position, speed, acceleration = state
    rest, steady = acceleration - move, move + disturbance
    return (
        position + (speed + 0.5 * steady * step.dt) * step.dt + rest * step.way_by_lag,
        speed + steady * step.dt + rest * step.speed_by_lag,
        move + rest * step.kept,
    )


def step_of(dt: float, lag_s: float) -> Step:
    """Return the step of a period and a lag of the thrusters [s]."""
    kept = exp(-dt / lag_s)
    by_lag = lag_s * (1.0 - kept)
    return Step(dt, kept, by_lag, lag_s * (dt - by_lag))


class Horizon:
    """The best moves of several axes that share thrusters; one instance per level.

    A search starts where the last one ended; `reset` forgets it.
    """

    def __init__(self, tuning: Tuning, thrusts: Array) -> None:
        """Prepare the horizon.

        Parameters
        ----------
        thrusts : (m, axes) [1/(m/s²)]
            Thrust of each thruster for an acceleration of 1 m/s² of each axis, in any unit.
        """
        self.step = step_of(tuning.dt, tuning.lag_s)
        prediction = _prediction(tuning, self.step)
        axes, blocks = thrusts.shape[1], prediction.positions.shape[1]
        hessian = _for_all_axes(_hessian(prediction, tuning), axes)
        problem = qp.problem(hessian, _rows(thrusts, blocks))
        self._program = Program(problem, prediction, np.array(thrusts))
        self._found = qp.iterates(problem)
        self._moves = np.zeros(axes)
        self._solve = SameTypes(best_moves)

    def reset(self) -> None:
        """Forget where the last search ended."""
        for values in self._found:
            values[:] = 0.0

    def solve(self, situation: Situation, reference: Array) -> Array:
        """Return the accelerations to ask of the thrusters now, (axes,) [m/s²]; reused.

        Parameters
        ----------
        reference : (axes, N, 3)
            Position, speed and acceleration to have after each control step.
        """
        self._solve.call(self._program, situation, reference, self._found, self._moves)
        return self._moves


def _prediction(tuning: Tuning, step: Step) -> Prediction:
    count = tuning.steps
    ends = sorted({max(round(share * count), 1) for share in BLOCK_ENDS})
    block_of = [sum(at >= end for end in ends) for at in range(count)]
    positions, speeds = np.zeros((count, len(ends))), np.zeros((count, len(ends)))
    for block in range(len(ends)):
        state: AxisState = (0.0, 0.0, 0.0)
        for at in range(count):
            state = advance(step, state, float(block_of[at] == block), 0.0)
            positions[at, block], speeds[at, block] = state[0], state[1]
        speeds[-1, block] += tuning.lag_s * state[2]
    return Prediction(
        step=step,
        lag=tuning.lag_s,
        block_of=np.array(block_of),
        positions=positions,
        speeds=speeds,
        weights=_weights(tuning),
    )


def _weights(tuning: Tuning) -> Array:
    """Return the weights of p², v² and p v at the end of each step, (N, 3)."""
    rate = tuning.bandwidth_1_s
    weights = np.zeros((tuning.steps, 3))
    weights[:, 0], weights[:, 1] = rate**4 * tuning.dt, 2.0 * rate**2 * tuning.dt
    # The solution of the Riccati equation: [[2 w³, w²], [w², 2 w]].
    weights[-1] += (2.0 * rate**3, 2.0 * rate, rate**2)
    return weights


def _hessian(prediction: Prediction, tuning: Tuning) -> Array:
    """Return the Hessian of one axis, (blocks, blocks)."""
    count = prediction.positions.shape[1]
    lengths = [int(np.count_nonzero(prediction.block_of == block)) for block in range(count)]
    hessian = np.zeros((count, count))
    for i in range(count):
        for j in range(count):
            for at, (stiff, damped, mixed) in enumerate(prediction.weights.tolist()):
                p_i, p_j = prediction.positions.item(at, i), prediction.positions.item(at, j)
                v_i, v_j = prediction.speeds.item(at, i), prediction.speeds.item(at, j)
                hessian[i, j] += stiff * p_i * p_j + damped * v_i * v_j
                hessian[i, j] += mixed * (p_i * v_j + v_i * p_j)
        hessian[i, i] += lengths[i] * tuning.dt
    return hessian


def _for_all_axes(hessian: Array, axes: int) -> Array:
    """Return the Hessian of all axes, whose moves do not act on each other."""
    size = len(hessian)
    whole = np.zeros((axes * size, axes * size))
    for axis in range(axes):
        own = slice(axis * size, (axis + 1) * size)
        whole[own, own] = hessian
    return whole


def _rows(thrusts: Array, blocks: int) -> Array:
    """Return the thrust of each thruster in each block by the moves, (blocks m, axes blocks)."""
    count, axes = thrusts.shape
    rows = np.zeros((blocks * count, axes * blocks))
    for block in range(blocks):
        for axis in range(axes):
            rows[block * count : (block + 1) * count, axis * blocks + block] = thrusts[:, axis]
    return rows


def warm_up() -> None:
    """Load the compiled code: one horizon of two axes."""
    tuning = Tuning(dt=0.05, steps=8, lag_s=0.2, bandwidth_1_s=1.0)
    situation = Situation(np.zeros((2, 3)), np.zeros(2), -np.ones(2), np.ones(2))
    Horizon(tuning, np.eye(2)).solve(situation, np.zeros((2, 8, 3)))


@njit(cache=True, error_model="numpy")
def best_moves(
    of: Program, situation: Situation, reference: Array, found: qp.Iterates, moves: Array
) -> None:
    """Write the first move of each axis, (axes,).

    The unknowns are the moves beside the target r'' - d, so the free response is the one to it.
    """
    prediction, thrusts = of.prediction, of.thrusts
    axes, blocks = situation.states.shape[0], prediction.positions.shape[1]
    target, gradient = np.zeros((axes, blocks)), np.zeros(axes * blocks)
    for axis in range(axes):
        disturbance = situation.disturbances[axis]
        _target(prediction, reference[axis], disturbance, target[axis])
        own = gradient[axis * blocks : (axis + 1) * blocks]
        state = situation.states[axis]
        _gradient(prediction, state, disturbance, reference[axis], target[axis], own)
    count = thrusts.shape[0]
    low, high = np.empty(blocks * count), np.empty(blocks * count)
    for row in range(blocks * count):
        block, thruster = row // count, row % count
        wanted = 0.0
        for axis in range(axes):
            wanted += thrusts[thruster, axis] * target[axis, block]
        low[row] = situation.low[thruster] - wanted
        high[row] = situation.high[thruster] - wanted
    qp.solve(of.problem, gradient, low, high, found)
    for axis in range(axes):
        moves[axis] = target[axis, 0] + found.solution[axis * blocks]


@njit(cache=True, error_model="numpy")
def _target(prediction: Prediction, reference: Array, disturbance: float, target: Array) -> None:
    """Write the mean over each block of the move that follows the reference, (blocks,)."""
    lengths = np.zeros(target.size)
    for k in range(reference.shape[0]):
        target[prediction.block_of[k]] += reference[k, 2] - disturbance
        lengths[prediction.block_of[k]] += 1.0
    target /= lengths


@njit(cache=True, error_model="numpy")
def _gradient(
    prediction: Prediction,
    state: Array,
    disturbance: float,
    reference: Array,
    target: Array,
    gradient: Array,
) -> None:
    """Add the gradient of the cost of one axis by its moves beside the target, (blocks,)."""
    steps, weights = reference.shape[0], prediction.weights
    present = (state[0], state[1], state[2])
    for k in range(steps):
        block = prediction.block_of[k]
        present = advance(prediction.step, present, target[block], disturbance)
        late, fast = present[0] - reference[k, 0], present[1] - reference[k, 1]
        if k == steps - 1:
            fast += prediction.lag * (present[2] - target[block])
        by_position = weights[k, 0] * late + weights[k, 2] * fast
        by_speed = weights[k, 1] * fast + weights[k, 2] * late
        for at in range(block + 1):
            gradient[at] += by_position * prediction.positions[k, at]
            gradient[at] += by_speed * prediction.speeds[k, at]
