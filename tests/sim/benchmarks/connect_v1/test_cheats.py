"""Programs that do not plug the connector with a hand stay at the bottom of connect-v1."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from seamark.sim.benchmarks.connect_v1.experiment import EXPERIMENT
from seamark.sim.benchmarks.connect_v1.settings import ConnectConfiguration
from seamark.sim.control.manipulation.arm_data import Vector
from seamark.sim.control.manipulation.connector import (
    INSERT,
    LEAVE,
    LOWER,
    OPEN,
    OPEN_S,
    Blind,
    Scripted,
)
from seamark.sim.control.observation import Observation
from seamark.sim.metrics.connection import STAGES, Connection
from seamark.sim.recording.telemetry import INDEX, WORK_INDEX
from tests.sim.benchmarks import attempts
from tests.sim.benchmarks.attempts import Driver, Playback, Still, over_trials

pytestmark = pytest.mark.slow
# The widest hole there is.
CONFIG = ConnectConfiguration.read(
    {"levels": [0.1], "clearance_least_m": 0.008, "tracker": "truth"}
)
SHORT = CONFIG.model_copy(update={"level_duration_s": 40.0})  # by then it has entered
SEED = 2026
CREDIT = {stage.name: stage.credit for stage in STAGES}
WEIGHT_N = 12.0  # of most connectors in water: a cheat that does less was no try


class Bulldozer(Scripted):
    """Comes down beside the connector and drives through it, jaws first."""

    def step(self, observation: Observation) -> Sequence[float]:
        command = list(super().step(observation))
        self.offset = -0.03
        if observation.t > 20.0:
            command[0] = 0.4
        return command

    def _grip(self, observation: Observation, yaw: float) -> Vector:
        ahead, side, down = super()._grip(observation, yaw)
        return ahead - 0.3, side, down

    def _advance(self, *arguments: Any) -> None:
        self.falling = 0.0


class Dropper(Scripted):
    """Comes over the connector and lets the vehicle fall on it."""

    def step(self, observation: Observation) -> Sequence[float]:
        command = list(super().step(observation))
        if observation.t > 15.0:
            command[2] = 1.0
        return command

    def _advance(self, *arguments: Any) -> None:
        self.falling = 0.0


class Presser(Scripted):
    """Presses the closed hand on the parked connector."""

    BOTTOM_M = -0.3

    def _jaw_speed(self, joints: list[float]) -> float:
        return -self.kinematics.fastest[self.jaw]


class Thrower(Scripted):
    """Takes the connector and drops it from above the receptacle."""

    def _lower(self, off: float) -> None:
        if self.height < 0.15:
            self._let_go()
        else:
            super()._lower(off)


class DropAndPress(Scripted):
    """Lets go of the connector at the mouth and presses it down with the closed hand."""

    def _insert(self, error: Vector) -> None:
        if self.height < 0.0:
            self._let_go()
        else:
            super()._insert(error)

    def _leave(self) -> None:
        if self.phase == OPEN and self.since_s > OPEN_S:
            self.offset = self.height
            self._go(LEAVE)
        elif self.phase == LEAVE and self.since_s < 4.0:
            self._rise(0.12)
        elif self.phase == LEAVE and self.offset > -0.25:
            self._sink(0.05)

    def _jaw_speed(self, joints: list[float]) -> float:
        if self.phase == LEAVE and self.since_s > 2.0:
            return -self.kinematics.fastest[self.jaw]
        return super()._jaw_speed(joints)


class ByDvl(Scripted):
    """Goes to where the panel is on average; it reads no image."""

    def _look(self, observation: Observation, tilt: Any, yaw: float) -> None:
        if self.work is None:
            x, y, _ = self.camera.mount_m
            sine, cosine = np.sin(yaw), np.cos(yaw)
            depth = float(observation.depth) + 1.6 - self.HANDLE_M
            self.work = (cosine * x - sine * y, sine * x + cosine * y, depth)
            self.handle = yaw + 0.5 * np.pi + self.HANDLE_RAD


class Watched(Scripted):
    """The scripted entry; it keeps what it does."""

    def reset(self, level: Any) -> None:
        self.seen: set[int] = set()
        super().reset(level)

    def _go(self, phase: int) -> None:
        self.seen.add(phase)
        super()._go(phase)


@dataclass(frozen=True)
class Attempt:
    """A program's level: itself, its commands, and the rows that it left."""

    program: Any
    driver: Driver
    rows: NDArray[np.float64]


def rows_of(
    driver: Driver, trial: int, settings: ConnectConfiguration, *, seed: int = SEED
) -> NDArray[np.float64]:
    """Return the rows of a level."""
    return attempts.rows_of(EXPERIMENT, settings, driver, seed=seed, trial=trial)


