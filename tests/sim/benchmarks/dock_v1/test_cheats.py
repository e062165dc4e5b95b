"""Programs that do not find and enter the dock stay at the bottom of dock-v1."""

from collections.abc import Iterable
from functools import cache
from typing import Any

import numpy as np
import pytest

from seamark.sim.benchmarks.dock_v1.experiment import EXPERIMENT
from seamark.sim.benchmarks.dock_v1.settings import DockConfiguration
from seamark.sim.control.dock.entries import HOVER_M, Acoustic, Blind, Staged, Straight
from seamark.sim.engine.program import BuiltIn
from tests.sim.benchmarks.attempts import Driver, Playback, Still, over_trials, rows_of

pytestmark = pytest.mark.slow
CONFIG = DockConfiguration.read({"levels": [0.2]})
SEED = 91


class Sitter(Straight):
    """Waits above the dock."""

    def _heave(self, off_m: float, turn_rad: float, dt: float) -> float:
        return self._to(HOVER_M)


class Diver(Straight):
    """Dives at full thrust as soon as it is above the mouth."""

    def _heave(self, off_m: float, turn_rad: float, dt: float) -> float:
        return 1.0 if off_m < 0.5 else self._to(HOVER_M)


def metrics_of(program: Any, trial: int, seed: int = SEED) -> dict[str, Any]:
    config = CONFIG.for_trial(trial)
    rows = rows_of(EXPERIMENT, config, program, seed=seed, trial=trial)
    return EXPERIMENT.metrics(config, 0, rows)


def controller(kind: Any, trial: int) -> Driver:
    return Driver(kind(CONFIG.for_trial(trial).for_program()), CONFIG)


def qualities(kind: Any, numbers: Iterable[int]) -> list[float]:
    return [float(metrics_of(controller(kind, trial), trial)["docking"]) for trial in numbers]


@cache
def honest(trial: int) -> tuple[Driver, dict[str, Any]]:
    """Return a driver that docked, with the commands by which it did, and its metrics."""
    driver = controller(Straight, trial)
    metrics = metrics_of(driver, trial)
    assert metrics["docking"] > 0.5
    return driver, metrics


EACH_VEHICLE = (0, 1)  # by turns
ONE_TRIAL = over_trials(few=(0,), every=EACH_VEHICLE)
Trials = tuple[int, ...]


@over_trials(few=(1,), every=EACH_VEHICLE)
def test_a_staged_approach_docks_too_without_a_strike(trials: Trials) -> None:
    for trial in trials:
        found = metrics_of(controller(Staged, trial), trial)
        assert (found["docked"], found["dock_strikes"]) == (1.0, 0.0)
        assert found["held"]


@ONE_TRIAL
def test_holding_still_earns_next_to_nothing(trials: Trials) -> None:
    still = [metrics_of(Driver(Still(), CONFIG), trial)["docking"] for trial in trials]

    assert np.mean(still) < 0.05


@over_trials(few=(1,), every=range(4))
@pytest.mark.parametrize("kind", [Acoustic, Blind])
def test_a_program_that_does_not_look_earns_little(kind: Any, trials: Trials) -> None:
    # One of them may be lucky: its first answer may be as good as the mouth is wide.
    assert np.mean(qualities(kind, trials)) < 0.25


@over_trials(few=(0,), every=range(4))
def test_waiting_above_the_mouth_earns_what_it_is_to_be_there(trials: Trials) -> None:
    assert max(qualities(Sitter, trials)) <= 0.05


@ONE_TRIAL
def test_diving_at_full_thrust_strikes_the_dock(trials: Trials) -> None:
    dived = [metrics_of(controller(Diver, trial), trial) for trial in trials]

    assert all(one["dock_strikes"] >= 1.0 for one in dived)
    assert max(one["docking"] for one in dived) < 0.4


@over_trials(few=(1,), every=EACH_VEHICLE)
def test_playing_back_the_commands_of_a_run_is_of_no_use_in_another(trials: Trials) -> None:
    for trial in trials:
        commands = honest(trial)[0].commands
        again = metrics_of(Driver(Playback(commands), CONFIG), trial)
        elsewhere = metrics_of(Driver(Playback(commands), CONFIG), trial, seed=SEED + 1)
        assert again["docking"] > 0.5  # the same water, the same commands: playback itself works
        assert elsewhere["docking"] <= 0.05


def test_a_built_in_controller_scores_what_the_same_controller_scores_as_a_program() -> None:
    config = CONFIG.for_trial(1)

    built_in = metrics_of(BuiltIn("straight", config, task="dock", dock=True), 1)
    assert built_in == honest(1)[1]
