"""currents-v2: what a program may know, what ranks, and that every image is found again."""

import contextlib
import json
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from seamark.sim.benchmarks.currents_v2.experiment import EXPERIMENT, NOT_HELD
from seamark.sim.benchmarks.currents_v2.settings import CurrentsConfiguration
from seamark.sim.benchmarks.level_area import area_over_current
from seamark.sim.control.observation import STARTS
from seamark.sim.engine.program import BuiltIn, Command, Program
from seamark.sim.engine.replay import Replay
from seamark.sim.engine.trial import TrialResult, run_trial
from seamark.sim.numerics.arrays import Array
from seamark.sim.recording.telemetry import INDEX, Rows
from seamark.sim.registry import benchmark
from seamark.sim.settings.refusal import ConfigurationInvalid
from seamark.sim.settings.setting import group_of, limits_of
from seamark.sim.settings.trial_spreads import GROUP

NAME = "currents-v2"
WEAKEST = {"levels": [0.1, 0.2], "level_duration_s": 40.0, "settle_s": 5.0, "tracker": "truth"}
BRIEF = {"levels": [0.1, 0.2, 0.3], "level_duration_s": 2.0, "settle_s": 1.0}


class Always:
    """Sends one command for ever and notes what it was told."""

    def __init__(self, command: Command) -> None:
        self.command = command
        self.told: list[Mapping[str, float | int]] = []

    def reset(self, level: Mapping[str, float | int]) -> None:
        self.told.append(level)

    def step(self, values: Array) -> Command:
        return self.command


class DeadReckoning(Always):
    """Integrates the DVL's velocity and drives back: a controller without a camera."""

    def __init__(self) -> None:
        super().__init__((0.0, 0.0, 0.0, 0.0))
        self.moved = np.zeros(2)

    def reset(self, level: Mapping[str, float | int]) -> None:
        self.moved[:] = 0.0

    def step(self, values: Array) -> Command:
        first = STARTS["velocity"]
        self.moved += 0.05 * values[first : first + 2]
        surge, sway = np.clip(-1.5 * self.moved, -1.0, 1.0).tolist()
        return surge, sway, 0.0, 0.0


def run(
    settings: Mapping[str, Any], program: Program, *, seed: int = 5, trial: int = 0
) -> tuple[TrialResult, Rows]:
    rows: list[Rows] = []
    config = benchmark(NAME).read(settings)
    result = run_trial(NAME, config, program, seed=seed, trial=trial, on_rows=rows.append)
    return result, np.concatenate(rows)


@pytest.mark.parametrize("trial", [0, 1])
def test_doing_nothing_scores_next_to_nothing_and_does_not_rank(trial: int) -> None:
    result, _rows = run(WEAKEST, Always((0.0, 0.0, 0.0, 0.0)), trial=trial)

    assert result.score < 0.1 * 0.2
    assert not result.trial_score.rankable
    assert result.trial_score.reason == NOT_HELD


@pytest.mark.parametrize("command", [(1.0, 0.0, 0.0, 0.0), (-1.0, 1.0, 0.0, 0.6)])
def test_driving_away_scores_nothing_and_does_not_rank(command: Command) -> None:
    result, _rows = run(WEAKEST, Always(command))

    assert result.score < 0.05 * 0.2
    assert not result.trial_score.rankable


@pytest.mark.slow
def test_dead_reckoning_fails_where_a_controller_with_a_camera_holds() -> None:
    settings = WEAKEST | {"levels": [0.1], "start_heading_rad": 0, "level_duration_s": 60.0}
    seeds = (1, 2, 3)
    config = benchmark(NAME).read(settings)

    blind = [run(settings, DeadReckoning(), seed=seed)[0] for seed in seeds]
    seeing = [run(settings, BuiltIn("pi", config), seed=seed)[0] for seed in seeds]

    assert all(
        b.levels[0]["quality"] < 0.5 * s.levels[0]["quality"]
        for b, s in zip(blind, seeing, strict=True)
    )
    assert not any(level["held"] for result in blind for level in result.levels)


def test_a_program_is_told_nothing_about_the_water() -> None:
    config = benchmark(NAME).read(WEAKEST).for_trial(1)
    told = set(config.for_program())

    assert {"kp", "ki", "vehicle", "control_period_s", "reference_limit_m_s"} <= told
    assert not {name for name in told if "current" in name or "spread" in name or "loop" in name}
    assert not told & {"levels", "level_values", "start_offset_m", "dvl_bias_spread_m_s", "score"}


def test_the_index_that_a_program_is_told_is_the_position_in_time() -> None:
    program = Always((0.0, 0.0, 0.0, 0.0))
    _result, rows = run(BRIEF, program, seed=3)
    order = EXPERIMENT.plan(CurrentsConfiguration.read(BRIEF), seed=3, trial=0).order

    assert [level["index"] for level in program.told] == [0, 1, 2]
    assert [level["t"] for level in program.told] == [0.0, 2.0, 4.0]
    assert rows[::40, INDEX["level"]].tolist() == list(order) != [0, 1, 2]
    assert np.allclose(np.diff(rows[:, INDEX["t"]]), 0.05)


def test_the_metrics_of_a_level_are_at_its_index_whatever_the_order() -> None:
    result, _rows = run(BRIEF, Always((0.0, 0.0, 0.0, 0.0)), seed=3)

    assert [level["level"] for level in result.levels] == [0, 1, 2]
    assert [level["speed"] for level in result.levels] == [0.1, 0.2, 0.3]
    assert sorted(result.conditions["order"]) == [0, 1, 2]


