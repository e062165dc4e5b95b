"""visibility-v3: a target that moves by itself, answers that cost, and what cannot win."""

from collections.abc import Callable
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from performance.statistics.visibility_attacks import Always, Playback, Remembering, stored_paths
from seamark.sim.benchmarks.visibility_v2.scenario import OPTICS, displacement
from seamark.sim.benchmarks.visibility_v2.settings import JUMP, MOTION, TURBIDITY
from seamark.sim.benchmarks.visibility_v3.experiment import EXPERIMENT
from seamark.sim.benchmarks.visibility_v3.scenario import camera_of, draw_scenario, seen
from seamark.sim.benchmarks.visibility_v3.whole_image import WholeImageFilter, WholeImageMatch
from seamark.sim.engine.replay import Replay
from seamark.sim.engine.trial import TrialResult, run_trial
from seamark.sim.metrics.tracking_answers import METRICS, WRONG_COST
from seamark.sim.metrics.tracking_losses import followed_metrics
from seamark.sim.numerics.statistics import area
from seamark.sim.recording.telemetry import INDEX, WIDTH, Rows
from seamark.sim.registry import TRUTH, benchmark
from seamark.sim.settings.refusal import ConfigurationInvalid
from seamark.sim.trackers import make
from tests.sim.benchmarks.attempts import over_trials

NAME = "visibility-v3"
ENTRY = benchmark(NAME)
SHORT: dict[str, Any] = {
    "turbidity_levels": [0.0, 3.0, 9.0],
    "motion_levels": [4.0, 40.0],
    "jump_levels": [4.0, 28.0],
    "level_duration_s": 1.0,
}
STILL = {"target_swing_m": 0.0, "target_turn_rad": 0.0}
POSE = slice(INDEX["x"], INDEX["yaw"] + 1)
TARGET = slice(INDEX["target_x"], INDEX["target_y"] + 1)
seeds = st.integers(0, 2**62)
shares = st.lists(st.floats(0.0, 100.0), min_size=3, max_size=3)


def ran(
    solution: Any = None, *, name: str = NAME, seed: int = 5, trial: int = 0, **changes: object
) -> TrialResult:
    config = benchmark(name).read(SHORT | changes)
    return run_trial(name, config, solution, seed=seed, trial=trial, on_rows=lambda _rows: None)


def reference(name: str) -> Any:
    return EXPERIMENT.built_in(name, ENTRY.read(SHORT))


@cache
def true_rows() -> Rows:
    kept: list[Rows] = []
    config = ENTRY.read(SHORT | {"tracker": TRUTH})
    run_trial(NAME, config, None, seed=5, trial=0, on_rows=kept.append)
    return np.concatenate(kept)


def of_level(level: int) -> Rows:
    rows = true_rows()
    return rows[rows[:, INDEX["level"]] == level]


def test_the_target_moves_by_itself_and_the_vehicle_too() -> None:
    config = ENTRY.read(SHORT)
    level = config.levels_of(TURBIDITY)[0]
    path = EXPERIMENT.path(config, seed=5, trial=0, level=level)
    places = np.array([path.place_and_rate(0.05 * k)[0] for k in range(20)])

    assert np.ptp(of_level(level)[:, POSE], axis=0).min() > 0.0
    assert np.ptp(places, axis=0).min() > 0.0


def test_the_rates_of_the_target_are_those_of_its_path() -> None:
    config = ENTRY.read(SHORT)
    path = EXPERIMENT.path(config, seed=5, trial=0, level=0)

    for t in (0.0, 0.3, 1.7):
        before, after = (np.array(path.place_and_rate(t + d)[0]) for d in (-1e-5, 1e-5))
        assert path.place_and_rate(t)[1] == pytest.approx((after - before) / 2e-5, abs=1e-6)


def test_all_levels_of_the_turbidity_axis_have_the_same_paths_and_the_hardest_comes_first() -> None:
    config = ENTRY.read(SHORT)
    levels = config.levels_of(TURBIDITY)

    seen_at = [of_level(level)[:, TARGET] for level in levels]

    assert [config.level_values()[level] for level in levels] == [9, 3, 0]
    assert np.array_equal(seen_at[0], seen_at[1])
    assert np.array_equal(seen_at[0], seen_at[2])


def test_an_image_replayed_from_telemetry_shows_the_target_where_it_was() -> None:
    config = ENTRY.read(SHORT)
    replay = Replay(NAME, config, lambda _trial: 5)
    rows = of_level(config.levels_of(TURBIDITY)[-1])

    for row in rows[[1, 7, 19]]:
        frame = replay.frame(row)
        column, line = frame.corners().mean(axis=0)
        without = frame.camera.without_noise(frame.motion, target=False)  # type: ignore[attr-defined]
        differs = np.argwhere(frame.camera.without_noise(frame.motion, target=True) != without)  # type: ignore[attr-defined]
        assert frame.corners().ravel() == pytest.approx(
            row[INDEX["corner_0"] : INDEX["corner_7"] + 1], abs=1e-9
        )
        assert differs.mean(axis=0) == pytest.approx([line, column], abs=6.0)


