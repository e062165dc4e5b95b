"""The environment of visual tracking."""

import warnings
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from seamark.gym import BENCHMARKS
from seamark.sim import registry
from seamark.sim.engine.trial import run_trial
from seamark.sim.recording.telemetry import INDEX, STEP_US
from seamark.sim.trackers import make

VISUAL_TRACKING = [name for name in BENCHMARKS if "VisualTracking" in name]
SHORT = {"level_duration_s": 2.0}


def env_of(name: str, **options: Any) -> gymnasium.Env[Any, Any]:
    with warnings.catch_warnings():  # of the first versions: that there are second ones
        warnings.simplefilter("ignore", DeprecationWarning)
        return gymnasium.make(name, **options).unwrapped


@pytest.mark.parametrize("name", VISUAL_TRACKING)
def test_the_environment_passes_gymnasiums_checker(name: str) -> None:
    env = env_of(name, settings=SHORT, render_mode="rgb_array")

    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message=".*infinity")  # a tracker may say anything
        warnings.filterwarnings("ignore", message=".*symmetric and normalized")  # SI units
        check_env(env)


@pytest.mark.slow
@pytest.mark.parametrize("name", VISUAL_TRACKING)
def test_a_tracker_in_the_environment_makes_the_run_of_the_benchmark(name: str) -> None:
    entry = registry.benchmark(BENCHMARKS[name])
    config: Any = entry.read(dict(entry.quick_settings) | {"tracker": "box"})
    rows: list[Any] = []
    result = run_trial(entry.name, config, None, seed=5, trial=0, on_rows=rows.append)
    expected = {(row[INDEX["level"]], row[INDEX["t"]]): row for part in rows for row in part}
    env = env_of(name, settings=dict(entry.quick_settings))
    compared = 0

    for level in result.levels:
        observation, info = env.reset(seed=None if compared else 5)
        tracker = make("box", truth=None, **config.tracker_options())
        rewards: list[Any] = []
        over = False
        while not over:
            if observation["started"]:
                tracker.start(observation["start_image"], observation["start_corners"])
            track = tracker.update(observation["image"])
            action = np.array([*track.corners.ravel(), float(track.ok)])
            observation, reward, _terminated, over, _info = env.step(action)
            rewards.append(reward)
            row = env.telemetry  # type: ignore[attr-defined]
            np.testing.assert_array_equal(
                np.delete(row, STEP_US),
                np.delete(expected[row[INDEX["level"]], row[INDEX["t"]]], STEP_US),
            )
            compared += 1

        assert 100.0 * np.mean(rewards) == pytest.approx(
            level.get("net_percent", level["p5_percent"])
        )
        assert info["level"] == level["level"]
