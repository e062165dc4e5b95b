"""The dock of dock-v1 fits its vehicle, stands around the marker, and stops what runs into it."""

import numpy as np
import pytest

from seamark.sim.benchmarks.dock_v1.experiment import EXPERIMENT
from seamark.sim.benchmarks.dock_v1.scene import (
    CLEARANCE_M,
    FLARE_M,
    MOUTH_M,
    POCKET_M,
    SEABED_M,
    cage,
    keel_of,
    seat,
)
from seamark.sim.benchmarks.dock_v1.settings import RAILS_M, DockConfiguration
from seamark.sim.benchmarks.intervention.box import BoxDraw, workpiece
from seamark.sim.detectors.faces.detector import OutlineDetector
from seamark.sim.multibody.assembly import standing_shapes
from seamark.sim.multibody.hull import Hull
from seamark.sim.numerics.arrays import Array
from seamark.sim.physics.contact import Contact
from seamark.sim.physics.current import Current
from seamark.sim.physics.plant import Plant
from seamark.sim.physics.terrain import Bottom
from seamark.sim.settings.two_vehicles import MEASURED
from seamark.sim.vehicles import load

HEADING = 0.6
CONFIG = DockConfiguration.read({"levels": [0.0]})
VEHICLES = pytest.mark.parametrize("name", MEASURED)


def plant_at(name: str, offset: tuple[float, float, float], turn: float = 0.0) -> Plant:
    """Return a vehicle over its dock: forward, to starboard and above its seat."""
    vehicle = load(name)
    dock = cage(keel_of(vehicle), HEADING)
    contact = Contact(
        vehicle,
        Bottom(SEABED_M),
        engine=lambda *given: Hull(*given, things=(dock,)),
        top_m=SEABED_M - RAILS_M - MOUTH_M - 0.1,
    )
    plant = Plant(vehicle, Current(0.0), contact=contact)
    ahead, side, above = offset
    c, s = np.cos(HEADING), np.sin(HEADING)
    away = np.array([c * ahead - s * side, s * ahead + c * side, -above])
    plant.reset(np.array([*(seat(vehicle) + away), 0.0, 0.0, HEADING + turn]))
    return plant


def sunk(plant: Plant, seconds: float, share: float) -> tuple[Array, float]:
    """Return where it is off its seat after it pushed downwards, and the largest force [N]."""
    downwards = plant.vehicle.allocation()[2]
    command = np.where(np.abs(downwards) > 0.5, np.sign(downwards) * share, 0.0)
    peak = 0.0
    for step in range(0, round(seconds / 0.01), 5):
        plant.advance(step, command, 5)
        peak = max(peak, plant.contact_force())
    north, east, down = plant.pose()[:3] - seat(plant.vehicle)
    c, s = np.cos(HEADING), np.sin(HEADING)
    return np.array([c * north + s * east, c * east - s * north, down]), peak


@VEHICLES
def test_a_vehicle_above_its_seat_sinks_onto_the_rails(name: str) -> None:
    off, _peak = sunk(plant_at(name, (0.0, 0.0, 0.9)), 15.0, 0.5)

    assert np.abs(off).max() < 0.01


@pytest.mark.parametrize("side", [-0.25, 0.25])
def test_tubes_that_lean_outwards_guide_a_heavy_vehicle_in_from_beside(side: float) -> None:
    off, peak = sunk(plant_at("girona500", (0.0, side, 0.9)), 25.0, 0.5)

    assert abs(off[1]) < 0.5 * abs(side)
    assert off[2] > -POCKET_M
    assert peak > 10.0


@VEHICLES
def test_it_does_not_pass_through_the_rim(name: str) -> None:
    keel = keel_of(load(name))
    side = keel.half_width + CLEARANCE_M + FLARE_M
    off, peak = sunk(plant_at(name, (0.0, side, 0.9)), 10.0, 0.5)

    assert peak > 10.0
    assert off[2] < -0.2


@VEHICLES
def test_a_dock_without_a_vehicle_in_it_costs_no_force_above_its_mouth(name: str) -> None:
    _off, peak = sunk(plant_at(name, (0.0, 0.0, MOUTH_M + 1.0)), 0.5, 0.0)

    assert peak == 0.0


def test_a_thing_that_moves_is_no_dock() -> None:
    with pytest.raises(ValueError, match="link that moves"):
        standing_shapes(workpiece(BoxDraw()).things[0])


@pytest.mark.parametrize("trial", [0, 1])
def test_the_camera_of_a_docked_vehicle_is_above_the_middle_of_the_upright_marker(
    trial: int,
) -> None:
    config = CONFIG.for_trial(trial)
    camera = EXPERIMENT.camera(CONFIG, seed=4, trial=trial, level=0)
    heading = EXPERIMENT.heading(CONFIG, seed=4, trial=trial)

    corners = camera.corners(np.array([*seat(load(config.vehicle)), 0.0, 0.0, heading]))

    centre = (0.5 * (config.camera_width_px - 1), 0.5 * (config.camera_height_px - 1))
    assert np.allclose(corners.mean(axis=0), centre, atol=1e-6)
    upper_left, upper_right, _lower_right, lower_left = corners
    assert upper_left[1] == pytest.approx(upper_right[1])
    assert upper_left[0] < upper_right[0]
    assert upper_left[1] < lower_left[1]


def test_the_marker_that_cameras_see_is_where_its_corners_are_said_to_be() -> None:
    camera = EXPERIMENT.camera(CONFIG, seed=4, trial=1, level=0)
    heading = EXPERIMENT.heading(CONFIG, seed=4, trial=1)
    pose = np.array([*seat(load(MEASURED[1])), 0.0, 0.0, heading + 0.4])
    pose[2] -= 0.9

    (best, *_others) = OutlineDetector().detect(camera.grey(pose, 0))

    assert np.abs(best.corners - camera.corners(pose)).max() < 1.5


def test_the_dock_is_turned_to_where_the_current_comes_from() -> None:
    config = DockConfiguration.read({"into_current_rad": 0.0})

    for trial in range(4):
        drawn = EXPERIMENT.drawn(config, seed=1, trial=trial)
        mean = config.current_azimuth_rad + drawn.current.azimuth_rad
        heading = EXPERIMENT.heading(config, seed=1, trial=trial)
        assert np.cos(heading - mean) == pytest.approx(1.0)


def test_starts_are_drawn_within_their_bounds_and_differ_from_level_to_level() -> None:
    config = DockConfiguration.read({})
    starts = [
        EXPERIMENT.start(config, seed=2, trial=trial, level=level)
        for trial in range(3)
        for level in range(5)
    ]

    away = [float(np.hypot(*start.offset_m)) for start in starts]
    assert config.approach_least_m <= min(away) < max(away) <= config.approach_most_m
    assert all(0.0 <= start.above_m <= config.approach_rise_m for start in starts)
    assert len({start.heading_rad for start in starts}) == len(starts)


def test_a_level_begins_where_it_was_drawn_to() -> None:
    craft = EXPERIMENT.craft(DockConfiguration.read({}), seed=2, trial=1, level=3)
    start = EXPERIMENT.start(DockConfiguration.read({}), seed=2, trial=1, level=3)

    assert np.allclose(craft.start[:2], start.offset_m)
    assert craft.start[2] == pytest.approx(craft.station[2] - start.above_m)
