"""Distances between primitives against many sampled points."""

from math import cos, pi, sin, sqrt

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from seamark.sim.multibody.distances import (
    common_stretch,
    middle_of_passage,
    nearest_on_segment,
    nearest_to_ends,
    point_box,
    point_socket,
    rim_direction,
    segments,
    spheres,
)
from seamark.sim.multibody.vectors import across

Point = tuple[float, float, float]
NUMBERS = st.floats(-2.0, 2.0)
POINTS = st.tuples(NUMBERS, NUMBERS, NUMBERS)
HALVES = st.tuples(*[st.floats(0.05, 1.0)] * 3)
SHARES = np.linspace(-1.0, 1.0, 401)
PARALLEL = 1.01e-4  # sine of the angle below which segments count as parallel, and rounding
SOCKET = (0.3, 0.8, 0.1)


def to_box(points: np.ndarray, half: Point) -> np.ndarray:
    """Distances of points outside a box, (k,); zero inside."""
    beyond = np.maximum(np.abs(points) - np.array(half), 0.0)
    made: np.ndarray = np.sqrt((beyond**2).sum(axis=-1))
    return made


@given(p=POINTS, half=HALVES)
def test_a_step_along_the_normal_ends_on_the_surface_of_the_box(p: Point, half: Point) -> None:
    normal, distance = point_box(p, half)

    surface = np.abs(np.array(p) - distance * np.array(normal)) - np.array(half)
    assert np.linalg.norm(normal) == pytest.approx(1.0)
    assert surface.max() == pytest.approx(0.0, abs=1e-9)
    if distance > 1e-9:
        assert distance == pytest.approx(float(to_box(np.array(p), half)))
    else:
        assert distance == pytest.approx((np.abs(p) - np.array(half)).max(), abs=1e-9)


@given(middle=POINTS, along=POINTS, half=HALVES)
def test_the_nearest_point_of_a_segment_is_as_near_to_a_box_as_any_sampled_one(
    middle: Point, along: Point, half: Point
) -> None:
    points = np.array(middle) + SHARES[:, None] * np.array(along)
    for side in (-1.0, 1.0):
        t = nearest_on_segment(middle, along, half, side, False)

        found = float(to_box(np.array(middle) + t * np.array(along), half))
        nearest = to_box(points, half).min()
        assert -1.0 <= t <= 1.0
        # Nearly along a face, the stretch rises by a thousandth of its length.
        assert found <= nearest + 1e-5 + 0.002 * float(np.linalg.norm(along))
        if side < 0.0:
            first = t
    assert first <= t + 1e-5


@given(
    middle=POINTS,
    along=POINTS | st.tuples(NUMBERS, st.just(0.0), st.just(0.0)),
    half=HALVES,
    is_round=st.booleans(),
    share=st.floats(0.1, 0.995),
)
def test_a_segment_that_is_said_to_be_nearest_at_an_end_is_not_nearest_between(
    middle: Point, along: Point, half: Point, is_round: bool, share: float
) -> None:
    between = nearest_to_ends(middle, along, half, share, is_round)

    for side, may_be in zip((-1.0, 1.0), between, strict=True):
        nearest = nearest_on_segment(middle, along, half, side, is_round)
        assert may_be or abs(nearest) > share - 1e-5


@pytest.mark.parametrize(
    ("along", "between"),
    [
        ((0.2, 0.0, 0.3), False),
        ((0.3, 0.0, 1e-4), False),  # along a face, and nearest from one end to the other
        ((2.0, 0.0, 1e-4), True),  # along a face and beyond its edges
    ],
)
def test_a_segment_is_nearest_between_its_ends_only_where_an_edge_is(
    along: Point, between: bool
) -> None:
    found = nearest_to_ends((0.0, 0.0, 1.0), along, (0.5, 0.5, 0.5), 0.99, False)

    assert found == (between, between)


def test_a_segment_along_a_face_is_nearest_from_edge_to_edge() -> None:
    segment = (0.1, 0.0, 0.5), (1.0, 0.0, 0.0), (0.2, 0.2, 0.2)

    ends = [nearest_on_segment(*segment, side, False) for side in (-1.0, 1.0)]

    assert ends == pytest.approx([-0.3, 0.1], abs=0.004)


@given(p=POINTS, along=POINTS, half=HALVES)
def test_a_passage_has_its_middle_in_the_box_and_its_ends_outside(
    p: Point, along: Point, half: Point
) -> None:
    share, passes = middle_of_passage(p, along, half)

    ends = np.array([p, np.array(p) + np.array(along)])
    middle = np.array(p) + share * np.array(along)
    if passes:
        assert (np.abs(middle) - np.array(half)).max() <= 1e-9
        assert (np.abs(ends).max(axis=1) > 0.0).all()
        assert ((np.abs(ends) - np.array(half)).max(axis=1) >= 0.0).all()
    else:
        inner = np.array(p) + np.linspace(0.0, 1.0, 401)[:, None] * np.array(along)
        deep = (np.abs(inner) - np.array(half)).max(axis=1)
        assert deep[0] <= 1e-9 or deep[-1] <= 1e-9 or deep.min() >= -1e-2


