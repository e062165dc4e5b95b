"""Environments with a vehicle of the user's own: the file decides, in one process and in many."""

from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

import seamark.gym  # noqa: F401  # registers the environments
from seamark.sim.vehicles.reading import VehicleInvalid

NAME = "seamark/StationKeeping-v3"
SHORT = {"tracker": "truth", "levels": [0.1], "level_duration_s": 2.0, "settle_s": 0.5}
MINE = """
format = 1
name = "mine"
title = "Mine"
summary = "The second BlueROV2 Heavy under another name."
extends = "bluerov2-heavy-v2"
"""
HEAVY = '[body]\nmass = { value = 20, unit = "kg", tag = "E", reason = "a load" }\n'


@pytest.fixture
def mine(tmp_path: Path) -> Path:
    path = tmp_path / "mine.toml"
    path.write_text(MINE, encoding="utf-8")
    return path


def last(env: Any) -> np.ndarray:
    """The observation after a second full ahead."""
    observation, _ = env.reset(seed=3)
    action = np.zeros(env.action_space.shape)
    action[..., 0] = 0.5
    for _ in range(20):
        observation, *_ = env.step(action)
    env.close()
    return np.asarray(observation)


@pytest.mark.parametrize("form", [str, Path])
def test_a_file_with_the_numbers_of_our_vehicle_gives_the_same_observations(
    mine: Path, form: type[Any]
) -> None:
    own = gymnasium.make(NAME, settings=SHORT | {"vehicle": form(mine)})
    ours = gymnasium.make(NAME, settings=SHORT | {"vehicle": "bluerov2-heavy-v2"})

    np.testing.assert_array_equal(last(own), last(ours))


def test_the_vehicles_of_a_vector_are_that_of_the_file(mine: Path) -> None:
    single = gymnasium.make(NAME, settings=SHORT | {"vehicle": str(mine)})
    many = gymnasium.make_vec(NAME, num_envs=3, settings=SHORT | {"vehicle": str(mine)})

    np.testing.assert_array_equal(last(many)[0], last(single))


def test_another_file_is_another_vehicle(mine: Path) -> None:
    light = last(gymnasium.make(NAME, settings=SHORT | {"vehicle": str(mine)}))
    mine.write_text(MINE + HEAVY, encoding="utf-8")

    heavy = last(gymnasium.make(NAME, settings=SHORT | {"vehicle": str(mine)}))

    assert not np.array_equal(light, heavy)


@pytest.mark.slow
def test_another_process_reads_the_file_itself(mine: Path) -> None:
    env = gymnasium.make_vec(
        NAME,
        num_envs=1,
        vectorization_mode="async",
        vector_kwargs={"context": "spawn"},
        settings=SHORT | {"vehicle": str(mine)},
    )
    single = gymnasium.make(NAME, settings=SHORT | {"vehicle": str(mine)})

    np.testing.assert_array_equal(last(env)[0], last(single))


def test_a_broken_file_is_refused_with_a_sentence(mine: Path) -> None:
    mine.write_text(MINE + HEAVY.replace("20", "-20"), encoding="utf-8")

    with pytest.raises(VehicleInvalid, match="must be above 0, not -20"):
        gymnasium.make(NAME, settings=SHORT | {"vehicle": str(mine)})
