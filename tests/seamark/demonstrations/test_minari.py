"""The layout of Minari, as Minari reads it."""

import json
from pathlib import Path
from typing import Any

import minari
import numpy as np
import pytest

from tests.seamark.demonstrations.replay import replayed

pytestmark = pytest.mark.slow  # all simulate


def test_minari_reads_episodes_that_the_environment_repeats_bit_for_bit(of_minari: Path) -> None:
    data = minari.MinariDataset(of_minari / "data")
    about = list(data.storage.get_episode_metadata(range(3)))
    compared = 0

    for episode, told in zip(data.iterate_episodes(), about, strict=True):
        steps = replayed(of_minari, told["seed"], int(told["options"]["level"]), episode.actions)
        for at, step in enumerate(steps):
            for name, values in step.observation.items():
                np.testing.assert_array_equal(episode.observations[name][at], values)
                compared += 1
            if at:
                assert episode.rewards[at - 1] == step.reward
                assert episode.truncations[at - 1] == step.truncated
                assert episode.terminations[at - 1] == step.terminated
        assert episode.infos["credit"][-1] == told["credit"]

    assert compared == 3 * 41 * 3
    assert [told["seed"] for told in about] == [1_000_000, 1_000_001, 1_000_002]
    assert [told["current_m_s"] for told in about] == [0.0, 0.1, 0.0]


def test_minari_makes_the_environment_again(of_minari: Path) -> None:
    data = minari.MinariDataset(of_minari / "data")

    env: Any = data.recover_environment()

    assert env.observation_space == data.observation_space
    assert env.action_space == data.action_space
    assert (data.total_episodes, data.total_steps) == (3, 120)
    assert data.id == "seamark/valve-v1/scripted-v0"
    assert data.spec.dataset_name == "scripted"


def test_what_minari_is_told_is_what_minari_would_write(of_minari: Path, tmp_path: Path) -> None:
    data = minari.MinariDataset(of_minari / "data")
    own = minari.dataset.minari_storage.MinariStorage.new(
        tmp_path / "own", data.observation_space, data.action_space, data.env_spec
    )
    expected = json.loads((own.data_path / "metadata.json").read_text())
    ours = json.loads((of_minari / "data" / "metadata.json").read_text())

    for name in ("data_format", "jpeg_encoding", "observation_space", "action_space", "env_spec"):
        assert ours[name] == expected[name]
