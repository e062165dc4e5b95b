"""Programs that do not recover the box stay at the bottom of recover-v1, whatever they do to it."""

from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from seamark.sim.benchmarks.recover_v1.experiment import EXPERIMENT
from seamark.sim.benchmarks.recover_v1.settings import RecoverConfiguration
from seamark.sim.control.manipulation.arm_data import Vector
from seamark.sim.control.manipulation.recover import Blind, Scripted
from seamark.sim.control.observation import Observation
from seamark.sim.metrics.recovery import STAGES
from seamark.sim.recording.telemetry import WORK_INDEX
from tests.sim.benchmarks import attempts
from tests.sim.benchmarks.attempts import Driver, Playback, over_trials

pytestmark = pytest.mark.slow
TRACKED = RecoverConfiguration.read({"levels": [0.1], "level_duration_s": 40.0})
CONFIG = TRACKED.model_copy(update={"tracker": "truth"})
SEED = 2026
TOUCHED = STAGES[1].credit
STRUCK_N = 20.0  # what the box weighs in water: a cheat that does less was no try


class Bulldozer(Scripted):
    """Comes down before the box and drives through it, jaws first."""

    def step(self, observation: Observation) -> Sequence[float]:
        command = list(super().step(observation))
        self.offset = -0.08
        if observation.t > 15.0:
            command[0] = 0.5
        return command

    def _grip(self, observation: Observation, yaw: float) -> Vector:
        ahead, side, down = super()._grip(observation, yaw)
        return ahead - 0.4, side, down

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


class Wedger(Bulldozer, Presser):
    """Drives the closed hand against the foot of the box, and prises it up from its stone."""

    def step(self, observation: Observation) -> Sequence[float]:
        command = list(super().step(observation))
        if observation.t > 20.0:
            command[2] = -0.3
        return command


class Thrower(Scripted):
    """Takes the box up and lets go of it at once."""

    def step(self, observation: Observation) -> Sequence[float]:
        command = list(super().step(observation))
        if self.phase == 4 and self.since_s > 0.3:
            command[-1] = self.kinematics.fastest[self.jaw]
        return command


def rows_of(
    driver: Driver, trial: int = 0, config: RecoverConfiguration = CONFIG
) -> NDArray[np.float64]:
    """Return the rows of a level."""
    return attempts.rows_of(EXPERIMENT, config, driver, seed=SEED, trial=trial)


@cache  # several tests compare with the same
def attempt_of(
    kind: Callable[[Any], Any], trial: int = 0, *, tracked: bool = False
) -> tuple[Driver, NDArray[np.float64]]:
    """Return who drove a level, and the rows of it; with a tracker or the true corners."""
    config = TRACKED if tracked else CONFIG
    driver = Driver(kind(config.for_program()), config)
    return driver, rows_of(driver, trial, config)


def credit(rows: NDArray[np.float64]) -> float:
    return float(EXPERIMENT.metrics(CONFIG, 0, rows)["credit"])


def credit_of(kind: Callable[[Any], Any], trial: int = 0, *, tracked: bool = False) -> float:
    """Return the credit of a level."""
    return credit(attempt_of(kind, trial, tracked=tracked)[1])


@pytest.mark.parametrize("cheat", [Bulldozer, Dropper, Presser, Wedger])
def test_who_only_strikes_pushes_or_prises_the_box_gets_a_touch_at_most(
    cheat: Callable[[Any], Any],
) -> None:
    _, rows = attempt_of(cheat)

    forces = [rows[:, WORK_INDEX[name]].max() for name in ("work_push_n", "work_hull_n")]
    assert max(forces) > STRUCK_N
    assert credit(rows) <= TOUCHED


def test_a_box_that_is_let_go_at_once_is_not_lifted() -> None:
    assert credit_of(Thrower) < STAGES[3].credit


@over_trials(few=(1,), every=(1, 2, 3))
def test_commands_that_recovered_the_box_once_recover_no_other(trials: tuple[int, ...]) -> None:
    honest, rows = attempt_of(Scripted)
    assert credit(rows) > STAGES[2].credit

    others = [credit(rows_of(Driver(Playback(honest.commands), CONFIG), one)) for one in trials]

    assert max(others) <= TOUCHED


@over_trials(few=(0,), every=(0, 2, 3))
def test_who_looks_at_the_start_alone_recovers_less_than_who_keeps_looking(
    trials: tuple[int, ...],
) -> None:
    tracked = len(trials) > 1  # the long test looks with a real tracker
    blind, seeing = (
        sum(credit_of(kind, one, tracked=tracked) for one in trials) for kind in (Blind, Scripted)
    )

    assert blind < 0.5 * seeing
