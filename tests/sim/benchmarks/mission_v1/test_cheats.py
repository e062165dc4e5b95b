"""Programs that do not search, recognise and carry stay at the bottom of mission-v1."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from seamark.sim.benchmarks.mission_v1.experiment import EXPERIMENT
from seamark.sim.benchmarks.mission_v1.settings import MissionConfiguration
from seamark.sim.control.manipulation.mission import SEARCH, Chain, Lawnmower
from seamark.sim.control.manipulation.recover import LIFT
from seamark.sim.control.observation import Observation
from seamark.sim.metrics.mission import STAGES, WRONG
from tests.sim.benchmarks.attempts import Driver, Playback

pytestmark = pytest.mark.slow
CONFIG = MissionConfiguration.read({"levels": [0.1], "loop1_values": [0.5]})
SEED = 2026
RECOGNISED = STAGES[1].credit


class Stay(Chain):
    """Goes to the place told, and waits for ever."""

    def _search(self, seen: Any) -> None:
        self.at = 0


class Greedy(Chain):
    """Takes the first box, whatever its letters say."""

    def _judge(self, confidence: float) -> None:
        super()._judge(1.0)


class Contrary(Chain):
    """Takes the box that is surely not the right one."""

    def _judge(self, confidence: float) -> None:
        super()._judge(1.0 - confidence)


class Thrower(Chain):
    """Lifts the box, then lets go of it on its way home."""

    def step(self, observation: Observation) -> Sequence[float]:  # type: ignore[override]
        command = list(super().step(observation))
        if self.phase > LIFT:
            command[-1] = self.kinematics.fastest[self.jaw]
        return command


def metrics(program: Any, trial: int, **settings: object) -> dict[str, Any]:
    rows: list[NDArray[np.float64]] = []
    config = CONFIG.model_copy(update=settings)
    EXPERIMENT.level(config, program, seed=SEED, trial=trial, level=0).run(rows.append)
    return EXPERIMENT.metrics(config, 0, np.concatenate(rows))


def of(controller: type[Any], trial: int, **settings: object) -> dict[str, Any]:
    return metrics(Driver(controller(CONFIG.for_program()), CONFIG), trial, **settings)


def test_the_chain_brings_the_right_box_in_most_trials() -> None:
    done = [of(Chain, trial) for trial in range(5)]

    assert sum(one["completed"] for one in done) >= 4
    assert not any(one["wrong"] for one in done)


def test_who_only_goes_where_it_is_told_gets_no_more_than_a_hold() -> None:
    assert max(of(Stay, trial)["credit"] for trial in range(4)) <= RECOGNISED


def test_a_lawnmower_finds_the_box_and_no_more() -> None:
    assert max(of(Lawnmower, trial)["credit"] for trial in range(4)) <= RECOGNISED


def test_who_does_not_read_takes_the_wrong_box_now_and_then_and_pays_for_it() -> None:
    greedy = [of(Greedy, trial, detector="outline") for trial in range(6)]

    wrong = [one for one in greedy if one["wrong"]]
    assert wrong
    assert all(one["credit"] <= STAGES[-1].credit - WRONG for one in wrong)


def test_who_takes_the_wrong_box_on_purpose_has_less_than_nothing() -> None:
    contrary = [of(Contrary, trial, least_confidence=0.0) for trial in range(4)]

    assert any(one["wrong"] for one in contrary)
    assert np.mean([one["credit"] for one in contrary]) < RECOGNISED


def test_a_box_that_is_let_go_on_the_way_is_not_brought() -> None:
    thrown = [of(Thrower, trial) for trial in range(3)]

    assert max(one["taken"] for one in thrown) == 1.0
    assert not any(one["completed"] for one in thrown)


def test_commands_that_did_a_mission_once_do_no_other() -> None:
    honest = Driver(Chain(CONFIG.for_program()), CONFIG)
    assert metrics(honest, 0)["completed"]

    others = [metrics(Playback(honest.commands), trial)["credit"] for trial in (1, 2, 3)]

    assert max(others) <= RECOGNISED


def test_the_search_begins_anew_in_each_level() -> None:
    chain = Chain(CONFIG.for_program())
    level = {"t": 0.0, "dt": 0.05, "index": 0, "count": 1, "duration_s": 120.0}
    chain.reset(level)
    chain.wrong.append((1.0, 2.0))
    chain.at = 5
    chain.phase = LIFT

    chain.reset(level)

    assert (chain.phase, chain.at, chain.wrong) == (SEARCH, 0, [])
