"""Replaying a demonstration in the environment that its `seamark.json` describes."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import gymnasium
import numpy as np
from numpy.typing import NDArray

import seamark.gym  # noqa: F401  # registers the environments


class Step(NamedTuple):
    """What a step of the replayed episode gives; the first one has no reward."""

    observation: Any
    reward: float = 0.0
    terminated: bool = False
    truncated: bool = False


def replayed(folder: Path, seed: int, level: int, actions: NDArray[Any]) -> Iterator[Step]:
    """Yield the replayed episode."""
    told = json.loads((folder / "seamark.json").read_text())
    env: Any = gymnasium.make(told["environment"], **told["options"]).unwrapped
    observation, _ = env.reset(seed=seed, options={"trial": 0, "level": level})
    yield Step(observation)
    for action in actions:
        observation, reward, terminated, truncated, _ = env.step(np.asarray(action))
        yield Step(observation, reward, terminated, truncated)
    env.close()
