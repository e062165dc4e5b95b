"""Points of a polyline by arc length, and the nearest one."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.polyline import at_length, nearest, starts_of

CORNER = np.array([[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [3.0, 4.0, 0.0]])
coordinates = st.floats(-10.0, 10.0).map(lambda value: round(value, 3))
polylines = arrays(np.float64, (6, 3), elements=coordinates).filter(
    lambda points: bool((np.abs(np.diff(points, axis=0)).max(axis=1) > 0.1).all())
)


def point_at(points: Array, along: float) -> Array:
    out = np.zeros(6)
    at_length(points, starts_of(points), along, out)
    return out


def test_the_arc_length_at_each_point_is_the_sum_of_the_lines_before_it() -> None:
    assert starts_of(CORNER).tolist() == [0.0, 3.0, 7.0]


def test_two_points_in_a_row_must_not_coincide() -> None:
    with pytest.raises(ValueError, match="must not coincide"):
        starts_of(np.array([[1.0, 2.0, 3.0], [1.0, 2.0, 3.0]]))


@pytest.mark.parametrize(
    ("along", "expected"),
    [
        (1.0, [1.0, 0.0, 0.0, 1.0, 0.0, 0.0]),
        (5.0, [3.0, 2.0, 0.0, 0.0, 1.0, 0.0]),
        (-1.0, [0.0, 0.0, 0.0, 1.0, 0.0, 0.0]),
        (9.0, [3.0, 4.0, 0.0, 0.0, 1.0, 0.0]),
    ],
)
def test_a_place_by_arc_length_is_on_its_line_and_stays_at_the_ends(
    along: float, expected: list[float]
) -> None:
    assert point_at(CORNER, along).tolist() == expected


@given(polylines, arrays(np.float64, 3, elements=coordinates), st.floats(0, 1), st.floats(0, 1))
def test_no_place_of_the_piece_is_nearer_than_the_nearest(
    points: Array, position: Array, one: float, other: float
) -> None:
    starts, out = starts_of(points), np.zeros(6)
    first, last = sorted((one * starts[-1], other * starts[-1]))

    along, off = nearest(points, starts, position, first, last, out)

    assert first - 1e-9 <= along <= last + 1e-9
    assert np.linalg.norm(position - out[:3]) == pytest.approx(off, abs=1e-9)
    assert np.allclose(point_at(points, along)[:3], out[:3], atol=1e-9)
    samples = [point_at(points, place)[:3] for place in np.linspace(first, last, 50)]
    assert off <= min(np.linalg.norm(position - sample) for sample in samples) + 1e-9
