"""visibility-v1: its levels, its score, and images that do not depend on the tracker."""

import hashlib
import json
import math
from collections.abc import Mapping
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from seamark.sim.benchmarks.visibility_v1.experiment import EXPERIMENT, water_at
from seamark.sim.benchmarks.visibility_v1.settings import (
    SWEEP_PRESETS,
    SWEEPS,
    VisibilityConfiguration,
)
from seamark.sim.engine.prescribed_path import PrescribedPath
from seamark.sim.engine.trial import TrialResult, run_trial
from seamark.sim.metrics.metric import over_run
from seamark.sim.metrics.tracking import (
    METRICS,
    failure_value,
    held_value,
    level_metrics,
)
from seamark.sim.recording.telemetry import INDEX, NAMES, WIDTH, Rows
from seamark.sim.registry import TRUTH, benchmark
from seamark.sim.settings.refusal import ConfigurationInvalid
from seamark.sim.trackers import Corners, Track, Window
from tests.services.prepared import printed

NAME = "visibility-v1"
SHORT = {"sweep_to": 1.0, "sweep_step": 0.5, "level_duration_s": 2.0}
ONE_RUN = f"""
import json
from seamark.sim.registry import benchmark
from seamark.sim.engine.trial import run_trial
config = benchmark({NAME!r}).read({SHORT!r})
result = run_trial({NAME!r}, config, None, seed=5, trial=0, on_rows=lambda rows: None)
print(json.dumps([result.digest, result.score]))
"""
shares = st.lists(st.floats(0.0, 100.0), min_size=2, max_size=30)


class Watching:
    """Reports the target at its first position, and keeps the hash of every image."""

    def __init__(self, step_px: float = 0.0) -> None:
        self.seen: list[str] = []
        self.first: list[str] = []
        self._step, self._shape = step_px, (0, 0)
        self._corners: Corners = np.zeros((4, 2))

    def start(self, image: NDArray[np.uint8], corners: Corners) -> None:
        self.first.append(hashlib.sha256(image.tobytes()).hexdigest())
        self._shape, self._corners = image.shape, corners.copy()

    def window(self) -> Window:
        return 0, 0, self._shape[1], self._shape[0]

    def update(self, image: NDArray[np.uint8]) -> Track:
        self.seen.append(hashlib.sha256(image.tobytes()).hexdigest())
        self._corners = self._corners + self._step
        return Track(self._corners, ok=True, residual=0.0, iterations=0)


def read(values: Mapping[str, object]) -> VisibilityConfiguration:
    config = benchmark(NAME).read(values)
    assert isinstance(config, VisibilityConfiguration)
    return config


def run(values: Mapping[str, object], solution: Any = None, seed: int = 5) -> TrialResult:
    config = read(values)
    return run_trial(NAME, config, solution, seed=seed, trial=0, on_rows=lambda _rows: None)


def rows_of(errors: list[float], *, ok: float = 1.0) -> Rows:
    rows = np.zeros((len(errors) + 1, WIDTH))
    rows[1:, INDEX["tracker_error"]] = errors
    rows[1:, INDEX["tracker_ok"]] = ok
    return rows


def test_the_default_sweep_is_the_optical_depth_from_0_to_7() -> None:
    config = read({})

    assert config.level_values() == config.optical_depths()
    assert (config.level_values()[0], config.level_values()[-1]) == (0.0, 7.0)
    assert config.trial_duration_s() == pytest.approx(len(config.level_values()) * 5.0)


def test_the_fog_sweep_is_the_published_configuration() -> None:
    config = read({"sweep": "fog"})

    assert (config.camera_width_px, config.camera_height_px) == (320, 240)
    assert len(config.level_values()) == 41
    assert config.level_values()[-1] == 2.0
    assert config.level_values()[1] == 0.05
    assert (config.level_duration_s, config.water_law, config.path_swing_m) == (5.0, "uwsim", 0.0)
    assert config.optical_depths()[-1] == pytest.approx((2.0 * 1.27) ** 2)


@pytest.mark.parametrize("law", ["beer", "uwsim"])
def test_the_transmission_of_a_levels_water_matches_its_optical_depth(law: str) -> None:
    config = read({"water_law": law})

    for level, depth in enumerate(config.optical_depths()):
        c, z = water_at(config, level).attenuation[1], config.altitude_m
        exponent = (c * z) ** 2 if law == "uwsim" else c * z
        assert exponent == pytest.approx(depth, abs=1e-9)


@pytest.mark.parametrize("sweep", SWEEPS)
def test_every_sweep_has_increasing_levels_and_valid_water(sweep: str) -> None:
    config = read({"sweep": sweep})

    values = config.level_values()
    assert all(a < b for a, b in pairwise(values))
    assert len({water_at(config, level) for level in range(len(values))}) == len(values)


