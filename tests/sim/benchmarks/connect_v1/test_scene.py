"""What stands in the scene of connect-v1, and what a trial draws of it."""

import numpy as np
import pytest

from seamark.sim.benchmarks.connect_v1 import scene
from seamark.sim.benchmarks.connect_v1.experiment import EXPERIMENT
from seamark.sim.benchmarks.connect_v1.settings import ConnectConfiguration
from seamark.sim.control.manipulation import connector
from seamark.sim.engine.trial import run_trial
from seamark.sim.metrics.connection import SEATED_M, TIP_M
from seamark.sim.multibody.workpiece import Workpiece
from seamark.sim.numerics.random_streams import streams
from seamark.sim.recording.telemetry import WORK_INDEX, Rows, digest
from seamark.sim.settings.refusal import ConfigurationInvalid
from seamark.sim.vehicles.linkage import Touchable
from seamark.sim.vehicles.linkage_reading import load_linkage

CONFIG = ConnectConfiguration.read({"levels": [0.1], "level_duration_s": 5.0})


def drawn(trial: int) -> scene.ConnectorDraw:
    return scene.draw_connector(CONFIG, streams(2026, trial, 0))


def shape(work: Workpiece, name: str) -> Touchable:
    shapes = [one for part in work.things for link in part.linkage.links for one in link.shapes]
    return next(one for one in shapes if one.name == name)


def run(controller: str = "scripted", *, seed: int = 2026) -> Rows:
    rows: list[Rows] = []
    program = EXPERIMENT.built_in(controller, CONFIG)
    run_trial("connect-v1", CONFIG, program, seed=seed, trial=0, on_rows=rows.append)
    return np.concatenate(rows)


def test_trials_draw_within_what_is_said_and_differ() -> None:
    draws = [drawn(trial) for trial in range(40)]

    for draw in draws:
        assert abs(draw.heading_rad) <= np.pi
        assert scene.LOWEST_M <= draw.height_m <= scene.HIGHEST_M
        assert abs(draw.parked_m - scene.PARKED_M) <= scene.RAIL_M
        assert abs(draw.askew_rad) <= scene.ASKEW_RAD
        assert scene.LIGHTEST_KG <= draw.mass_kg <= scene.HEAVIEST_KG
        assert CONFIG.clearance_least_m <= draw.clearance_m <= CONFIG.clearance_most_m
        assert abs(draw.friction_factor - 1.0) <= CONFIG.friction_spread
    assert len(set(draws)) == len(draws)


def test_the_hole_is_wider_than_the_peg_by_the_clearance_that_was_drawn() -> None:
    draw = drawn(3)
    work = scene.workpiece(draw)
    hole, peg = shape(work, "hole"), shape(work, "peg")

    assert peg.size.value[0] == scene.PEG_M
    assert 2.0 * (hole.size.value[0] - peg.size.value[0]) == pytest.approx(draw.clearance_m)
    assert hole.size.value[1] > SEATED_M


def test_connector_metrics_and_controllers_have_one_length() -> None:
    peg = load_linkage(scene.CONNECTOR).link("peg")
    (cylinder,) = peg.shapes
    tip = peg.joint.place.point.value[2] + cylinder.size.value[1]

    assert tip == pytest.approx(TIP_M)
    assert (connector.TIP_M, connector.PARKED_M) == (TIP_M, scene.PARKED_M)


def test_the_receptacle_is_at_the_origin_of_the_world_which_the_stages_rely_on() -> None:
    draw = drawn(5)
    receptacle, parked = scene.workpiece(draw).things
    north, east, face = receptacle.place.point.value

    assert (north, east) == (0.0, 0.0)
    assert face == pytest.approx(scene.target(draw).seabed_m - draw.height_m)
    assert parked.place.point.value[2] + TIP_M == pytest.approx(face)
    assert np.hypot(*parked.place.point.value[:2]) == pytest.approx(draw.parked_m)


def test_the_face_that_is_tracked_is_the_top_of_the_panel() -> None:
    draw = drawn(7)

    assert np.allclose(scene.workpiece(draw).corners(), scene.target(draw).top_corners())


@pytest.mark.slow
def test_the_connector_stands_in_its_parking_place_until_it_is_taken() -> None:
    rows = run("nothing")
    z = rows[:, WORK_INDEX["workpiece_z"]]
    lean = np.abs(rows[:, [WORK_INDEX["workpiece_roll"], WORK_INDEX["workpiece_pitch"]]])

    assert np.ptp(z) < 1e-4
    assert lean.max() < 1e-3
    assert rows[:, WORK_INDEX["work_arm_n"]].max() == 0.0
    assert rows[1:, WORK_INDEX["work_rest_n"]].min() > 0.0


@pytest.mark.slow
def test_the_same_trial_gives_the_same_bytes_twice() -> None:
    assert digest(run()) == digest(run())
    assert digest(run()) != digest(run(seed=2027))


def test_a_greatest_clearance_below_the_least_is_refused() -> None:
    with pytest.raises(ConfigurationInvalid, match="Greatest clearance"):
        ConnectConfiguration.read({"clearance_least_m": 0.005, "clearance_most_m": 0.004})


def test_a_tilted_panel_is_refused() -> None:
    with pytest.raises(ConfigurationInvalid, match="level"):
        ConnectConfiguration.read({"tilt_spread_rad": 0.1})


def test_programs_are_told_of_the_panel_but_not_what_was_drawn() -> None:
    told = CONFIG.for_program()

    assert told["face_m"] == (0.6, 0.45)
    assert not {"levels", "azimuth_spread_rad", "height_m", "heading_rad", "mass_kg"} & set(told)
