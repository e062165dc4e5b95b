"""Programs at a level of a benchmark, and the rows that they leave."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from seamark.sim.benchmarks.in_current import InCurrent
from seamark.sim.control.observation import Observation, arm_size
from seamark.sim.engine.program import Command


def over_trials(few: object, every: object) -> pytest.MarkDecorator:
    """Give a test `trials`: a few in each run of the suite, and the statistics as a long test."""
    parameters = [
        pytest.param(few, id="few"),
        pytest.param(every, id="every", marks=pytest.mark.long),
    ]
    return pytest.mark.parametrize("trials", parameters)


class Driver:
    """A `Program` out of something with `reset` and `step`; it keeps its commands."""

    def __init__(self, controller: Any, config: Any) -> None:
        arm = config.chosen_arm()
        self._controller, self._size = controller, arm_size(arm) if arm else None
        self._told = config.told()
        self.commands: list[Command] = []

    def reset(self, level: Any) -> None:
        self._controller.reset(level)

    def step(self, values: NDArray[np.float64]) -> Command:
        observation = Observation(values, self._size, **self._told)
        command = tuple(map(float, self._controller.step(observation)))
        self.commands.append(command)
        return command


class Still:
    """Holds still."""

    def reset(self, level: Any) -> None:
        pass

    def step(self, observation: Observation) -> Command:
        return (0.0,) * 9


class Playback:
    """Repeats the commands of a run that it has seen."""

    def __init__(self, commands: Sequence[Command]) -> None:
        self._commands = commands

    def reset(self, level: Any) -> None:
        self._at = 0

    def step(self, observation: Observation) -> Command:
        self._at += 1
        return self._commands[self._at - 1]


def rows_of(
    experiment: InCurrent[Any], config: Any, driver: Driver, *, seed: int, trial: int
) -> NDArray[np.float64]:
    """Return the rows of the first level."""
    rows: list[NDArray[np.float64]] = []
    experiment.level(config, driver, seed=seed, trial=trial, level=0).run(rows.append)
    return np.concatenate(rows)