@pytest.mark.parametrize(
    ("wrong", "setting"),
    [
        ({"sweep_to": 0.0}, "sweep_to"),
        ({"sweep_step": 0.3}, "sweep_step"),
        ({"sweep_step": 0.001}, "sweep_step"),
        ({"sweep": "fog", "water_law": "beer"}, "water_law"),
        ({"water_type": "IB"}, "water_type"),
        ({"path_swing_m": 0.9}, "path_swing_m"),
        ({"sweep": "camera_noise", "sweep_from": 0.0}, "sweep_from"),
        ({"altitude_m": 5.0}, "altitude_m"),
    ],
)
def test_an_invalid_sweep_is_rejected_at_its_setting(
    wrong: Mapping[str, object], setting: str
) -> None:
    with pytest.raises(ConfigurationInvalid) as error:
        read(wrong)

    assert setting in error.value.errors


def test_a_ranked_run_keeps_the_tracker_and_resets_the_scenario() -> None:
    mine = read({"warp": "srt", "sweep": "fog", "mode": "free", "kp": 2.0})

    ranked = benchmark(NAME).ranked(mine)

    assert ranked == read({"warp": "srt"})


def test_ground_truth_never_ranks() -> None:
    with pytest.raises(ConfigurationInvalid):
        benchmark(NAME).ranked(read({"tracker": TRUTH}))


@given(shares)
def test_the_failure_level_is_the_first_below_half(p5: list[float]) -> None:
    values = [0.25 * i for i in range(len(p5))]

    found = failure_value(values, p5)

    before = [share for value, share in zip(values, p5, strict=True) if value < found]
    assert all(share >= 50.0 for share in before)
    assert found not in values or p5[values.index(found)] < 50.0


@given(shares, st.integers(0, 29), st.floats(0.0, 100.0))
def test_a_better_level_never_lowers_the_failure_level(
    p5: list[float], at: int, more: float
) -> None:
    values = [0.25 * i for i in range(len(p5))]
    better = list(p5)
    better[at % len(p5)] = max(better[at % len(p5)], more)

    assert failure_value(values, better) >= failure_value(values, p5)


def test_a_tracker_that_never_fails_scores_more_than_one_that_fails_last() -> None:
    assert failure_value([0.0, 0.5, 1.0], [100.0, 100.0, 49.9]) == 1.0
    assert failure_value([0.0, 0.5, 1.0], [100.0, 100.0, 50.0]) == 1.5


def test_the_level_held_is_the_last_before_the_first_that_is_not_held() -> None:
    assert held_value([0.0, 0.5, 1.0], [True, False, True]) == 0.0
    assert held_value([0.0, 0.5], [False, True]) is None


def test_the_metrics_of_a_level_are_percentages_of_the_images_after_the_first() -> None:
    found = level_metrics(rows_of([0.5, 1.0, 5.0, 5.1, 10.1]))

    assert (found["p5_percent"], found["p1_percent"]) == (60.0, 40.0)
    assert found["corner_px"] == pytest.approx((0.5 + 1.0 + 5.0) / 3)
    assert (found["admitted_percent"], found["not_admitted_percent"]) == (0.0, 20.0)


def test_a_nan_error_counts_as_lost_and_not_as_a_success() -> None:
    found = level_metrics(rows_of([math.nan, math.inf]))

    assert (found["p5_percent"], found["not_admitted_percent"]) == (0.0, 100.0)
    assert found["corner_px"] is None


def test_a_tracker_that_reports_a_loss_has_no_success_however_close_it_is() -> None:
    found = level_metrics(rows_of([0.0, 20.0], ok=0.0))

    assert found["p5_percent"] == 0.0
    assert (found["admitted_percent"], found["not_admitted_percent"]) == (100.0, 0.0)


def test_the_metrics_over_all_levels_weight_each_image_equally() -> None:
    levels = [level_metrics(rows_of([1.0, 1.0])), level_metrics(rows_of([4.0, 20.0]))]

    found = over_run(METRICS, levels)

    assert set(found) == {metric.name for metric in METRICS}
    assert found["p5_percent"] == 75.0
    assert found["corner_px"] == pytest.approx(2.0)


def test_on_the_prescribed_path_all_trackers_see_the_same_images() -> None:
    still, restless = Watching(), Watching(step_px=3.0)
    run(SHORT, still)
    run(SHORT, restless)

    assert still.seen == restless.seen
    assert len(set(still.seen)) == len(still.seen) == 3 * 39


def test_settings_of_the_closed_loop_have_no_effect_on_the_prescribed_path() -> None:
    entries = benchmark(NAME).schema()["properties"]
    steering = {
        name: _another(entry)
        for name, entry in entries.items()
        if entry.get("x-applies") == {"mode": ["free"]}
    }
    assert {"kp", "dvl_sigma_m_s", "fault_thruster", "vehicle", "current_m_s"} <= set(steering)

    assert run(SHORT | steering).digest == run(SHORT).digest


def _another(entry: Mapping[str, Any]) -> object:
    """Return an allowed value of a setting that is not its default."""
    default = entry["default"]
    if entry["type"] == "boolean":
        return not default
    if "enum" in entry:
        return next(value for value in entry["enum"] if value != default)
    if entry["type"] == "integer":
        return default + 1
    return default / 2 or entry["maximum"] / 2


