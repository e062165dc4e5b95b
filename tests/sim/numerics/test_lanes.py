"""Eight numbers side by side have the bits of each of them alone."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from numba import njit
from numpy.typing import NDArray

from seamark.sim.numerics.lanes import LANES, lanes_of, like, select, some
from seamark.sim.numerics.libm import exp, log, sin
from seamark.sim.physics.thrusters import pack_curve, thrust_from_command
from seamark.sim.vehicles import load

Array = NDArray[np.float64]
SPECIAL = [0.0, -0.0, math.inf, -math.inf, math.nan, 5e-324, 1e-310, 709.8, -745.2, 1e6, 1.1e6]


def numbers() -> Array:
    random = np.random.Generator(np.random.PCG64(1))
    parts = [random.uniform(-size, size, 4000) for size in (4.0, 800.0, 1e6)]
    values = np.concatenate([*parts, np.abs(parts[1]) * 1e-300, SPECIAL])
    return values[len(values) % LANES :].reshape(-1, LANES)


@njit(error_model="numpy")
def _arithmetic(x: float) -> float:
    total = 0.0
    for k in range(3):
        total += (x - 2) / (k + abs(x)) * -x
    return total + select((x > 1.0) & (x <= 3.0) | (x != x), 1.0, like(x, 2.0))  # noqa: PLR0124


def bits(values: Array) -> NDArray[np.int64]:
    """The bits, with one kind of nan: its sign and payload are not defined."""
    return np.where(np.isnan(values), math.nan, values).view(np.int64)


@pytest.mark.slow
@pytest.mark.parametrize("function", [_arithmetic, sin, exp, log])
def test_a_function_of_lanes_gives_the_bits_of_each_number(
    function: Callable[[float], float],
) -> None:
    @njit
    def of_lanes(values: Array, out: Array) -> None:
        source, results = lanes_of(values), lanes_of(out)
        for i in range(source.size):
            results[i] = function(source[i])

    values = numbers()
    out = np.empty_like(values)
    of_lanes(values, out)

    alone = [function(value) for value in values.ravel().tolist()]
    np.testing.assert_array_equal(bits(out.ravel()), bits(np.array(alone)))


@pytest.mark.slow
def test_thrusters_of_different_vehicles_in_one_block_keep_their_own_curves() -> None:
    @njit
    def of_lanes(commands: Array, curves: Array, out: Array) -> None:
        lanes_of(out)[0] = thrust_from_command(lanes_of(commands)[0], lanes_of(curves))

    names = ["girona500", "bluerov2-heavy"] * (LANES // 2)
    curves = np.array([pack_curve(load(name).curve) for name in names])
    for command in np.linspace(-1.2, 1.2, 49).tolist():
        commands, out = np.full((1, LANES), command), np.empty((1, LANES))
        of_lanes(commands, np.ascontiguousarray(curves.T), out)

        alone = [thrust_from_command(command, curve) for curve in curves]
        np.testing.assert_array_equal(bits(out[0]), bits(np.array(alone)))


def test_some_lane_is_enough() -> None:
    @njit
    def any_above(values: Array, limit: float) -> bool:
        return some(lanes_of(values)[0] > limit)

    values = np.arange(LANES, dtype=float)[None]

    assert any_above(values, LANES - 1.5)
    assert not any_above(values, LANES - 0.5)
