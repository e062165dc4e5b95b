"""The bottom: mounds where they should be, beams that meet them, hulls that rest on them."""

from dataclasses import replace

import numba
import numpy as np
import pybullet
import pytest
from hypothesis import given
from hypothesis import strategies as st

from seamark.sim.multibody.hull import Hull
from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.random_streams import streams
from seamark.sim.physics import terrain as module
from seamark.sim.physics.bullet import CELL_M
from seamark.sim.physics.contact import Contact
from seamark.sim.physics.current import Current
from seamark.sim.physics.plant import Plant
from seamark.sim.physics.terrain import (
    REACH_M,
    Bottom,
    Relief,
    cast_ray,
    draw_relief,
    height_and_slope,
)
from seamark.sim.recording.telemetry import INDEX
from seamark.sim.sensors.altimeter import Altimeter
from seamark.sim.sensors.dvl import Dvl
from seamark.sim.vehicles import Quantity, Vehicle, load
from tests.sim.conftest import RunOf
from tests.sim.sampling import Truth, sample

DEPTH = 5.0
RELIEF = draw_relief(streams(7, 0, 0).bottom, height_m=0.6, flat_m=2.0)
HILLY = Bottom(DEPTH, RELIEF)
MOUNDS = HILLY._mounds
assert MOUNDS is not None
positions = st.floats(-25.0, 25.0)


def depth_at(north: float, east: float) -> float:
    """Return the depth of the hilly bottom at a position [m]."""
    return DEPTH - float(height_and_slope(north, east, MOUNDS)[0])


def hit(start: Array, way: Array) -> float:
    unit = way / np.linalg.norm(way)
    far, _facing = cast_ray(tuple(start.tolist()), tuple(unit.tolist()), MOUNDS)
    return far


@given(north=positions, east=positions)
def test_mounds_stay_between_flat_and_their_height(north: float, east: float) -> None:
    depth, away = depth_at(north, east), np.hypot(north, east)

    assert DEPTH - 0.6 <= depth <= DEPTH
    assert HILLY.top_m <= depth
    if away <= 2.0 or away >= REACH_M:
        assert depth == DEPTH


def test_mounds_cover_most_of_the_height_that_they_may_have() -> None:
    depths = HILLY.grid(0.5)

    assert depths.shape == (81, 81)
    assert depths.min() < DEPTH - 0.4
    assert (depths < DEPTH - 0.1).mean() > 0.5


@given(north=positions, east=positions)
def test_slopes_are_those_of_the_heights_and_within_the_bound(north: float, east: float) -> None:
    step = 1e-6
    _height, slope_x, slope_y = height_and_slope(north, east, MOUNDS)

    ahead, behind = (height_and_slope(north + d, east, MOUNDS)[0] for d in (step, -step))
    right, left = (height_and_slope(north, east + d, MOUNDS)[0] for d in (step, -step))

    assert slope_x == pytest.approx((ahead - behind) / (2 * step), abs=1e-5)
    assert slope_y == pytest.approx((right - left) / (2 * step), abs=1e-5)
    assert np.hypot(slope_x, slope_y) <= MOUNDS.steepest


@given(north=positions, east=positions, side=st.tuples(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0)))
def test_a_ray_ends_on_the_bottom_and_meets_nothing_before(
    north: float, east: float, side: tuple[float, float]
) -> None:
    start, way = np.array([north, east, 1.5]), np.array([*side, 1.0])
    far = hit(start, way)

    along = start[:, None] + (way / np.linalg.norm(way))[:, None] * np.linspace(0.0, far, 50)
    gaps = [depth_at(x, y) - z for x, y, z in along.T]

    assert min(gaps[:-1]) > 0.0
    assert gaps[-1] == pytest.approx(0.0, abs=1e-6)


def test_a_ray_into_open_water_meets_nothing() -> None:
    start = np.array([0.0, 0.0, 1.0])

    assert [hit(start, np.array(way)) for way in ([0.0, 0.0, -1.0], [1.0, 0.0, 0.01])] == [
        np.inf
    ] * 2


def test_rays_are_those_of_bullet_but_for_the_size_of_its_triangles() -> None:
    world = pybullet.connect(pybullet.DIRECT)
    heights = -HILLY.grid(CELL_M)[:, ::-1]
    field = pybullet.createCollisionShape(
        pybullet.GEOM_HEIGHTFIELD,
        meshScale=[CELL_M, CELL_M, 1.0],
        heightfieldData=heights.T.ravel().tolist(),
        numHeightfieldRows=len(heights),
        numHeightfieldColumns=len(heights),
        physicsClientId=world,
    )
    middle = [0.0, 0.0, -0.5 * float(heights.min() + heights.max())]
    pybullet.createMultiBody(0, field, -1, middle, [1.0, 0.0, 0.0, 0.0], physicsClientId=world)
    draw = np.random.Generator(np.random.PCG64(1))
    starts = np.column_stack([draw.uniform(-12, 12, (300, 2)), np.full(300, 1.5)])
    ways = np.column_stack([draw.uniform(-0.9, 0.9, (300, 2)), np.ones(300)])

    answers = pybullet.rayTestBatch(
        starts.tolist(), (starts + 10.0 * ways).tolist(), physicsClientId=world
    )
    pybullet.disconnect(world)
    theirs = [
        np.linalg.norm(np.array(answer[3]) - start)
        for answer, start in zip(answers, starts, strict=True)
    ]
    ours = [hit(start, way) for start, way in zip(starts, ways, strict=True)]

    assert ours == pytest.approx(theirs, abs=0.01)


