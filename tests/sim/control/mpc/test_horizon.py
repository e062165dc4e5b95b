"""The horizon of the predictive controller: what it predicts, and what its first move does."""

import math
from collections.abc import Callable

import numpy as np
import pytest

from seamark.sim.control.mpc.horizon import (
    AxisState,
    Horizon,
    Situation,
    Tuning,
    advance,
    step_of,
)
from seamark.sim.numerics.arrays import Array
from tests.services.prepared import printed
from tests.sim.oldest_processor import printed_here

TUNING = Tuning(dt=0.05, steps=40, lag_s=0.2, bandwidth_1_s=2.0)
ONE = np.ones((1, 1))  # one axis with a thruster of its own, which gives 1 m/s² for 1
Reference = Callable[[float], tuple[float, float, float]]  # time [s] -> position and derivatives

BITS = """
import hashlib
import numpy as np
from seamark.sim.control.mpc.horizon import Horizon, Situation, Tuning

thrusts = np.array([[0.7, 0.7], [0.7, -0.7], [-0.6, 0.8], [-0.6, -0.8]])
horizon = Horizon(Tuning(dt=0.05, steps=40, lag_s=0.2, bandwidth_1_s=2.0), thrusts)
random, total = np.random.default_rng(1), hashlib.sha256()
for _ in range(50):
    states, water = random.normal(size=(2, 3)), random.normal(size=2)
    situation = Situation(states, water, np.full(4, -0.8), np.full(4, 1.0))
    total.update(horizon.solve(situation, 0.3 * random.normal(size=(2, 40, 3))).tobytes())
print(total.hexdigest())
"""


def station(_time: float) -> tuple[float, float, float]:
    return 0.0, 0.0, 0.0


def solve(
    horizon: Horizon, state: AxisState, disturbance: float, reference: Array, limit: float
) -> float:
    low, high = np.full(1, -limit), np.full(1, limit)
    situation = Situation(np.array([state]), np.array([disturbance]), low, high)
    return horizon.solve(situation, reference[np.newaxis]).item()


def driven(
    reference: Reference,
    *,
    start: AxisState = (0.0, 0.0, 0.0),
    disturbance: float = 0.0,
    limit: float = 1e3,
    preview: bool = True,
) -> list[tuple[float, float]]:
    """Return position [m] and move [m/s²] of each of 400 steps of the vehicle that is predicted."""
    horizon, state, way = Horizon(TUNING, ONE), start, []
    for at in range(400):
        times = [TUNING.dt * (at + (k + 1 if preview else 0)) for k in range(TUNING.steps)]
        ahead = np.array([reference(time) for time in times])
        move = solve(horizon, state, disturbance, ahead, limit)
        state = advance(horizon.step, state, min(max(move, -limit), limit), disturbance)
        way.append((state[0], move))
    return way


def test_a_step_agrees_with_many_small_ones() -> None:
    position, speed, acceleration = 0.3, -0.2, 0.5
    parts = 20_000
    for _ in range(parts):
        dt = 0.05 / parts
        position += speed * dt
        speed += (acceleration + 0.1) * dt
        acceleration += (-0.7 - acceleration) / 0.2 * dt

    found = advance(step_of(0.05, 0.2), (0.3, -0.2, 0.5), -0.7, 0.1)

    assert found == pytest.approx((position, speed, acceleration), abs=1e-5)


def test_without_lag_and_limits_the_first_move_is_that_of_the_regulator() -> None:
    tuning = Tuning(dt=0.01, steps=200, lag_s=0.001, bandwidth_1_s=0.5)

    move = solve(Horizon(tuning, ONE), (0.4, 0.2, 0.0), 0.3, np.zeros((200, 3)), 1e3)

    assert move == pytest.approx(-(0.25 * 0.4 + 1.0 * 0.2 + 0.3), rel=0.01)


def test_a_steady_disturbance_leaves_no_offset() -> None:
    way = driven(station, start=(0.4, 0.0, 0.0), disturbance=0.3)

    assert way[-1][0] == pytest.approx(0.0, abs=1e-6)
    assert way[-1][1] == pytest.approx(-0.3, abs=1e-6)


def test_what_the_thrusters_cannot_give_is_not_asked_for_and_the_station_is_reached() -> None:
    way = driven(station, start=(2.0, 0.0, 0.0), limit=0.4)

    assert max(abs(move) for _position, move in way) < 0.4 * 1.03
    assert min(position for position, _move in way) > -0.05
    assert abs(way[-1][0]) < 1e-3


def test_a_limit_makes_it_brake_earlier_than_the_same_law_that_is_cut_off() -> None:
    horizon, state, way = Horizon(TUNING, ONE), (2.0, 0.0, 0.0), []
    for _ in range(400):
        move = solve(horizon, state, 0.0, np.zeros((TUNING.steps, 3)), 1e3)
        state = advance(horizon.step, state, min(max(move, -0.2), 0.2), 0.0)
        way.append(state[0])

    planned = driven(station, start=(2.0, 0.0, 0.0), limit=0.2)

    assert min(position for position, _move in planned) > 0.5 * min(way)


def test_it_follows_a_reference_that_it_sees_ahead() -> None:
    def swinging(time: float) -> tuple[float, float, float]:
        return math.sin(time), math.cos(time), -math.sin(time)

    def error(*, preview: bool) -> float:
        way = driven(swinging, start=(0.0, 1.0, 0.0), preview=preview)
        late = [(TUNING.dt * (at + 1), position) for at, (position, _) in enumerate(way)][200:]
        return max(abs(position - math.sin(time)) for time, position in late)

    assert error(preview=True) < 0.02
    assert error(preview=True) < 0.1 * error(preview=False)


def test_axes_that_share_a_thruster_share_its_limit() -> None:
    both = np.array([[1.0, 1.0], [1.0, -1.0]])
    horizon = Horizon(TUNING, both)
    low, high = np.full(2, -0.5), np.full(2, 0.5)
    states = np.array([[-1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]])
    situation = Situation(states, np.zeros(2), low, high)

    for _ in range(20):
        moves = horizon.solve(situation, np.zeros((2, TUNING.steps, 3)))

    assert moves.sum() == pytest.approx(0.5, abs=0.01)
    assert moves.item(0) == pytest.approx(moves.item(1), abs=0.01)


def test_it_gives_the_same_bits_as_on_the_oldest_processor() -> None:
    assert printed_here(BITS) == printed(BITS, on="oldest")
