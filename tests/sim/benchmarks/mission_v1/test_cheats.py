"""Programs that do not search, recognise and carry stay at the bottom of mission-v1."""

from collections.abc import Sequence
from functools import cache
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
SEED = 2026
RECOGNISED = STAGES[1].credit
READS = 3  # a near trial in which the wrong box comes first
WRONG_IS_NEAR = 8  # a near trial in which who looks for the wrong box finds it in time


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


def metrics(config: MissionConfiguration, program: Any, trial: int) -> dict[str, Any]:
    rows: list[NDArray[np.float64]] = []
    EXPERIMENT.level(config, program, seed=SEED, trial=trial, level=0).run(rows.append)
    return EXPERIMENT.metrics(config, 0, np.concatenate(rows))


@cache  # several tests begin with the chain
def attempt_of(
    kind: type[Any], config: MissionConfiguration, trial: int
) -> tuple[Driver, dict[str, Any]]:
    """Return who drove a level, and what came of it."""
    driver = Driver(kind(config.for_program()), config)
    return driver, metrics(config, driver, trial)


class Attempts:
    """Some trials of a mission."""

    def __init__(self, trials: Sequence[int], **settings: object) -> None:
        self.trials, self._settings = trials, settings

    def config(self, **settings: object) -> MissionConfiguration:
        return MissionConfiguration.read(
            {"levels": [0.1], "loop1_values": [0.5]} | self._settings | settings
        )

    def of(self, kind: type[Any], **settings: object) -> list[dict[str, Any]]:
        """Return the metrics of the trials of a program."""
        config = self.config(**settings)
        return [attempt_of(kind, config, trial)[1] for trial in self.trials]


def near(*trials: int, for_s: float = 60.0) -> Attempts:
    """Return trials in which a minute is enough, or 45 s to have lifted the right box."""
    return Attempts(trials, start_offset_m=2.0, told_error_m=0.5, level_duration_s=for_s)


def over(few: Attempts, every: Sequence[int]) -> pytest.MarkDecorator:
    """Give a test `missions`: a few in each run of the suite, and the statistics as a long test."""
    return pytest.mark.parametrize(
        "missions",
        [
            pytest.param(few, id="few"),
            pytest.param(Attempts(every), id="every", marks=pytest.mark.long),
        ],
    )


@over(near(READS), every=range(5))
def test_the_chain_brings_the_right_box_in_most_trials(missions: Attempts) -> None:
    done = missions.of(Chain)

    assert np.mean([one["completed"] for one in done]) >= 0.8
    assert not any(one["wrong"] for one in done)


@over(near(0, for_s=45.0), every=range(4))
def test_who_only_goes_where_it_is_told_gets_no_more_than_a_hold(missions: Attempts) -> None:
    assert max(one["credit"] for one in missions.of(Stay)) <= RECOGNISED


@over(near(0, for_s=45.0), every=range(4))
def test_a_lawnmower_finds_the_box_and_no_more(missions: Attempts) -> None:
    assert max(one["credit"] for one in missions.of(Lawnmower)) <= RECOGNISED


@over(near(READS, for_s=45.0), every=range(6))
def test_who_does_not_read_takes_the_wrong_box_now_and_then_and_pays_for_it(
    missions: Attempts,
) -> None:
    greedy = missions.of(Greedy, detector="outline")

    wrong = [one for one in greedy if one["wrong"]]
    assert wrong
    assert all(one["credit"] <= STAGES[-1].credit - WRONG for one in wrong)


@over(near(WRONG_IS_NEAR), every=range(4))
def test_who_takes_the_wrong_box_on_purpose_has_less_than_nothing(missions: Attempts) -> None:
    contrary = missions.of(Contrary, least_confidence=0.0)

    assert any(one["wrong"] for one in contrary)
    assert np.mean([one["credit"] for one in contrary]) < RECOGNISED


@over(near(0), every=range(3))
def test_a_box_that_is_let_go_on_the_way_is_not_brought(missions: Attempts) -> None:
    thrown = missions.of(Thrower)

    assert max(one["taken"] for one in thrown) == 1.0
    assert not any(one["completed"] for one in thrown)


@over(near(READS, 1), every=range(4))
def test_commands_that_did_a_mission_once_do_no_other(missions: Attempts) -> None:
    config, (first, *fresh) = missions.config(), missions.trials
    honest, done = attempt_of(Chain, config, first)
    assert done["completed"]

    others = [metrics(config, Playback(honest.commands), trial)["credit"] for trial in fresh]

    assert max(others) <= RECOGNISED


def test_the_search_begins_anew_in_each_level() -> None:
    chain = Chain(Attempts([0]).config().for_program())
    level = {"t": 0.0, "dt": 0.05, "index": 0, "count": 1, "duration_s": 120.0}
    chain.reset(level)
    chain.wrong.append((1.0, 2.0))
    chain.at = 5
    chain.phase = LIFT

    chain.reset(level)

    assert (chain.phase, chain.at, chain.wrong) == (SEARCH, 0, [])
