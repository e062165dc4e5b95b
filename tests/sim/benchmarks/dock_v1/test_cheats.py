"""Programs that do not find and enter the dock stay at the bottom of dock-v1."""

from typing import Any

import numpy as np
import pytest

from seamark.sim.benchmarks.dock_v1.experiment import EXPERIMENT
from seamark.sim.benchmarks.dock_v1.settings import DockConfiguration
from seamark.sim.control.dock.entries import HOVER_M, Acoustic, Blind, Staged, Straight
from seamark.sim.engine.program import BuiltIn
from tests.sim.benchmarks.attempts import Driver, Playback, Still, rows_of

pytestmark = pytest.mark.slow
CONFIG = DockConfiguration.read({"levels": [0.2]})
SEED, TRIALS = 91, 2  # one of each vehicle


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


def qualities(kind: Any) -> list[float]:
    return [float(metrics_of(controller(kind, t), t)["docking"]) for t in range(2 * TRIALS)]


@pytest.fixture(scope="module")
def honest() -> list[Driver]:
    """Drivers that docked, with the commands by which they did."""
    drivers = [controller(Straight, trial) for trial in range(TRIALS)]
    for trial, driver in enumerate(drivers):
        assert metrics_of(driver, trial)["docking"] > 0.5
    return drivers


def test_a_staged_approach_docks_too_without_a_strike() -> None:
    for trial in range(TRIALS):
        found = metrics_of(controller(Staged, trial), trial)
        assert (found["docked"], found["dock_strikes"]) == (1.0, 0.0)
        assert found["held"]


def test_holding_still_earns_next_to_nothing() -> None:
    still = [metrics_of(Driver(Still(), CONFIG), trial)["docking"] for trial in range(TRIALS)]

    assert np.mean(still) < 0.05


@pytest.mark.parametrize("kind", [Acoustic, Blind])
def test_a_program_that_does_not_look_earns_little(kind: Any) -> None:
    # One of them may be lucky: its first answer may be as good as the mouth is wide.
    assert np.mean(qualities(kind)) < 0.25


def test_waiting_above_the_mouth_earns_what_it_is_to_be_there() -> None:
    assert max(qualities(Sitter)) <= 0.05


def test_diving_at_full_thrust_strikes_the_dock() -> None:
    dived = [metrics_of(controller(Diver, trial), trial) for trial in range(TRIALS)]

    assert all(one["dock_strikes"] >= 1.0 for one in dived)
    assert max(one["docking"] for one in dived) < 0.4


def test_playing_back_the_commands_of_a_run_is_of_no_use_in_another(
    honest: list[Driver],
) -> None:
    for trial, driver in enumerate(honest):
        again = metrics_of(Driver(Playback(driver.commands), CONFIG), trial)
        elsewhere = metrics_of(Driver(Playback(driver.commands), CONFIG), trial, seed=SEED + 1)
        assert again["docking"] > 0.5  # the same water, the same commands: playback itself works
        assert elsewhere["docking"] <= 0.05


def test_a_built_in_controller_scores_what_the_same_controller_scores_as_a_program(
    honest: list[Driver],
) -> None:
    config = CONFIG.for_trial(1)

    built_in = metrics_of(BuiltIn("straight", config, task="dock", dock=True), 1)
    assert built_in == metrics_of(Driver(Playback(honest[1].commands), CONFIG), 1)
