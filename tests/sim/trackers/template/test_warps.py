"""Laws of the homographies' algebra."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from seamark.sim.trackers.options import WARPS
from seamark.sim.trackers.template import warps

Array = NDArray[np.float64]

steps = st.tuples(*[st.floats(-0.4, 0.4)] * 8).map(np.array)
quick = settings(max_examples=60, deadline=None)


def exponential(d: Array) -> Array:
    out = np.empty((3, 3))
    warps.exponential(d, out)
    return out


@given(d=steps)
@quick
def test_exponential_of_the_opposite_step_is_the_inverse(d: Array) -> None:
    assert exponential(d) @ exponential(-d) == pytest.approx(np.eye(3), abs=1e-12)


@given(d=steps)
@quick
def test_exponential_is_a_power_series(d: Array) -> None:
    x = np.array([[d[0], d[1], d[6]], [d[2], d[3], d[7]], [d[4], d[5], 0.0]])
    term, total = np.eye(3), np.eye(3)
    for k in range(1, 30):
        term = term @ x / k
        total = total + term

    assert exponential(d) == pytest.approx(total, abs=1e-12)


@given(d=steps)
@quick
def test_inverse_undoes_a_homography(d: Array) -> None:
    h, back = exponential(d), np.empty((3, 3))

    warps.inverse(h, back)

    assert h @ back == pytest.approx(np.eye(3), abs=1e-10)


@pytest.mark.parametrize("warp", WARPS)
@given(first=steps, second=steps)
@settings(max_examples=20, deadline=None)
def test_warps_are_closed_under_composition(warp: str, first: Array, second: Array) -> None:
    basis = warps.basis(warp)
    n = basis.shape[1]
    left, right = (exponential(basis @ d[:n]) for d in (first, second))

    product = left @ right

    invariants = {
        "translation": lambda h: np.concatenate([h[:, :2].ravel(), h[2]]) - _IDENTITY,
        "rt": lambda h: [*(h[:2, :2].T @ h[:2, :2] - np.eye(2)).ravel(), *h[2, :2]],
        "srt": lambda h: [h[0, 0] - h[1, 1], h[0, 1] + h[1, 0], *h[2, :2]],
        "affine": lambda h: h[2, :2],
        "homography": lambda h: [0.0 * h[0, 0]],
    }
    assert np.asarray(invariants[warp](product)) == pytest.approx(0.0, abs=1e-10)


_IDENTITY = np.array([1, 0, 0, 1, 0, 0, 0, 0, 1.0])


@given(d=steps, offset=st.tuples(st.floats(-300, 300), st.floats(-300, 300)))
@quick
def test_homography_from_the_unit_square_hits_all_corners(
    d: Array, offset: tuple[float, float]
) -> None:
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    quad, back = np.empty((4, 2)), np.empty((4, 2))
    warps.apply(exponential(0.5 * d), square, quad)
    quad = 80.0 * quad + np.array(offset)
    h = np.empty((3, 3))

    assert warps.from_square(quad, h)
    warps.apply(h, square, back)

    assert back == pytest.approx(quad, abs=1e-7)


@given(seed=st.integers(0, 10**6), n=st.integers(1, 8))
@quick
def test_solve_agrees_with_a_general_solver(seed: int, n: int) -> None:
    generator = np.random.default_rng(seed)
    root = generator.normal(size=(n, n))
    a = root @ root.T + np.eye(n)
    b = generator.normal(size=n)
    x = b.copy()

    assert warps.solve(a.copy(), x)

    assert x == pytest.approx(np.linalg.solve(a, b), abs=1e-8)


def test_a_template_that_shows_nothing_gives_no_step() -> None:
    assert not warps.solve(np.zeros((8, 8)), np.zeros(8))


@given(shift=st.tuples(*[st.floats(-0.2, 0.2)] * 8))
@quick
def test_convex_quadrilaterals_have_a_positive_area_and_mirrored_ones_do_not(
    shift: tuple[float, ...],
) -> None:
    quad = np.array([[0, 0], [1, 0], [1, 1], [0, 1]]) + np.array(shift).reshape(4, 2)

    assert warps.is_convex(quad)
    assert warps.signed_area(quad) > 0
    assert not warps.is_convex(quad[::-1].copy())
    assert warps.signed_area(quad[::-1].copy()) == pytest.approx(-warps.signed_area(quad))
