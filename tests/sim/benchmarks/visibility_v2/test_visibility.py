"""visibility-v2: what is drawn, its three axes, its score, and what cannot win."""

from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from performance.statistics.visibility_attacks import Playback, Remembering, stored_paths
from seamark.sim.benchmarks.visibility_v2.experiment import CLEAR_WATER, EXPERIMENT
from seamark.sim.benchmarks.visibility_v2.scenario import OPTICS, displacement, draw_scenario
from seamark.sim.benchmarks.visibility_v2.settings import JUMP, MOTION, TURBIDITY
from seamark.sim.engine.summary import summarise
from seamark.sim.engine.trial import TrialResult, run_trial
from seamark.sim.metrics.tracking_losses import followed_metrics, jump_metrics
from seamark.sim.numerics.statistics import area
from seamark.sim.recording.telemetry import INDEX, WIDTH, Rows
from seamark.sim.registry import TRUTH, benchmark
from seamark.sim.settings.refusal import ConfigurationInvalid
from seamark.sim.settings.targets import TARGET_TEXTURES
from seamark.sim.trackers import make

NAME = "visibility-v2"
ENTRY = benchmark(NAME)
SHORT: dict[str, Any] = {
    "turbidity_levels": [0.0, 3.0, 7.0],
    "motion_levels": [4.0, 40.0],
    "jump_levels": [4.0, 28.0],
    "level_duration_s": 1.0,
}
POSE = slice(INDEX["x"], INDEX["yaw"] + 1)
seeds = st.integers(0, 2**62)
shares = st.lists(st.floats(0.0, 100.0), min_size=3, max_size=3)


def ran(solution: Any = None, *, seed: int = 5, trial: int = 0, **changes: object) -> TrialResult:
    config = ENTRY.read(SHORT | changes)
    return run_trial(NAME, config, solution, seed=seed, trial=trial, on_rows=lambda _rows: None)


@cache
def true_rows() -> Rows:
    kept: list[Rows] = []
    config = ENTRY.read(SHORT | {"tracker": TRUTH})
    run_trial(NAME, config, None, seed=5, trial=0, on_rows=kept.append)
    return np.concatenate(kept)


def of_level(rows: Rows, level: int) -> Rows:
    return rows[rows[:, INDEX["level"]] == level]


def scored(p5: list[float]) -> float:
    """The score of a trial with these p@5 [%] at optical depths of 7, 3 and 0."""
    config = ENTRY.read(SHORT)
    levels = [
        {"value": one.value, "held": False, "corner_px": 1.0}
        | dict.fromkeys(("p1_percent", "p5_percent"), 0.0)
        | dict.fromkeys(("admitted_loss_percent", "false_loss_percent"), 0.0)
        | {"unreported_loss_percent": 0.0}
        for one in config.listed()
    ]
    for level, share in zip(config.levels_of(TURBIDITY), p5, strict=True):
        levels[level]["p5_percent"] = share
    return EXPERIMENT.trial_score(config, levels).score


def test_all_levels_of_the_turbidity_axis_have_the_same_path_and_the_hardest_comes_first() -> None:
    config, rows = ENTRY.read(SHORT), true_rows()

    paths = [of_level(rows, level)[:, POSE] for level in config.levels_of(TURBIDITY)]

    assert [config.level_values()[level] for level in config.levels_of(TURBIDITY)] == [7, 3, 0]
    assert all(np.array_equal(a, b) for a, b in pairwise(paths))
    assert np.ptp(paths[0], axis=0).min() > 0.0


def test_the_motion_axis_has_a_path_of_its_own_which_only_changes_its_speed() -> None:
    config, rows = ENTRY.read(SHORT), true_rows()
    turbid = of_level(rows, config.levels_of(TURBIDITY)[0])[0, POSE]
    fast, slow = (of_level(rows, level)[0, POSE] for level in config.levels_of(MOTION))

    assert np.array_equal(fast, slow)
    assert not np.array_equal(fast, turbid)


