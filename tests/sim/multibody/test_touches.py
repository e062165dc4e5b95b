"""Contacts between whole shapes: none is missed or invented, and each is as deep as it is."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from seamark.sim.multibody.contacts import MARGIN_M, Touches, find_touches, place_shapes
from seamark.sim.multibody.mechanism import Link, Mechanism, Point, Shape, state_for, work_for
from seamark.sim.multibody.tree import place
from seamark.sim.numerics.arrays import Array
from tests.sim.multibody.scenes import GROUND, STEP_S

CENTRE = np.array([0.0, 0.0, 5.0])
SEEDS = st.integers(0, 2**32)


def rng(seed: int) -> np.random.Generator:
    return np.random.Generator(np.random.PCG64(seed))


def turned(quaternion: Array) -> Array:
    """The rotation of a unit quaternion w x y z."""
    w, x, y, z = quaternion
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    made: Array = np.eye(3) + 2.0 * w * skew + 2.0 * skew @ skew
    return made


def pose(source: np.random.Generator, centre: Array) -> tuple[Array, Array]:
    """Coordinates of a free link turned at random, and its rotation."""
    quaternion = source.standard_normal(4)
    quaternion /= np.linalg.norm(quaternion)
    return np.concatenate([centre, quaternion]), turned(quaternion)


def point(values: Array) -> Point:
    x, y, z = values.tolist()
    return x, y, z


def touches(other: Shape, moving: Shape, q: Array) -> Touches:
    """The contacts of a shape that a free link carries with one of the world."""
    link = Link(name="link", rigid=np.eye(6))
    pair = (moving.name, other.name)
    model = Mechanism(links=[link], shapes=[other, moving], pairs=[pair]).model(STEP_S)
    state, work = state_for(model), work_for(model)
    state.q[:] = q
    place(model.structure, model.links, state.q, work.frames)
    place_shapes(model.shapes, work.frames, work.touches)
    find_touches(model.shapes, GROUND, work.touches)
    return work.touches


def distance_of_boxes(one: Array, turn: Array, away: Array, other: Array) -> float:
    """How far two boxes are apart along the best of fifteen axes; negative if they overlap."""
    axes = [*turn.T, *np.eye(3)]
    axes += [np.cross(a, b) for a, b in product(turn.T, np.eye(3))]
    return max(
        float(abs(axis @ away) - np.abs(turn.T @ axis) @ one - np.abs(axis) @ other)
        for axis in (axis / np.linalg.norm(axis) for axis in axes if np.linalg.norm(axis) > 1e-9)
    )


@given(seed=SEEDS)
def test_boxes_touch_if_they_overlap_and_only_then_and_are_pushed_apart(seed: int) -> None:
    source = rng(seed)
    one, other = source.uniform(0.03, 0.3, (2, 3))
    away = 0.25 * source.standard_normal(3)
    q, turn = pose(source, CENTRE + away)

    found = touches(
        Shape(name="other", kind="box", place=point(CENTRE), size=point(other)),
        Shape(name="box", kind="box", link="link", size=point(one)),
        q,
    )

    apart = distance_of_boxes(one, turn, away, other)
    if abs(apart) > 1e-9:
        assert (found.gap.min() < 0.0) == (apart < 0.0)
    if -0.01 < apart < 0.0:
        assert found.normal[found.gap < 0.0].sum(axis=0) @ away > 0.0
        assert found.gap.min() > 1.001 * apart - 1e-9


@given(seed=SEEDS)
def test_the_lowest_point_of_a_cylinder_touches_the_ground(seed: int) -> None:
    source = rng(seed)
    radius, half = source.uniform(0.02, 0.2, 2)
    q, turn = pose(source, np.array([0.1, 0.2, GROUND.depth - source.uniform(0.0, 0.3)]))

    found = touches(
        Shape(name="ground", kind="ground"),
        Shape(name="cylinder", kind="cylinder", link="link", size=(radius, half, 0.0)),
        q,
    )

    lowest = q[2] + abs(turn[2, 0]) * half + radius * np.hypot(turn[2, 1], turn[2, 2])
    gap = GROUND.depth - lowest
    assert abs(found.gap.min() - gap) < 1e-12 or min(gap, found.gap.min()) > MARGIN_M


@given(seed=SEEDS)
def test_a_rod_is_as_far_from_a_box_as_the_nearest_of_its_points(seed: int) -> None:
    source = rng(seed)
    radius, half = source.uniform(0.01, 0.05), source.uniform(0.0, 0.3)
    size, away = source.uniform(0.03, 0.3, 3), 0.25 * source.standard_normal(3)
    q, turn = pose(source, CENTRE + away)

    found = touches(
        Shape(name="box", kind="box", place=point(CENTRE), size=point(size)),
        Shape(name="rod", kind="capsule", link="link", size=(radius, half, 0.0)),
        q,
    )

    along = away + np.linspace(-half, half, 2001)[:, None] * turn[:, 0]
    axis = float(np.linalg.norm(np.maximum(np.abs(along) - size, 0.0), axis=1).min())
    if abs(axis - radius) < 0.5 * MARGIN_M and axis > 0.002:
        assert abs(found.gap.min() - (axis - radius)) < 1e-4


@given(seed=SEEDS)
def test_a_rod_is_as_far_from_a_cylinder_as_the_nearest_of_its_points(seed: int) -> None:
    source = rng(seed)
    radius, half = source.uniform(0.01, 0.05), source.uniform(0.0, 0.3)
    size, away = source.uniform(0.02, 0.2, 2), 0.2 * source.standard_normal(3)
    q, turn = pose(source, CENTRE + away)

    found = touches(
        Shape(name="cylinder", kind="cylinder", place=point(CENTRE), size=(size[0], size[1], 0.0)),
        Shape(name="rod", kind="capsule", link="link", size=(radius, half, 0.0)),
        q,
    )

    along = away + np.linspace(-half, half, 2001)[:, None] * turn[:, 0]
    past = np.maximum(np.abs(along[:, 0]) - size[1], 0.0)
    beside = np.maximum(np.hypot(along[:, 1], along[:, 2]) - size[0], 0.0)
    axis = float(np.hypot(past, beside).min())
    if abs(axis - radius) < 0.5 * MARGIN_M and axis > 0.002:
        assert abs(found.gap.min() - (axis - radius)) < 1e-4
        deepest = int(found.gap.argmin())
        nearer = along - (found.point[deepest] - CENTRE + radius * found.normal[deepest])
        assert np.linalg.norm(nearer, axis=1).min() < 2e-3  # it is on the rod's axis


@pytest.mark.slow
@given(seed=SEEDS)
def test_a_peg_that_leans_is_as_far_from_a_hole_as_the_nearest_of_its_points(
    seed: int,
) -> None:
    source = rng(seed)
    radius, half, depth = 0.01, 0.05, 0.06
    bore, chamfer = 0.011 + source.uniform(0.0, 0.004), 0.004 * source.integers(0, 2)
    tilt, towards = source.uniform(0.0, 0.2), source.uniform(0.0, 2.0 * np.pi)
    # It points into the hole, -x, and is turned about an axis across x.
    w, s = np.cos(0.5 * tilt), np.sin(0.5 * tilt)
    axis = -turned(np.array([w, 0.0, s * np.cos(towards), s * np.sin(towards)]))[:, 0]
    off, where = (bore - radius) * source.uniform(0.0, 1.1), source.uniform(0.0, 2.0 * np.pi)
    tip = np.array([source.uniform(-0.061, 0.001), off * np.cos(where), off * np.sin(where)])
    centre = tip - half * axis
    q = np.array([*(CENTRE + centre), w, 0.0, s * np.cos(towards), s * np.sin(towards)])

    found = touches(
        Shape(name="hole", kind="socket", place=point(CENTRE), size=(bore, depth, chamfer)),
        Shape(name="peg", kind="cylinder", link="link", size=(radius, half, 0.0)),
        q,
    )

    across = np.linalg.svd(axis[None])[2][1:]
    angle = np.linspace(0.0, 2.0 * np.pi, 240, endpoint=False)
    ring = radius * (np.cos(angle)[:, None] * across[0] + np.sin(angle)[:, None] * across[1])
    side = centre + np.linspace(-half, half, 401)[:, None, None] * axis + ring
    end = tip + np.linspace(0.0, 1.0, 11)[:, None, None] * ring
    x, y, z = np.concatenate([side.reshape(-1, 3), end.reshape(-1, 3)]).T
    off_axis = np.hypot(y, z)
    wall = np.maximum(
        np.maximum(x, bore - off_axis), (x + bore + chamfer - off_axis) / np.sqrt(2.0)
    )
    nearest = float(np.minimum(wall, x + depth).min())
    if -3e-4 < nearest < 2e-4:
        assert abs(found.gap.min() - nearest) < 1.5e-4