@pytest.mark.slow
@settings(max_examples=20)
@given(seed=seeds, motion_px=st.sampled_from([2.0, 10.0]))
def test_the_corners_move_by_the_motion_of_the_level_on_average(seed, motion_px) -> None:
    config = ENTRY.read({})
    scenario = draw_scenario(config, seed, 0)
    motion = scenario.fast.at(motion_px, config.control_period_s)
    camera = camera_of(scenario.scene, config, 0.0, motion)
    # As many seconds as six nominal periods take, in 400 steps.
    step_s = 6.0 * scenario.fast.speed_px * config.control_period_s / motion_px / 400

    corners = [seen(camera, motion, k * step_s) for k in range(401)]

    moved_px = np.mean([displacement(a, b) for a, b in pairwise(corners)])
    assert moved_px / step_s * config.control_period_s == pytest.approx(motion_px, rel=0.02)


def test_every_jump_has_the_size_of_its_level_and_the_target_has_a_part_in_it() -> None:
    config = ENTRY.read(SHORT)

    replay = Replay(NAME, config, lambda _trial: 5)

    for level in config.levels_of(JUMP):
        corners = [replay.frame(row).corners().ravel() for row in of_level(level)]
        path = EXPERIMENT.path(config, seed=5, trial=0, level=level)
        sizes = [displacement(a, b) for a, b in pairwise(corners)][::2]
        assert sizes == pytest.approx([config.level_values()[level]] * 10, abs=1e-2)
        assert path.place_and_rate(0.05)[0] != path.place_and_rate(0.0)[0]


@pytest.mark.slow
@settings(max_examples=40)
@given(seed=seeds, trial=st.integers(0, 31))
def test_the_target_stays_in_the_image_wherever_and_however_it_lies(seed, trial) -> None:
    config = ENTRY.read({})
    scenario = draw_scenario(config, seed, trial)
    for motion in (scenario.turbid.at(3.0, 0.05), scenario.fast.at(40.0, 0.05)):
        camera = camera_of(scenario.scene, config, 0.0, motion)

        corners = np.array([seen(camera, motion, 0.05 * k) for k in range(40)]).reshape(-1, 4, 2)

        assert corners.min() > 0.0
        assert (corners.max(axis=(0, 1)) < (OPTICS.width - 1, OPTICS.height - 1)).all()


@pytest.mark.slow
@settings(max_examples=8)
@given(seed=seeds)
def test_what_is_drawn_depends_on_seed_and_trial_but_not_on_the_levels(seed) -> None:
    config, other = ENTRY.read({}), ENTRY.read(SHORT)

    first = draw_scenario(config, seed, 0)

    assert first.as_dict() == draw_scenario(other, seed, 0).as_dict()
    assert first.turbid.seed != draw_scenario(config, seed + 1, 0).turbid.seed
    assert first.turbid.seed != draw_scenario(config, seed, 1).turbid.seed
    assert len({first.turbid.seed, first.fast.seed, first.turbid.vehicle.seed}) == 3


def test_a_program_is_told_neither_water_nor_paths_nor_levels() -> None:
    assert set(ENTRY.read({}).for_program()) == {"control_period_s", "tracker"}


def scored(net: list[float]) -> float:
    """The score of a trial with these shares of right less wrong answers [%] at 9, 3 and 0."""
    config = ENTRY.read(SHORT)
    names = {metric.name for metric in METRICS}
    levels = [
        dict.fromkeys(names, 0.0) | {"value": one.value, "held": False} for one in config.listed()
    ]
    for level, share in zip(config.levels_of(TURBIDITY), net, strict=True):
        levels[level]["net_percent"] = share
    return EXPERIMENT.trial_score(config, levels).score


@given(first=shares, second=shares)
def test_the_score_is_the_area_and_linear_in_every_level(first, second) -> None:
    between = [0.5 * (a + b) for a, b in zip(first, second, strict=True)]

    assert scored(first) == pytest.approx(area([9.0, 3.0, 0.0], [0.01 * p for p in first]))
    assert scored(between) == pytest.approx(0.5 * (scored(first) + scored(second)))
    assert scored([-100.0] * 3) == -9.0


def test_a_right_answer_counts_one_an_admitted_loss_nothing_and_a_wrong_one_costs() -> None:
    rows = np.zeros((6, WIDTH))
    rows[:, INDEX["tracker_ok"]] = (1, 1, 1, 1, 0, 1)
    rows[:, INDEX["tracker_error"]] = (0, 0.5, 4.9, 5.1, 30.0, np.nan)

    found = followed_metrics(rows, METRICS)

    assert found["p5_percent"] == 40.0
    assert found["wrong_percent"] == 40.0  # corners without a distance are wrong
    assert found["net_percent"] == 40.0 - WRONG_COST * 40.0


def test_silence_earns_nothing_and_to_answer_the_start_for_ever_loses() -> None:
    silent, nothing, oracle = (ran(reference(name)) for name in ("silent", "nothing", "oracle"))

    assert silent.score == 0.0
    assert nothing.score < -4.0
    assert oracle.score == 9.0
    assert not silent.trial_score.rankable
    assert not nothing.trial_score.rankable