@pytest.mark.slow
@settings(max_examples=20)
@given(seed=seeds, motion_px=st.sampled_from([2.0, 10.0]))
def test_the_corners_move_by_the_motion_of_the_level_on_average(seed, motion_px) -> None:
    config = ENTRY.read({})
    scenario = draw_scenario(config, seed, 0)
    camera = scenario.camera(0.0, config.altitude_m)
    path = scenario.fast.at(motion_px, config.control_period_s)
    # As many seconds as six nominal periods take, in 1200 steps.
    step_s = 6.0 * scenario.fast.speed_px * config.control_period_s / motion_px / 1200

    corners = [
        camera.corners(np.array(path.pose_and_velocity(k * step_s)[0])).ravel().tolist()
        for k in range(1200)
    ]

    moved_px = np.mean([displacement(a, b) for a, b in pairwise(corners)])
    assert moved_px / step_s * config.control_period_s == pytest.approx(motion_px, rel=0.01)


def test_every_jump_has_the_size_of_its_level() -> None:
    config, rows = ENTRY.read(SHORT), true_rows()
    camera = EXPERIMENT.camera(config, seed=5, trial=0, level=0)

    for level in config.levels_of(JUMP):
        corners = [camera.corners(row[POSE].copy()) for row in of_level(rows, level)]
        sizes = [displacement(a.ravel(), b.ravel()) for a, b in pairwise(corners)][::2]
        assert len(sizes) == 10
        assert sizes == pytest.approx([config.level_values()[level]] * 10, abs=1e-2)


@pytest.mark.slow
@given(seed=seeds, trial=st.integers(0, 31))
def test_the_target_stays_in_the_image_wherever_and_however_it_lies(seed, trial) -> None:
    config = ENTRY.read({})
    scenario = draw_scenario(config, seed, trial)
    camera = scenario.camera(0.0, config.altitude_m)
    paths = (scenario.turbid.at(3.0, 0.05), scenario.fast.at(40.0, 0.05))
    poses = [path.pose_and_velocity(0.05 * k)[0] for path in paths for k in range(40)]

    corners = np.array([camera.corners(np.array(pose)) for pose in poses])

    assert corners.min() > 0.0
    assert (corners.max(axis=(0, 1)) < (OPTICS.width - 1, OPTICS.height - 1)).all()


@pytest.mark.slow
@settings(max_examples=15)
@given(seed=seeds)
def test_what_is_drawn_depends_on_seed_and_trial_but_not_on_the_levels(seed) -> None:
    config, other = ENTRY.read({}), ENTRY.read(SHORT)

    first = draw_scenario(config, seed, 0)

    assert first.as_dict() == draw_scenario(other, seed, 0).as_dict()
    assert first.turbid.seed != draw_scenario(config, seed + 1, 0).turbid.seed
    assert first.turbid.seed != draw_scenario(config, seed, 1).turbid.seed
    assert len({first.turbid.seed, first.fast.seed, first.jumps_seed}) == 3


@pytest.mark.slow
def test_both_parts_of_a_ranked_run_have_every_texture_equally_often() -> None:
    config, protocol = ENTRY.read({}), ENTRY.protocol
    assert protocol is not None

    drawn = [draw_scenario(config, 9, trial) for trial in range(protocol.trials)]

    for part in (drawn[: protocol.reference_trials], drawn[protocol.reference_trials :]):
        textures = [scenario.texture for scenario in part]
        assert {textures.count(texture) for texture in TARGET_TEXTURES} == {
            len(part) // len(TARGET_TEXTURES)
        }
    assert all(scenario.texture != scenario.ground for scenario in drawn)


def test_a_program_is_told_neither_water_nor_path_nor_levels() -> None:
    told = ENTRY.read({}).for_program()

    assert set(told) == {"control_period_s", "tracker"}


@given(first=shares, second=shares)
def test_the_score_is_the_area_and_linear_in_every_level(first, second) -> None:
    between = [0.5 * (a + b) for a, b in zip(first, second, strict=True)]

    assert scored(first) == pytest.approx(area([7.0, 3.0, 0.0], [0.01 * p for p in first]))
    assert scored(between) == pytest.approx(0.5 * (scored(first) + scored(second)))
    assert scored([100.0] * 3) == 7.0


