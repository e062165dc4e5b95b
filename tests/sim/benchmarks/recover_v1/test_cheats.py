"""Programs that do not recover the box stay at the bottom of recover-v1, whatever they do to it."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from seamark.sim.benchmarks.recover_v1.experiment import EXPERIMENT
from seamark.sim.benchmarks.recover_v1.settings import RecoverConfiguration
from seamark.sim.control.manipulation.recover import Blind, Scripted
from seamark.sim.control.observation import Observation, arm_size
from seamark.sim.engine.program import Command
from seamark.sim.metrics.recovery import STAGES

pytestmark = pytest.mark.slow
CONFIG = RecoverConfiguration.read({"levels": [0.1], "level_duration_s": 40.0})
SEED = 2026
TOUCHED = STAGES[1].credit


class Driver:
    """A `Program` out of something with `reset` and `step`; it keeps its commands."""

    def __init__(self, controller: Any) -> None:
        self._controller, self._size = controller, arm_size(CONFIG.the_arm())
        self.commands: list[Command] = []

    def reset(self, level: Any) -> None:
        self._controller.reset(level)

    def step(self, values: NDArray[np.float64]) -> Command:
        command = tuple(map(float, self._controller.step(Observation(values, self._size))))
        self.commands.append(command)
        return command


class Bulldozer(Scripted):
    """Comes down before the box and drives through it, jaws first."""

    def step(self, observation: Observation) -> Sequence[float]:
        command = list(super().step(observation))
        self.offset = 0.05
        if observation.t > 15.0:
            command[0] = 0.5
        return command

    def _advance(self, *arguments: Any) -> None:
        self.falling = 0.0


class Dropper(Scripted):
    """Comes over the box and lets the vehicle fall on it."""

    def step(self, observation: Observation) -> Sequence[float]:
        command = list(super().step(observation))
        if observation.t > 12.0:
            command[2] = 1.0
        return command

    def _advance(self, *arguments: Any) -> None:
        self.falling = 0.0


class Presser(Scripted):
    """Presses the closed hand on the box."""

    def _posture(self, joints: list[float], wrist: float) -> list[float]:
        speeds = super()._posture(joints, wrist)
        return [*speeds[:-1], -self.kinematics.fastest[self.jaw]]


class Thrower(Scripted):
    """Takes the box up and lets go of it at once."""

    def step(self, observation: Observation) -> Sequence[float]:
        command = list(super().step(observation))
        if self.phase == 4 and self.since_s > 0.3:
            command[-1] = self.kinematics.fastest[self.jaw]
        return command


class Playback:
    """Repeats the commands of a run that it has seen."""

    def __init__(self, commands: Sequence[Command]) -> None:
        self._commands = commands

    def reset(self, level: Any) -> None:
        self._at = 0

    def step(self, observation: Observation) -> Command:
        self._at += 1
        return self._commands[self._at - 1]


def credit_of(controller: Any, trial: int = 0) -> float:
    """Return the credit of a level."""
    rows: list[NDArray[np.float64]] = []
    EXPERIMENT.level(CONFIG, Driver(controller), seed=SEED, trial=trial, level=0).run(rows.append)
    metrics = EXPERIMENT.metrics(CONFIG, 0, np.concatenate(rows))
    return float(metrics["credit"])


@pytest.mark.parametrize("cheat", [Bulldozer, Dropper, Presser])
def test_who_only_strikes_or_pushes_the_box_gets_a_touch_at_most(
    cheat: Callable[[Any], Any],
) -> None:
    assert credit_of(cheat(CONFIG.for_program())) <= TOUCHED


def test_a_box_that_is_let_go_at_once_is_not_lifted() -> None:
    assert credit_of(Thrower(CONFIG.for_program())) < STAGES[3].credit


def test_commands_that_recovered_the_box_once_recover_no_other() -> None:
    honest = Driver(Scripted(CONFIG.for_program()))
    rows: list[NDArray[np.float64]] = []
    EXPERIMENT.level(CONFIG, honest, seed=SEED, trial=0, level=0).run(rows.append)
    assert EXPERIMENT.metrics(CONFIG, 0, np.concatenate(rows))["credit"] > STAGES[2].credit

    others = [credit_of(Playback(honest.commands), trial) for trial in (1, 2, 3)]

    assert max(others) <= TOUCHED


def test_who_looks_once_recovers_less_than_who_keeps_looking() -> None:
    trials = (0, 2, 3)
    seeing = [credit_of(Scripted(CONFIG.for_program()), trial) for trial in trials]
    blind = [credit_of(Blind(CONFIG.for_program()), trial) for trial in trials]

    assert sum(blind) < 0.5 * sum(seeing)