@cache  # several tests compare with the same
def attempt_of(
    kind: Callable[[Any], Any], trial: int, settings: ConnectConfiguration = CONFIG
) -> Attempt:
    program = kind(settings.for_program())
    driver = Driver(program, settings)
    return Attempt(program, driver, rows_of(driver, trial, settings))


def played_back(of: Attempt, trial: int, *, seed: int = SEED) -> float:
    """Return the credit of the same commands at another time."""
    return credit(rows_of(Driver(Playback(of.driver.commands), CONFIG), trial, CONFIG, seed=seed))


def credit(rows: NDArray[np.float64]) -> float:
    return float(EXPERIMENT.metrics(CONFIG, 0, rows)["credit"])


def most(rows: NDArray[np.float64], name: str) -> float:
    return float(rows[:, {**INDEX, **WORK_INDEX}[name]].max())


@dataclass(frozen=True)
class Trials:
    """Some trials, of some settings."""

    numbers: tuple[int, ...]
    settings: ConnectConfiguration = CONFIG

    def rows(self, kind: Callable[[Any], Any]) -> list[NDArray[np.float64]]:
        """Return the rows of a level of each trial."""
        return [attempt_of(kind, trial, self.settings).rows for trial in self.numbers]


ONE_TRIAL = over_trials(few=Trials((0,)), every=Trials((0, 1, 2)))
SHORT_TRIAL = over_trials(few=Trials((0,), SHORT), every=Trials((0, 1, 2)))


@SHORT_TRIAL
def test_a_connector_that_is_bulldozed_gives_no_more_than_a_touch(trials: Trials) -> None:
    tries = trials.rows(Bulldozer)

    assert max(most(rows, "work_push_n") for rows in tries) > WEIGHT_N
    assert max(map(credit, tries)) <= CREDIT["touched"]


@SHORT_TRIAL
def test_a_vehicle_that_is_dropped_on_the_connector_gives_no_more_than_a_touch(
    trials: Trials,
) -> None:
    tries = trials.rows(Dropper)

    assert min(Connection(rows, CONFIG.control_period_s).strikes for rows in tries) > 0
    assert max(map(credit, tries)) <= CREDIT["touched"]


@ONE_TRIAL
def test_a_closed_hand_that_presses_on_it_gives_no_more_than_a_touch(trials: Trials) -> None:
    tries = trials.rows(Presser)

    assert max(most(rows, "work_push_n") for rows in tries) > WEIGHT_N
    assert max(map(credit, tries)) <= CREDIT["touched"]


@SHORT_TRIAL
def test_one_that_is_dropped_from_above_the_receptacle_was_taken_and_no_more(
    trials: Trials,
) -> None:
    tries = trials.rows(Thrower)
    fallen = [Connection(rows, CONFIG.control_period_s) for rows in tries]

    assert max(map(credit, tries)) == CREDIT["unparked"]
    assert max(float(one.depth_m[-1]) for one in fallen) > -0.05
    # A jaw may touch it on its way, within the half second over which two sides are judged.
    assert max(float(one.inserted_m.max()) for one in fallen) < 0.001


@ONE_TRIAL
def test_one_that_is_let_go_at_the_mouth_and_pressed_down_was_not_inserted(trials: Trials) -> None:
    tries = trials.rows(DropAndPress)
    pressed = [Connection(rows, CONFIG.control_period_s) for rows in tries]

    assert max(float(one.depth_m.max()) for one in pressed) > 0.05
    assert max(map(credit, tries)) == CREDIT["entered"]


@SHORT_TRIAL
def test_who_flies_by_the_dvl_alone_does_not_take_the_connector(trials: Trials) -> None:
    assert max(map(credit, trials.rows(ByDvl))) <= CREDIT["touched"]


def test_holding_still_gives_nothing() -> None:
    rows = rows_of(Driver(Still(), SHORT), 0, SHORT)

    assert credit(rows) == 0.0
    assert most(rows, "contact_n") == 0.0


@ONE_TRIAL
def test_commands_that_plugged_a_connector_once_plug_it_again_but_no_other(trials: Trials) -> None:
    honest = attempt_of(Watched, 0)
    assert credit(honest.rows) == CREDIT["completed"]
    assert played_back(honest, 0) == CREDIT["completed"]

    fresh = sorted(played_back(honest, trial, seed=SEED + 1) for trial in trials.numbers)

    assert fresh[len(fresh) // 2] <= CREDIT["touched"]
    assert fresh[-1] <= CREDIT["unparked"]


@over_trials(few=Trials((0,)), every=Trials(tuple(range(6))))
def test_who_stops_looking_plugs_less_than_who_looks_on(trials: Trials) -> None:
    blind, seeing = (sum(map(credit, trials.rows(entry))) for entry in (Blind, Watched))

    assert blind < 0.5 * seeing


def test_the_scripted_entry_goes_through_all_its_steps() -> None:
    assert {LOWER, INSERT, OPEN, LEAVE} <= attempt_of(Watched, 0).program.seen