def test_a_tracker_that_never_admits_a_loss_gets_less_than_one_that_does() -> None:
    config = ENTRY.read({})

    def honest() -> Any:
        return make("esm", truth=None, **config.tracker_options())

    assert ran(honest()).score > ran(Always(honest())).score + 1.0


WATER = {"turbidity_levels": [0.0, 5.0], "motion_levels": [4.0, 8.0], "jump_levels": [4.0, 8.0]}
BOX: dict[str, Any] = WATER | {"tracker": "box", "level_duration_s": 1.0}


@cache  # both cheats are compared with it
def box_score(seed: int, still: bool) -> float:
    return ran(seed=seed, **(BOX | STILL if still else BOX)).score


@pytest.mark.slow
@pytest.mark.parametrize("cheat", [WholeImageMatch, WholeImageFilter])
@over_trials(few=(0,), every=(0, 1, 2))
def test_to_follow_the_whole_image_wins_over_a_standing_target_and_loses_over_a_moving_one(
    cheat: Callable[[], Any], trials: tuple[int, ...]
) -> None:
    moving, standing, seeds = BOX, BOX | STILL, [5 + trial for trial in trials]

    gains = [
        [ran(cheat(), seed=seed, **where).score - box_score(seed, still) for seed in seeds]
        for where, still in ((standing, True), (moving, False))
    ]

    assert sum(gains[0]) > 0.5
    assert sum(gains[1]) < -0.5


@pytest.mark.slow
def test_the_ideal_observer_sees_farther_than_a_tracker_and_ends_before_the_axis() -> None:
    levels = {"turbidity_levels": [0, 4, 5, 6, 9], "motion_levels": [4, 8], "jump_levels": [4, 8]}

    ideal, tracker = ran(reference("ideal"), **levels), ran(warp="srt", **levels)

    assert [level["p5_percent"] > 90.0 for level in ideal.levels[:5]] == [False, *[True] * 4]
    assert ideal.levels[0]["net_percent"] < 30.0
    assert ideal.score > tracker.score


def test_motion_blur_is_that_of_the_target_and_not_of_the_bottom_below_it() -> None:
    config = ENTRY.read({"motion_exposure_s": 0.05, "path_swing_m": 0.05, "path_turn_rad": 0.0})
    level = config.levels_of(MOTION)[0]
    camera = EXPERIMENT.camera(config, seed=5, trial=0, level=level)
    sharp = EXPERIMENT.first_camera(config, seed=5, trial=0, level=level)
    frame = level * config.control_steps_per_level
    pose = camera.at(np.zeros(12), frame)
    pose[:6] = draw_scenario(config, 5, 0).scene.station

    blurred, still = (one.without_noise(pose, target=True).astype(float) for one in (camera, sharp))
    bottom_blurred, bottom_still = (
        one.without_noise(pose, target=False).astype(float) for one in (camera, sharp)
    )

    column, line = camera.corners(pose).mean(axis=0).astype(int)
    part = (slice(line - 8, line + 9), slice(column - 30, column + 31))
    depth = np.exp(-config.motion_depth)
    assert np.std(blurred[part]) < 0.7 * depth * np.std(still[part])
    assert np.std(bottom_blurred) > 0.8 * depth * np.std(bottom_still) * 0.9


def test_to_remember_the_path_from_level_to_level_gains_nothing() -> None:
    config = ENTRY.read({})
    levels: dict[str, Any] = {"turbidity_levels": [0, 2, 3.5, 4, 4.5, 5, 9]}
    honest = make("esm", truth=None, **config.tracker_options())

    gain = ran(Remembering(honest), **levels).score - ran(**levels).score

    assert gain < 0.15


def test_to_play_back_the_reference_trials_wins_there_and_loses_in_fresh_water() -> None:
    paths = stored_paths(NAME, seed=5, trials=1)

    known = ran(Playback(paths), level_duration_s=2.0)
    fresh = ran(Playback(paths), seed=6, level_duration_s=2.0)

    assert known.score == pytest.approx(9.0)
    assert fresh.score < 0.0


def test_the_same_seed_gives_the_same_bytes_and_another_does_not() -> None:
    digests = [ran(seed=seed).digest for seed in (5, 5, 6)]

    assert digests[0] == digests[1] != digests[2]


@pytest.mark.parametrize(
    ("changes", "setting"),
    [
        ({"target_swing_m": 0.3}, "target_swing_m"),
        ({"target_turn_rad": -0.1}, "target_turn_rad"),
        ({"motion_levels": [4.0, 100.0]}, "motion_levels"),
        ({"control_period_s": 0.01, "motion_exposure_s": 0.02}, "motion_exposure_s"),
    ],
)
def test_settings_that_make_no_sense_are_refused_by_name(changes, setting) -> None:
    with pytest.raises(ConfigurationInvalid) as refusal:
        ENTRY.read(changes)

    assert any(setting in name for name in refusal.value.errors)


def test_ground_truth_as_a_tracker_cannot_rank() -> None:
    with pytest.raises(ConfigurationInvalid, match="ground truth"):
        ENTRY.ranked(ENTRY.read({"tracker": TRUTH}))
