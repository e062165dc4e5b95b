"""What stands in the scene of valve-v1, and what a trial draws of it."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from seamark.sim.benchmarks.intervention.things import SUNK_M
from seamark.sim.benchmarks.valve_v1 import scene
from seamark.sim.benchmarks.valve_v1.experiment import EXPERIMENT
from seamark.sim.benchmarks.valve_v1.settings import ValveConfiguration
from seamark.sim.engine.trial import run_trial
from seamark.sim.numerics.random_streams import streams
from seamark.sim.recording.telemetry import WORK_INDEX, Rows, digest
from seamark.sim.settings.refusal import ConfigurationInvalid

CONFIG = ValveConfiguration.read({"levels": [0.1], "level_duration_s": 5.0})


def drawn(trial: int) -> scene.ValveDraw:
    return scene.draw_valve(CONFIG, streams(2026, trial, 0))


def run(controller: str = "scripted", *, seed: int = 2026) -> Rows:
    rows: list[Rows] = []
    program = EXPERIMENT.built_in(controller, CONFIG)
    run_trial("valve-v1", CONFIG, program, seed=seed, trial=0, on_rows=rows.append)
    return np.concatenate(rows)


def test_trials_draw_within_what_is_said_and_differ() -> None:
    draws = [drawn(trial) for trial in range(40)]

    for draw in draws:
        assert abs(draw.heading_rad) <= np.pi
        assert scene.LOWEST_M <= draw.height_m <= scene.HIGHEST_M
        assert CONFIG.torque_least_n_m <= draw.torque_n_m <= CONFIG.torque_most_n_m
        assert scene.SLIDING[0] <= draw.sliding_share <= scene.SLIDING[1]
        assert abs(draw.friction_factor - 1.0) <= CONFIG.friction_spread
    assert len(set(draws)) == len(draws)


def test_the_handle_is_as_stiff_as_its_trial_drew_it() -> None:
    draw = drawn(3)
    (mounting,) = scene.workpiece(draw).things
    friction = mounting.linkage.link("handle").joint.friction

    assert friction is not None
    assert friction.value == (draw.torque_n_m, draw.torque_n_m * draw.sliding_share)


def test_the_panel_reaches_from_its_face_into_the_seabed_however_it_is_tilted() -> None:
    draw = drawn(5)
    (mounting,) = scene.workpiece(draw).things
    (shape,) = mounting.linkage.link("panel").shapes
    target = scene.target(draw)

    face, half = mounting.place.point.value[2], shape.size.value[2]

    assert face == pytest.approx(target.seabed_m - draw.height_m)
    assert shape.place.point.value[2] - half == pytest.approx(0.0)
    assert face + 2.0 * half == pytest.approx(target.seabed_m + SUNK_M)
    steepest = ValveConfiguration.model_fields["tilt_spread_rad"].metadata
    most = next(one.le for one in steepest if hasattr(one, "le"))
    assert np.hypot(*shape.size.value[:2]) * np.sin(most) < SUNK_M


def test_the_face_that_is_tracked_is_the_top_of_the_panel() -> None:
    draw = drawn(7)

    level, middle = scene.target(draw).top_corners(), scene.target(draw).top_centre()
    tilted = middle + (level - middle) @ draw.tilt.matrix().T

    assert np.allclose(scene.workpiece(draw).corners(), tilted)


@pytest.mark.slow
def test_the_handle_starts_along_the_letters_and_above_the_face() -> None:
    rows, draw = run(), drawn(0)
    start = rows[0]
    attitude = [start[WORK_INDEX[f"workpiece_{axis}"]] for axis in ("roll", "pitch", "yaw")]
    lever = Rotation.from_euler("xyz", attitude).apply([0.0, 1.0, 0.0])
    right, _down = scene.target(draw).axes()
    top = scene.target(draw).top_centre()
    place = [start[WORK_INDEX[f"workpiece_{axis}"]] for axis in "xyz"]

    assert abs(lever @ (draw.tilt.matrix() @ right)) == pytest.approx(1.0)
    assert start[WORK_INDEX["workpiece_joint"]] == 0.0
    assert place == pytest.approx(top + draw.tilt.matrix() @ [0.0, 0.0, -0.12])


def test_the_handle_turns_by_more_than_what_is_asked_both_ways() -> None:
    (mounting,) = scene.workpiece(scene.ValveDraw()).things
    span = mounting.linkage.link("handle").joint.range

    assert span is not None
    assert span.value[0] < -np.radians(170.0) < np.radians(170.0) < span.value[1]


@pytest.mark.slow
def test_the_same_trial_gives_the_same_bytes_twice() -> None:
    assert digest(run()) == digest(run())
    assert digest(run()) != digest(run(seed=2027))


def test_a_greatest_torque_below_the_least_is_refused() -> None:
    with pytest.raises(ConfigurationInvalid, match="Greatest torque"):
        ValveConfiguration.read({"torque_least_n_m": 5.0, "torque_most_n_m": 4.0})


def test_programs_are_told_of_the_panel_but_not_what_was_drawn() -> None:
    told = CONFIG.for_program()

    assert told["face_m"] == (0.6, 0.45)
    assert not {"levels", "azimuth_spread_rad", "height_m", "heading_rad"} & set(told)
