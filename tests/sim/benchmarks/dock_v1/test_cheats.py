"""Programs that do not find and enter the dock stay at the bottom of dock-v1."""

from dataclasses import dataclass
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
# In the first trial who looks has docked by then, and has 0.59; lucky blind ones have not.
SHORT = DockConfiguration.read({"levels": [0.2], "level_duration_s": 40.0})
SEED = 91


class Sitter(Straight):
    """Waits above the dock."""

    def _heave(self, off_m: float, turn_rad: float, dt: float) -> float:
        return self._to(HOVER_M)


class Diver(Straight):
    """Dives at full thrust as soon as it is above the mouth."""

    def _heave(self, off_m: float, turn_rad: float, dt: float) -> float:
        return 1.0 if off_m < 0.5 else self._to(HOVER_M)


def metrics_of(
    program: Any, trial: int, settings: DockConfiguration, seed: int = SEED
) -> dict[str, Any]:
    config = settings.for_trial(trial)
    rows = rows_of(EXPERIMENT, config, program, seed=seed, trial=trial)
    return EXPERIMENT.metrics(config, 0, rows)


def controller(kind: Any, trial: int) -> Driver:
    return Driver(kind(CONFIG.for_trial(trial).for_program()), CONFIG)


@dataclass(frozen=True)
class Trials:
    """Some trials, of some settings."""

    numbers: tuple[int, ...]
    settings: DockConfiguration = CONFIG

    def metrics(self, kind: Any) -> list[dict[str, Any]]:
        return [metrics_of(controller(kind, one), one, self.settings) for one in self.numbers]

    def qualities(self, kind: Any) -> list[float]:
        return [float(metrics["docking"]) for metrics in self.metrics(kind)]


@cache
def honest(trial: int, settings: DockConfiguration) -> tuple[Driver, dict[str, Any]]:
    """Return a driver that docked, with the commands by which it did, and its metrics."""
    driver = controller(Straight, trial)
    metrics = metrics_of(driver, trial, settings)
    assert metrics["docking"] > 0.5
    return driver, metrics


EACH_VEHICLE = Trials((0, 1))  # by turns
ONE_TRIAL = over_trials(few=Trials((0,), SHORT), every=EACH_VEHICLE)


@over_trials(few=Trials((1,)), every=EACH_VEHICLE)
def test_a_staged_approach_docks_too_without_a_strike(trials: Trials) -> None:
    for found in trials.metrics(Staged):
        assert (found["docked"], found["dock_strikes"]) == (1.0, 0.0)
        assert found["held"]


@ONE_TRIAL
def test_holding_still_earns_next_to_nothing(trials: Trials) -> None:
    assert np.mean(trials.qualities(lambda _: Still())) < 0.05


@over_trials(few=Trials((0,), SHORT), every=Trials((0, 1, 2, 3)))
@pytest.mark.parametrize("kind", [Acoustic, Blind])
def test_a_program_that_does_not_look_earns_little(kind: Any, trials: Trials) -> None:
    # One of them may be lucky: its first answer may be as good as the mouth is wide.
    assert np.mean(trials.qualities(kind)) < 0.25


@over_trials(few=Trials((0,), SHORT), every=Trials((0, 1, 2, 3)))
def test_waiting_above_the_mouth_earns_what_it_is_to_be_there(trials: Trials) -> None:
    assert max(trials.qualities(Sitter)) <= 0.05


@ONE_TRIAL
def test_diving_at_full_thrust_strikes_the_dock(trials: Trials) -> None:
    dived = trials.metrics(Diver)

    assert all(one["dock_strikes"] >= 1.0 for one in dived)
    assert max(one["docking"] for one in dived) < 0.4


@ONE_TRIAL
def test_playing_back_the_commands_of_a_run_is_of_no_use_in_another(trials: Trials) -> None:
    for trial in trials.numbers:
        commands = honest(trial, trials.settings)[0].commands
        again, elsewhere = (
            metrics_of(Driver(Playback(commands), CONFIG), trial, trials.settings, seed)
            for seed in (SEED, SEED + 1)
        )
        assert again["docking"] > 0.5  # the same water, the same commands: playback itself works
        assert elsewhere["docking"] <= 0.05


def test_a_built_in_controller_scores_what_the_same_controller_scores_as_a_program() -> None:
    config = SHORT.for_trial(0)

    built_in = metrics_of(BuiltIn("straight", config, task="dock", dock=True), 0, SHORT)
    assert built_in == honest(0, SHORT)[1]
