"""currents-v3: its vehicles, what ranks, and what a program is told."""

from typing import Any

import numpy as np
import pytest

from seamark.sim.benchmarks.currents_v3.definition import BENCHMARK
from seamark.sim.benchmarks.currents_v3.experiment import EXPERIMENT
from seamark.sim.engine.trial import TrialResult, run_trial
from seamark.sim.numerics.arrays import Array
from seamark.sim.recording.telemetry import INDEX
from seamark.sim.registry import benchmark

NAME = "currents-v3"
BRIEF = {"levels": [0.1, 0.2], "level_duration_s": 40.0, "settle_s": 5.0, "tracker": "truth"}
# From starboard, steadily, with nothing else drawn.
ABEAM: dict[str, Any] = {
    "level_duration_s": 40.0,
    "settle_s": 20.0,
    "tracker": "truth",
    "current_azimuth_rad": 1.5708,
    "current_swing_rad": 0.0,
} | dict.fromkeys(
    (
        *("azimuth_spread_rad", "phase_spread_rad", "change_turn_rad", "change_speed_share"),
        *("start_offset_m", "start_heading_rad", "weak_thruster_probability"),
    ),
    0.0,
)


def run(name: str, trial: int, **settings: Any) -> tuple[TrialResult, Array]:
    rows: list[Array] = []
    config = benchmark(NAME).read(settings)
    program = EXPERIMENT.built_in(name, config.for_trial(trial))
    result = run_trial(NAME, config, program, seed=5, trial=trial, on_rows=rows.append)
    return result, np.concatenate(rows)


def test_both_vehicles_take_turns_and_their_forces_are_measured() -> None:
    config = benchmark(NAME).read({})

    assert [config.for_trial(trial).vehicle for trial in range(3)] == [
        *("girona500", "bluerov2-heavy-v2", "girona500"),
    ]
    assert config.for_trial(1).tilt_hold
    assert benchmark(NAME).ranked(benchmark(NAME).read({"vehicle": "girona500"})) == config


@pytest.mark.parametrize("trial", [0, 1])
def test_doing_nothing_scores_next_to_nothing_and_does_not_rank(trial: int) -> None:
    result, _rows = run("nothing", trial, **BRIEF)

    assert result.score < 0.15 * 0.2
    assert not result.trial_score.rankable


def test_the_controller_that_turns_the_bow_may_be_submitted_and_the_oracle_may_not() -> None:
    assert "into-current" in BENCHMARK.built_in
    assert "oracle" in BENCHMARK.reference_built_in
    assert "into-current" not in BENCHMARK.reference_built_in


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "trial", "speed"), [("into-current", 0, 0.45), ("oracle", 1, 0.9)]
)
def test_beyond_the_limit_from_abeam_only_who_turns_holds_the_tool(
    name: str, trial: int, speed: float
) -> None:
    turned, rows = run(name, trial, **ABEAM, levels=[speed])
    held, straight = run("lqr", trial, **ABEAM, levels=[speed])

    settled = slice(len(rows) // 2, None)
    assert np.all(np.abs(rows[settled, INDEX["yaw"]]) > 0.8)
    assert np.all(np.abs(straight[settled, INDEX["yaw"]]) < 0.8)
    assert turned.score > 4.0 * held.score
    assert turned.levels[0]["whole_lost_percent"] == 0.0


@pytest.mark.slow
def test_in_a_weak_current_the_vehicle_keeps_the_heading_of_the_station() -> None:
    result, rows = run("into-current", 0, **ABEAM, levels=[0.1])

    assert np.max(np.abs(rows[:, INDEX["yaw"]])) < 0.1
    assert result.levels[0]["quality"] > 0.7  # what a wrong compass leaves