@pytest.mark.slow
def test_every_image_is_found_again_with_the_levels_out_of_order() -> None:
    settings = BRIEF | {"caustics": 0.8, "snow_per_m3": 200.0}  # which move from frame to frame
    _result, rows = run(settings, Always((0.0, 0.0, 0.0, 0.0)), seed=3)
    config = benchmark(NAME).read(settings)
    replay = Replay(NAME, config, lambda _trial: 3)

    for position, level in enumerate(EXPERIMENT.plan(config, seed=3, trial=0).order):
        row = rows[40 * position + 7]
        camera = EXPERIMENT.camera(config, seed=3, trial=0, level=level)
        motion = np.ascontiguousarray(row[INDEX["x"] : INDEX["r"] + 1])
        expected = camera.grey(motion, 40 * position + 7)

        assert row[INDEX["level"]] == level
        assert np.array_equal(replay.frame(row).grey(), expected)


def test_both_vehicles_take_turns_with_their_own_defaults() -> None:
    config = benchmark(NAME).read({})

    assert [config.for_trial(trial).vehicle for trial in range(4)] == [
        *("girona500", "bluerov2-heavy"),
    ] * 2
    assert [config.for_trial(trial).tilt_hold for trial in (0, 1)] == [False, True]
    assert config.for_trial(1).for_trial(1) == config.for_trial(1)


def test_a_single_vehicle_can_be_chosen_in_practice_but_not_in_a_ranked_run() -> None:
    entry = benchmark(NAME)
    single = entry.read({"vehicle": "bluerov2-heavy", "kp": 0.7})

    assert {single.for_trial(trial).vehicle for trial in range(3)} == {"bluerov2-heavy"}
    assert entry.ranked(single) == entry.read({"kp": 0.7})


def test_a_trial_is_the_same_bits_again_and_another_seed_is_another_trial() -> None:
    digests = [
        run(BRIEF, Always((0.0, 0.0, 0.0, 0.0)), seed=seed, trial=1)[0].digest for seed in (8, 8, 9)
    ]

    assert digests[0] == digests[1] != digests[2]


def test_a_camera_with_latency_shows_the_error_of_an_earlier_image() -> None:
    fixed = BRIEF | {
        "levels": [0.4],
        "level_duration_s": 6.0,
        "tracker": "truth",
        "range_from": "start",  # the error is then a function of the corners alone
        "level_out_tilt": False,
    }
    none = fixed | {"camera_delay_steps": 0, "command_delay_steps": 0}
    late = fixed | {"camera_delay_steps": 20, "command_delay_steps": 0}
    config = CurrentsConfiguration.read(late)
    steps = EXPERIMENT.drawn(config, seed=16, trial=0).camera_delay_steps

    _prompt, at_once = run(none, Always((0.0, 0.0, 0.0, 0.0)), seed=16)
    _delayed, later = run(late, Always((0.0, 0.0, 0.0, 0.0)), seed=16)

    # The vehicle drifts the same way: the program does not look.
    assert np.array_equal(at_once[:, INDEX["x"]], later[:, INDEX["x"]])
    assert np.array_equal(at_once[:, INDEX["tracked_x"]], later[:, INDEX["tracked_x"]])
    assert steps > 5
    first = INDEX["error_x"]
    now, then = at_once[:-steps, first : first + 2], later[steps:, first : first + 2]
    assert np.array_equal(now, then)
    assert np.ptp(at_once[:, first]) > 0.05


def test_the_score_is_the_area_under_the_quality_from_zero_to_the_strongest_current() -> None:
    levels = [
        {"speed": 0.1, "quality": 1.0},
        {"speed": 0.3, "quality": 0.5},
        {"speed": 0.4, "quality": 0.0},
    ]

    assert area_over_current(levels, "quality") == pytest.approx(0.1 + 0.2 * 0.75 + 0.1 * 0.25)
    assert area_over_current(levels[::-1], "quality") == area_over_current(levels, "quality")
    assert area_over_current(levels + levels, "quality") == pytest.approx(
        area_over_current(levels, "quality")
    )


def test_a_start_out_of_view_is_refused_with_the_largest_that_is_not() -> None:
    with pytest.raises(ConfigurationInvalid) as refused:
        CurrentsConfiguration.read({"altitude_m": 1.0})

    assert set(refused.value.errors) == {"start_offset_m"}
    assert "at most 0.17 m" in refused.value.errors["start_offset_m"]


SPREADS = [
    (name, limits_of(field)["minimum"], limits_of(field)["maximum"])
    for name, field in CurrentsConfiguration.model_fields.items()
    if group_of(field) == GROUP and field.annotation is not bool
]


@pytest.mark.slow
@settings(max_examples=30)
@given(data=st.data(), seed=st.integers(0, 1000))
def test_every_accepted_spread_gives_a_trial_with_a_finite_score(
    data: st.DataObject, seed: int
) -> None:
    drawn = data.draw(st.lists(st.sampled_from(SPREADS), min_size=1, max_size=6))
    values = {
        name: data.draw(st.integers(low, high) if "steps" in name else st.floats(low, high))
        for name, low, high in drawn
    }
    brief = {"levels": [1.0], "level_duration_s": 2.0, "settle_s": 1.0, "tracker": "truth"}

    with contextlib.suppress(ConfigurationInvalid):
        result, _rows = run(brief | values, Always((0.2, -0.1, 0.0, 0.1)), seed=seed)

        assert np.isfinite(result.score)
        assert json.dumps(result.conditions, allow_nan=False)
