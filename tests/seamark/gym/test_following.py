"""The environment of a benchmark whose programs follow a route."""

import warnings
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import seamark.gym  # noqa: F401  # registers the environments
from seamark.gym.spaces import named
from seamark.sim import registry
from seamark.sim.control.track.guidance import LineOfSight
from seamark.sim.engine.trial import run_trial
from seamark.sim.metrics.following import share_followed
from seamark.sim.recording.telemetry import INDEX, STEP_US, Rows

pytestmark = pytest.mark.slow
SHORT = {"levels": [0.1], "level_duration_s": 10.0, "vehicle": "girona500"}
SEED = 12


def test_the_environment_passes_the_checks_of_gymnasium() -> None:
    env = gymnasium.make("seamark/Track-v1", settings=SHORT).unwrapped

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # unbounded observations
        check_env(env, skip_render_check=True)
    env.close()


def test_a_built_in_controller_earns_what_it_follows_and_leaves_the_rows_of_a_run() -> None:
    env: Any = gymnasium.make("seamark/Track-v1", settings=SHORT).unwrapped
    entry = registry.benchmark("track-v1")
    config = entry.read(SHORT).for_trial(0)
    expert = LineOfSight(config.for_program())
    expert.reset({})
    run: list[Rows] = []
    solution = entry.load().built_in("los", config)
    run_trial("track-v1", entry.read(SHORT), solution, seed=SEED, trial=0, on_rows=run.append)
    whole = np.concatenate(run)

    observation, info = env.reset(seed=SEED)
    rows, earned, over = [env.telemetry], 0.0, False
    while not over:
        action = np.array(expert.step(named(observation, route=True)))
        observation, reward, _ended, over, info = env.step(action)
        earned += float(reward)
        rows.append(env.telemetry)

    decided = [STEP_US, *range(INDEX["ref_u"], INDEX["ref_r"] + 1)]
    whole[:, decided] = 0.0
    assert np.array_equal(np.array(rows[:-1]), whole, equal_nan=True)
    followed = float(share_followed(np.array(rows), 0.0).sum())
    assert earned == pytest.approx(followed - float(share_followed(rows[0][None], 0.0)[0]))
    assert earned > 0.02
    assert info["along"] > 0.5
    env.close()


def test_an_observation_has_the_image_of_the_sonar() -> None:
    env: Any = gymnasium.make("seamark/Track-v1", settings=SHORT | {"sonar": "forward"}).unwrapped

    observation, _info = env.reset(seed=SEED)

    assert env.observation_space["image_sonar"].shape == (400, 256)
    assert env.observation_space.contains(observation)
    seen = named(observation, route=True)
    assert seen.images["sonar"] is observation["image_sonar"]
    assert observation["image_sonar"].max() > 0
    env.close()