# Parallel but for an angle of 1e-5: there the middle counts, and an end is nearer by 1e-5 m.
@example(a=(0.0, 1.0, 0.0), along_a=(1.0, 0.0, 0.0), b=(0.0, 0.0, 0.0), along_b=(1.0, 1e-5, 0.0))
@given(a=POINTS, along_a=POINTS, b=POINTS, along_b=POINTS)
def test_two_segments_are_nowhere_nearer_than_where_they_are_said_to_be(
    a: Point, along_a: Point, b: Point, along_b: Point
) -> None:
    s, t = segments(a, along_a, b, along_b)

    lengths = float(np.linalg.norm(along_a)), float(np.linalg.norm(along_b))
    sine = float(np.linalg.norm(np.cross(along_a, along_b))) / max(lengths[0] * lengths[1], 1e-300)
    middle_counts = 2.0 * min(lengths) * sine if sine < PARALLEL else 0.0
    assert max(abs(s), abs(t)) <= 1.0
    nearest = least(a, along_a, b, along_b)
    assert apart(a, along_a, b, along_b, (s, t)) <= nearest + middle_counts + 1e-6


@given(a=POINTS, along=POINTS, b=POINTS, tilt=POINTS, angle=st.floats(0.0, 0.2))
def test_two_segments_at_a_small_angle_are_nowhere_nearer_either(
    a: Point, along: Point, b: Point, tilt: Point, angle: float
) -> None:
    x, y, z = np.array(along) + angle * np.array(tilt)
    s, t = segments(a, along, b, (x, y, z))

    assert apart(a, along, b, (x, y, z), (s, t)) <= least(a, along, b, (x, y, z)) + 2e-4


def apart(a: Point, along_a: Point, b: Point, along_b: Point, shares: tuple[float, float]) -> float:
    one, two = (
        np.array(p) + k * np.array(u)
        for p, u, k in zip((a, b), (along_a, along_b), shares, strict=True)
    )
    return float(np.linalg.norm(one - two))


def least(a: Point, along_a: Point, b: Point, along_b: Point) -> float:
    """The distance of the nearest of many points of two segments."""
    shares = np.linspace(-1.0, 1.0, 61)
    ones = np.array(a) + shares[:, None] * np.array(along_a)
    twos = np.array(b) + shares[:, None] * np.array(along_b)
    return float(np.linalg.norm(ones[:, None] - twos[None], axis=2).min())


def test_parallel_segments_touch_at_both_ends_and_in_the_middle_of_their_common_stretch() -> None:
    two = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.5, 0.1, 0.0), (2.0, 0.0, 0.0)

    ends, middle = common_stretch(*two), segments(*two)

    assert ends == (pytest.approx(-1.0), pytest.approx(-0.75), 1.0, pytest.approx(0.25), True)
    assert middle == (pytest.approx(0.0), pytest.approx(-0.25))
    assert not common_stretch(*two[:3], (0.0, 2.0, 0.0))[4]


def test_concentric_spheres_and_points_on_an_axis_get_a_fixed_direction() -> None:
    assert spheres((1.0, 2.0, 3.0), 0.1, (1.0, 2.0, 3.0), 0.2)[1] == (0.0, 0.0, -1.0)
    assert point_socket((-0.4, 0.0, 0.0), (0.3, 2.0, 0.1)) == ((0.0, -1.0, 0.0), 0.3)
    assert rim_direction((0.0, 0.0, 5.0), (0.0, 0.0, 1.0)) == across((0.0, 0.0, 1.0))


@given(x=st.floats(-1.0, 0.5), off=st.floats(0.0, 0.8), angle=st.floats(0.0, 2.0 * pi))
def test_a_socket_is_solid_beside_the_bore_and_below_the_chamfer(
    x: float, off: float, angle: float
) -> None:
    radius, depth, chamfer = SOCKET
    normal, distance = point_socket((x, off * cos(angle), off * sin(angle)), SOCKET)

    free = x > 0.0 or (off < radius and x > -depth) or (x > -chamfer and off < radius + chamfer + x)
    edge = min(
        abs(x), abs(off - radius), abs(x + depth), abs(x + radius + chamfer - off) / sqrt(2.0)
    )
    if edge > 1e-9:
        assert (distance > 0.0) == free
    assert np.linalg.norm(normal) == pytest.approx(1.0)


@given(normal=POINTS.filter(lambda p: sum(x * x for x in p) > 1e-3))
def test_the_direction_of_friction_is_across_the_normal(normal: Point) -> None:
    unit = np.array(normal) / np.linalg.norm(normal)

    chosen = np.array(across((unit[0], unit[1], unit[2])))

    assert chosen @ unit == pytest.approx(0.0, abs=1e-12)
    assert np.linalg.norm(chosen) == pytest.approx(1.0)