def test_in_closed_loop_the_vehicle_follows_its_tracker() -> None:
    still, restless = Watching(), Watching(step_px=3.0)
    run(SHORT | {"mode": "free"}, still)
    run(SHORT | {"mode": "free"}, restless)

    assert still.seen != restless.seen


def test_every_level_has_its_own_path_and_noise() -> None:
    tracker = Watching()
    run(SHORT, tracker)

    assert len(set(tracker.first)) == 3


def test_a_tracker_that_never_moves_fails_at_the_first_level() -> None:
    result = run(SHORT | {"level_duration_s": 5.0}, Watching())

    assert result.score == 0.0
    assert not result.trial_score.rankable


def test_a_perfect_tracker_fails_at_no_level() -> None:
    result = run(SHORT | {"tracker": TRUTH})

    assert result.score == 1.5
    assert result.trial_score.level_held == 1.0
    assert result.trial_score.overall["p1_percent"] == 100.0


def test_the_tracker_is_initialised_in_the_water_of_the_first_level() -> None:
    murky = {"sweep_from": 3.0, "sweep_to": 4.0, "sweep_step": 1.0, "level_duration_s": 2.0}
    clear = murky | {"sweep_from": 0.0, "sweep_step": 4.0}

    # At the last level both see the same water, but only one knows the target from clear water.
    learnt_murky = run(murky | {"criterion": "ssd"}).levels[-1]
    learnt_clear = run(clear | {"criterion": "ssd"}).levels[-1]

    assert learnt_murky["p5_percent"] > 90.0
    assert learnt_clear["p5_percent"] < 10.0


def test_unused_columns_stay_0_on_a_prescribed_path_and_the_others_vary() -> None:
    rows: list[Rows] = []
    config = read(SHORT)
    run_trial(NAME, config, None, seed=5, trial=0, on_rows=rows.append)
    table = np.concatenate(rows)

    idle = config.unused_columns()
    constant = {name for name, column in zip(NAMES, table.T, strict=True) if not np.ptp(column)}
    assert np.isfinite(table).all()
    assert all(not table[:, INDEX[name]].any() for name in idle)
    assert constant - idle <= {"trial", "tracker_ok"}


def test_the_velocities_of_a_path_are_those_of_its_poses() -> None:
    random = np.random.Generator(np.random.PCG64(4))
    path = PrescribedPath(
        [1.0, 2.0, 3.0, 0.0, 0.0, 0.4], [0.2] * 3 + [0.1] * 3, period_s=5.0, random=random
    )
    h = 1e-6

    (before, _), (pose, body), (after, _) = (
        path.pose_and_velocity(t) for t in (2.0 - h, 2.0, 2.0 + h)
    )

    rate = (np.array(after) - before) / (2 * h)
    roll, pitch, yaw = pose[3:]
    cy, sy, cp, sp, cr, sr = (f(a) for a in (yaw, pitch, roll) for f in (math.cos, math.sin))
    to_world = (
        np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
        @ np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
        @ np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    )
    assert to_world @ body[:3] == pytest.approx(rate[:3], abs=1e-8)
    to_rates = np.array([[1, sr * sp / cp, cr * sp / cp], [0, cr, -sr], [0, sr / cp, cr / cp]])
    assert to_rates @ body[3:] == pytest.approx(rate[3:], abs=1e-8)


@given(st.floats(0.0, 1e4), st.integers(0, 2**32))
def test_a_path_never_leaves_its_amplitudes(t: float, seed: int) -> None:
    amplitudes = np.array([0.25, 0.25, 0.05, 0.03, 0.03, 0.05])
    random = np.random.Generator(np.random.PCG64(seed))

    pose, _ = PrescribedPath(
        [0.0] * 6, amplitudes.tolist(), period_s=5.0, random=random
    ).pose_and_velocity(t)

    assert (np.abs(pose) <= amplitudes + 1e-12).all()


@pytest.mark.slow
def test_two_processes_give_the_same_bytes() -> None:
    here = run(SHORT)

    assert json.loads(printed(ONE_RUN)) == [here.digest, here.score]


def test_ssd_fails_long_before_zncc() -> None:
    levels = {"sweep_step": 1.0, "level_duration_s": 2.0}

    assert run(levels | {"criterion": "ssd"}).score < run(levels).score - 1.5


def test_presets_survive_reading_a_configuration_again() -> None:
    for sweep in SWEEP_PRESETS:
        config = read({"sweep": sweep})
        assert read(config.model_dump(mode="json")) == config


def test_an_image_is_rendered_again_in_the_water_of_its_level() -> None:
    config = read(SHORT)

    cameras = [EXPERIMENT.camera(config, seed=5, trial=0, level=level) for level in (0, 2)]

    assert cameras[0].water.attenuation[1] == 0.0
    assert cameras[1].water.attenuation[1] == pytest.approx(1.0 / 1.27)
