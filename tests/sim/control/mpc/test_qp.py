"""The quadratic program of the predictive controller."""

import numpy as np
import pytest
import scipy  # its parts are loaded when they are used
from hypothesis import example, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from seamark.sim.control.mpc import qp
from seamark.sim.numerics.arrays import Array

SIZE, ROWS = 6, 8
SEARCHES = 40  # 20,000 programs like these kept their limits to 0.01 then; after one to 0.35
unit = st.floats(-1.0, 1.0)


def cost(hessian: Array, gradient: Array, at: Array) -> float:
    return float(0.5 * at @ hessian @ at + gradient @ at)


def program(seed: int) -> tuple[Array, Array]:
    random = np.random.default_rng(seed)
    factor = random.normal(size=(SIZE, SIZE))
    return factor @ factor.T + np.eye(SIZE), random.normal(size=(ROWS, SIZE))


@pytest.mark.slow
@given(seed=st.integers(0, 10**6), gradient=arrays(np.float64, SIZE, elements=unit))
@example(seed=0, gradient=np.ones(SIZE))  # slow: 0.06 beyond its limits after one search
@settings(max_examples=30, deadline=None)
def test_a_search_that_goes_on_ends_at_the_optimum_of_scipy(seed: int, gradient: Array) -> None:
    hessian, rows = program(seed)
    gradient = 20.0 * gradient
    made, low, high = qp.problem(hessian, rows), np.full(ROWS, -1.0), np.full(ROWS, 0.7)
    found = qp.iterates(made)
    for _ in range(SEARCHES):
        qp.solve(made, gradient, low, high, found)

    best = scipy.optimize.minimize(
        lambda at: cost(hessian, gradient, at),
        np.zeros(SIZE),
        jac=lambda at: hessian @ at + gradient,
        method="SLSQP",
        constraints=[
            {"type": "ineq", "fun": lambda at: high - rows @ at, "jac": lambda _at: -rows},
            {"type": "ineq", "fun": lambda at: rows @ at - low, "jac": lambda _at: rows},
        ],
    )
    beyond = np.maximum(rows @ found.solution - high, low - rows @ found.solution)
    assert beyond.max() < 0.02
    assert cost(hessian, gradient, found.solution) == pytest.approx(best.fun, rel=0.05, abs=0.02)


def test_where_no_limit_is_reached_the_solution_is_that_without_limits() -> None:
    hessian, rows = program(1)
    gradient, made = np.arange(1.0, SIZE + 1.0), qp.problem(hessian, rows)
    found = qp.iterates(made)

    qp.solve(made, gradient, np.full(ROWS, -1e3), np.full(ROWS, 1e3), found)

    assert found.solution == pytest.approx(np.linalg.solve(hessian, -gradient), rel=1e-9)


def test_limits_that_leave_no_solution_give_a_finite_one() -> None:
    hessian, rows = program(2)
    rows[1] = rows[0]
    low, high = np.full(ROWS, -1.0), np.full(ROWS, 1.0)
    low[0], high[1] = 0.5, -0.5  # the same row at once above and below
    made = qp.problem(hessian, rows)
    found = qp.iterates(made)

    for _ in range(200):
        qp.solve(made, np.ones(SIZE), low, high, found)

    assert np.isfinite(found.solution).all()
    assert abs(rows[0] @ found.solution) < 0.5


def test_a_search_that_goes_on_comes_nearer_to_the_optimum() -> None:
    hessian, rows = program(3)
    made, gradient = qp.problem(hessian, rows), np.full(SIZE, -30.0)
    found, beyond = qp.iterates(made), []

    for _ in range(4):
        qp.solve(made, gradient, np.full(ROWS, -1.0), np.full(ROWS, 1.0), found)
        beyond.append(float(np.abs(rows @ found.solution).max()) - 1.0)

    assert beyond[-1] < 1e-4
    assert beyond[-1] <= beyond[0]
