"""Thrust allocation under limits."""

import numpy as np
import pytest
import scipy  # its parts are loaded when they are used
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from seamark.sim.control.allocation import allocate_within
from seamark.sim.numerics.arrays import Array
from seamark.sim.registry import VEHICLES
from seamark.sim.vehicles import load

accelerations = arrays(np.float64, 6, elements=st.floats(-2.0, 2.0))
REGULARISATION = 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("name", VEHICLES)
@given(wanted=accelerations)
def test_it_finds_the_bounded_least_squares_solution_of_scipy(name: str, wanted: Array) -> None:
    vehicle = load(name)
    count = len(vehicle.thrusters)
    mass = vehicle.mass_rigid() + vehicle.mass_added()
    effect = np.linalg.inv(mass) @ vehicle.allocation()
    forward, reverse = vehicle.curve.limits.value
    lowest, highest = np.full(count, -reverse), np.full(count, forward)
    thrust = np.zeros(count)

    hessian = effect.T @ effect + REGULARISATION * np.eye(count)
    allocate_within(hessian, effect.T @ wanted, lowest, highest, thrust)

    stacked = np.concatenate([effect, np.sqrt(REGULARISATION) * np.eye(count)])
    target = np.concatenate([wanted, np.zeros(count)])
    found = scipy.optimize.lsq_linear(stacked, target, (lowest, highest), tol=1e-12)
    assert np.all((lowest <= thrust) & (thrust <= highest))
    assert effect @ thrust == pytest.approx(effect @ found.x, abs=0.01)
    assert np.linalg.norm(stacked @ thrust - target) <= np.sqrt(2.0 * found.cost) + 1e-3
