"""The environment of a benchmark whose programs enter a dock."""

from typing import Any

import gymnasium
import numpy as np
import pytest

import seamark.gym  # noqa: F401  # registers the environments
from seamark.gym.spaces import named
from seamark.sim import registry
from seamark.sim.control.dock.entries import Straight
from seamark.sim.engine.trial import run_trial
from seamark.sim.recording.telemetry import INDEX, STEP_US, Rows

pytestmark = pytest.mark.slow
NEAR = {"approach_least_m": 0.0, "approach_most_m": 0.2, "approach_rise_m": 0.0}
SHORT = {"levels": [0.0], "level_duration_s": 30.0, "vehicle": "bluerov2-heavy-v2"} | NEAR
SEED = 12


def test_a_built_in_controller_earns_its_quality_and_leaves_the_rows_of_a_run() -> None:
    env: Any = gymnasium.make("seamark/Dock-v1", settings=SHORT).unwrapped
    entry = registry.benchmark("dock-v1")
    config = entry.read(SHORT)
    expert = Straight(config.for_program())
    expert.reset({})
    run: list[Rows] = []
    solution = entry.load().built_in("straight", config)
    whole = run_trial("dock-v1", config, solution, seed=SEED, trial=0, on_rows=run.append)

    observation, info = env.reset(seed=SEED)
    rows, earned, over = [env.telemetry], 0.0, False
    while not over:
        action = np.array(expert.step(named(observation, dock=True)))
        observation, reward, _ended, over, info = env.step(action)
        earned += float(reward)
        rows.append(env.telemetry)

    recorded = np.concatenate(run)
    recorded[:, [STEP_US, *range(INDEX["ref_u"], INDEX["ref_r"] + 1)]] = 0.0
    assert np.array_equal(np.array(rows[:-1]), recorded, equal_nan=True)
    assert whole.levels[0]["docked"] == 1.0
    assert earned == pytest.approx(whole.levels[0]["docking"], abs=1e-12)
    assert info["credit"] == whole.levels[0]["docking"]
    assert info["stages"] == 4
    assert np.abs(info["off_seat"]).max() < 0.1
    env.close()