def test_a_flat_bottom_sounds_as_deep_as_it_is() -> None:
    assert Bottom(DEPTH).sound([3.0, 4.0, 1.6, 0.3, 0.2, 0.1]) == (DEPTH - 1.6, 4)
    level = Bottom(DEPTH, replace(RELIEF, height_m=0.0)).sound([3.0, 4.0, 1.6, 0.3, 0.2, 0.1])
    assert level.altitude == pytest.approx(DEPTH - 1.6, abs=1e-6)


def test_beams_of_a_steep_vehicle_give_no_echo_and_the_dvl_loses_the_bottom() -> None:
    upright, steep = ([8.0, 3.0, 1.6, roll, 0.0, 0.0] for roll in (0.0, 1.2))
    near, lost = HILLY.sound(upright), HILLY.sound(steep)

    assert (near.echoes, lost.echoes <= 2) == (4, True)
    for device in (Dvl(streams(1, 0, 0).dvl), Altimeter(streams(1, 0, 0).altimeter)):
        still = [0.0] * 6
        assert sample(device, 0, Truth(upright, still, *near))[1]
        assert not sample(device, 20, Truth(upright, still, near.altitude, 2))[1]


def pressing(vehicle: Vehicle) -> Vehicle:
    weight = vehicle.weight.scalar - 50.0
    buoyancy = Quantity(meaning="test", value=(weight,), unit="N", tag="E", source="test")
    return replace(vehicle, buoyancy=buoyancy)


@pytest.mark.parametrize(("north", "east"), [(6.0, 2.0), (-9.0, 5.0), (30.0, 0.0), (0.0, -40.0)])
def test_a_vehicle_rests_on_the_mounds_and_on_the_flat_beyond(north: float, east: float) -> None:
    vehicle = pressing(load("bluerov2-heavy"))
    contact = Contact(vehicle, HILLY, engine=Hull)
    plant = Plant(vehicle, Current(0.0), contact=contact)
    above = depth_at(north, east) - 0.5 * 0.2539
    plant.reset(np.array([north, east, above - 0.3, 0.0, 0.0, 0.0]))

    plant.advance(0, np.zeros(8), 1500)
    x, y, z, *_angles = plant.pose()
    plant.advance(1500, np.zeros(8), 500)
    contact.close()

    assert z == pytest.approx(depth_at(x, y) - 0.5 * 0.2539, abs=0.06)
    assert plant.contact_force() == pytest.approx(50.0, rel=0.05)


def test_a_run_over_mounds_repeats_and_differs_from_one_over_the_flat(run_short: RunOf) -> None:
    hilly = {"seabed_relief_m": 0.8, "seabed_flat_radius_m": 0.5, "tracker": "truth"}
    first, rows = run_short(hilly)
    second, _rows = run_short(hilly)
    flat, _rows = run_short(hilly | {"seabed_relief_m": 0.0})

    assert first.digest == second.digest != flat.digest
    assert np.isfinite(rows).all()
    assert rows[:, INDEX["distance"]].max() < 1.0


def test_the_mounds_are_the_same_in_all_levels_and_others_in_another_trial() -> None:
    drawn = [
        draw_relief(streams(*key).bottom, height_m=0.5, flat_m=2.0).waves.tobytes()
        for key in ((5, 0, 0), (5, 0, 3), (5, 1, 0), (6, 0, 0))
    ]

    assert drawn[0] == drawn[1]
    assert len(set(drawn)) == 3


def test_the_machine_code_of_a_beam_has_no_fused_operations() -> None:
    kernel = numba.njit(error_model="numpy")(module.cast_ray.py_func)
    kernel((0.0, 0.0, 1.0), (0.0, 0.0, 1.0), MOUNDS)
    (assembly,) = kernel.inspect_asm().values()

    assert "fmadd" not in assembly
    assert "fmsub" not in assembly


@pytest.mark.parametrize(("height", "flat"), [(-0.1, 2.0), (0.5, -1.0), (0.5, 17.0)])
def test_impossible_mounds_are_refused(height: float, flat: float) -> None:
    with pytest.raises(ValueError, match="are not possible"):
        draw_relief(streams(1, 0, 0).bottom, height_m=height, flat_m=flat)


def test_a_relief_is_its_waves() -> None:
    assert isinstance(RELIEF, Relief)
    assert RELIEF.waves[:, 0].sum() == pytest.approx(1.0)
    lengths = 2.0 * np.pi / np.hypot(RELIEF.waves[:, 1], RELIEF.waves[:, 2])
    assert lengths.min() >= 4.0
    assert lengths.max() <= 10.0