def test_losses_are_told_apart() -> None:
    rows = np.zeros((6, WIDTH))
    rows[:, INDEX["tracker_ok"]] = (1, 1, 1, 0, 0, 1)
    rows[:, INDEX["tracker_error"]] = (0, 0.5, 11.0, 11.0, 9.0, np.nan)

    found = followed_metrics(rows)

    assert found["p5_percent"] == found["p1_percent"] == 20.0
    assert found["admitted_loss_percent"] == 20.0
    assert found["false_loss_percent"] == 20.0
    assert found["unreported_loss_percent"] == 40.0  # corners without a distance are no success
    assert jump_metrics(rows)["p1_percent"] == pytest.approx(100.0 / 3.0)


@pytest.mark.parametrize(
    ("name", "score", "rankable"), [("nothing", 0.5, False), ("oracle", 7.0, True)]
)
def test_nothing_is_at_the_bottom_and_does_not_rank_and_the_oracle_is_perfect(
    name, score, rankable
) -> None:
    result = ran(EXPERIMENT.built_in(name, ENTRY.read(SHORT)), level_duration_s=2.0)

    assert result.score == pytest.approx(score, abs=0.5 * (1 - rankable))
    assert result.trial_score.rankable is rankable
    assert result.trial_score.reason == ("" if rankable else CLEAR_WATER)


def test_a_tracker_that_looks_at_four_images_only_falls_far_behind_one_that_looks_at_all() -> None:
    blind = ran(EXPERIMENT.built_in("blind", ENTRY.read(SHORT)), level_duration_s=2.0)
    honest = ran(level_duration_s=2.0)

    assert blind.score < 0.5 * honest.score
    assert blind.trial_score.rankable is False


def test_to_remember_the_path_from_level_to_level_gains_nothing() -> None:
    config = ENTRY.read({})
    levels: dict[str, Any] = {"turbidity_levels": [0, 2, 3.5, 4, 4.5, 5, 7]}
    honest = make("esm", truth=None, **config.tracker_options())

    gain = ran(Remembering(honest), **levels).score - ran(**levels).score

    assert abs(gain) < 0.15


def test_to_play_back_the_reference_trials_wins_there_and_is_worth_nothing_in_fresh_water() -> None:
    paths = stored_paths(NAME, seed=5, trials=1)
    nothing = ran(EXPERIMENT.built_in("nothing", ENTRY.read({})), seed=6, level_duration_s=2.0)

    known = ran(Playback(paths), level_duration_s=2.0)
    fresh = ran(Playback(paths), seed=6, level_duration_s=2.0)

    assert known.score == 7.0
    assert fresh.score == nothing.score
    assert fresh.trial_score.rankable is False


def test_the_same_seed_gives_the_same_bytes_and_another_does_not() -> None:
    digests = [ran(seed=seed).digest for seed in (5, 5, 6)]

    assert digests[0] == digests[1] != digests[2]


def test_the_midpoint_is_fitted_to_all_trials_together() -> None:
    config = ENTRY.read(SHORT)
    results = [ran(trial=trial) for trial in range(2)]

    overall = summarise(NAME, config, results)["overall"]

    assert 3.0 < overall["tau_midpoint"] < 7.0
    assert overall["motion_held_px"] == pytest.approx(
        np.mean([result.overall["motion_held_px"] for result in results])
    )


@pytest.mark.parametrize(
    ("changes", "setting"),
    [
        ({"turbidity_levels": [1.0, 0.0]}, "turbidity_levels"),
        ({"jump_levels": [4.0, 4.0]}, "jump_levels"),
        ({"level_duration_s": 1.05}, "level_duration_s"),
        ({"control_period_s": 0.01, "motion_exposure_s": 0.02}, "motion_exposure_s"),
        ({"motion_levels": [4.0]}, "motion_levels"),
        ({"path_swing_m": 0.5}, "path_swing_m"),
    ],
)
def test_settings_that_make_no_sense_are_refused_by_name(changes, setting) -> None:
    with pytest.raises(ConfigurationInvalid) as refusal:
        ENTRY.read(changes)

    assert setting in refusal.value.errors


def test_ground_truth_as_a_tracker_cannot_rank() -> None:
    with pytest.raises(ConfigurationInvalid, match="ground truth"):
        ENTRY.ranked(ENTRY.read({"tracker": TRUTH}))
