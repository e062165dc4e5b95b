"""Gymnasium's own wrappers and training loops take the environments as they are."""

import warnings
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium import wrappers
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode
from gymnasium.wrappers import vector

import seamark.gym  # noqa: F401  # registers the environments

NAME = "seamark/StationKeeping-v3"
LENGTH = 40  # steps of a level
SHORT = {"tracker": "truth", "levels": [0.1, 0.6], "level_duration_s": 2.0, "settle_s": 1.0}
FOR_POLICIES: dict[str, Any] = {"settings": SHORT, "dtype": "float32", "normalise_actions": True}


def single(**options: Any) -> Any:
    return gymnasium.make(NAME, **FOR_POLICIES, **options)


def many(**options: Any) -> Any:
    return gymnasium.make_vec(NAME, num_envs=3, **FOR_POLICIES, **options)


@pytest.mark.slow
@pytest.mark.parametrize("observation", ["state", "image", "image+state"])
def test_the_checker_of_gymnasium_has_no_objections(observation: str) -> None:
    env = single(observation=observation, render_mode="rgb_array")

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", message=".*infinity")  # most numbers have no bound
        check_env(env.unwrapped)


def test_wrappers_of_one_environment_stack_flatten_and_count() -> None:
    stacked = wrappers.FrameStackObservation(single(observation="image"), 4)
    flat = wrappers.FlattenObservation(single(observation="image+state"))
    counted = wrappers.NormalizeReward(wrappers.RecordEpisodeStatistics(single()))
    for env in (stacked, flat, counted):
        env.reset(seed=7)
        for _ in range(LENGTH):
            observation, *_, truncated, info = env.step(env.action_space.sample())
        assert env.observation_space.contains(observation)
        assert truncated

    assert stacked.observation_space.shape == (4, 84, 84, 1)
    assert info["episode"]["l"] == LENGTH


@pytest.mark.parametrize("mode", ["NextStep", "SameStep"])
def test_statistics_of_many_vehicles_are_of_whole_levels(mode: str) -> None:
    env = vector.NormalizeReward(
        vector.ClipAction(vector.RecordEpisodeStatistics(many(autoreset_mode=mode)))
    )
    env.reset(seed=7)
    lengths: list[int] = []

    for _ in range(3 * LENGTH + 3):
        *_, info = env.step(env.action_space.sample())
        if "episode" in info:
            lengths += info["episode"]["l"][info["_episode"]].tolist()

    assert lengths == [LENGTH] * 9


def test_statistics_of_vehicles_that_are_reset_by_a_mask_are_of_whole_levels() -> None:
    env = vector.RecordEpisodeStatistics(many(autoreset_mode="Disabled"))
    env.reset(seed=7)
    env.reset(options={"reset_mask": np.array([True, False, False])})
    ended = 0

    for _ in range(2 * LENGTH):
        _, _, terminated, truncated, info = env.step(env.action_space.sample())
        if (over := terminated | truncated).any():
            assert (info["episode"]["l"][over] == LENGTH).all()
            ended += int(over.sum())
            env.reset(options={"reset_mask": over})

    assert ended == 6


def test_wrappers_of_many_vehicles_take_images() -> None:
    small = vector.ResizeObservation(many(observation="image"), (42, 42))
    flat = vector.FlattenObservation(many(observation="image+state"))
    normal = vector.NormalizeObservation(many())
    for env in (small, flat, normal):
        env.reset(seed=7)
        observations, *_ = env.step(env.action_space.sample())
        assert observations.shape == env.observation_space.shape

    assert flat.observation_space.shape == (3, 84 * 84 + 29)


def test_the_last_observation_of_a_level_is_the_same_in_each_autoreset_mode() -> None:
    """A value function sees it as `final_obs`, or before the step that only resets."""
    last = {}
    for mode in AutoresetMode:
        env = many(autoreset_mode=mode)
        assert env.autoreset_mode is env.metadata["autoreset_mode"] is mode  # TorchRL asks for it
        env.reset(seed=7)
        for _ in range(LENGTH):
            seen, *_, info = env.step(np.full((3, 4), 0.2, np.float32))
        final = info.get("final_obs")
        last[mode] = seen if final is None else np.stack(final[info["_final_obs"]])

    np.testing.assert_array_equal(last[AutoresetMode.NEXT_STEP], last[AutoresetMode.SAME_STEP])
    np.testing.assert_array_equal(last[AutoresetMode.NEXT_STEP], last[AutoresetMode.DISABLED])


def test_each_vehicle_has_the_seed_that_it_is_given() -> None:
    seeds = [40, 7, 40]
    together, info = many().reset(seed=seeds)

    alone = [single().reset(seed=seed)[0] for seed in seeds]

    np.testing.assert_array_equal(together, alone)
    assert info["seed"].tolist() == seeds
