"""Programs that do not turn the valve with a hand stay at the bottom of valve-v1."""

from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from seamark.sim.benchmarks.valve_v1.experiment import EXPERIMENT
from seamark.sim.benchmarks.valve_v1.settings import ValveConfiguration
from seamark.sim.control.manipulation.approach import Approach, clipped
from seamark.sim.control.manipulation.arm_data import Vector
from seamark.sim.control.manipulation.kinematics import plus
from seamark.sim.control.manipulation.valve import TURN, Blind, Scripted
from seamark.sim.control.observation import Observation
from seamark.sim.metrics.attempts import STRIKE_N
from seamark.sim.metrics.valve_turning import GOALS_DEG, STAGES
from seamark.sim.numerics.libm import sincos
from seamark.sim.recording.telemetry import INDEX, WORK_INDEX
from tests.sim.benchmarks import attempts
from tests.sim.benchmarks.attempts import Driver, Playback, Still, over_trials

pytestmark = pytest.mark.slow
# The weakest valve there is, which turns most easily.
CONFIG = ValveConfiguration.read(
    {"levels": [0.1], "level_duration_s": 45.0, "torque_most_n_m": 2.0, "tracker": "truth"}
)
SEED = 2026
TOUCHED = STAGES[1].credit
EVERY = (0, 2, 3)
Trials = tuple[int, ...]


class HullSpinner(Scripted):
    """Lands on the handle with the hull and turns about itself."""

    def step(self, observation: Observation) -> Sequence[float]:
        command = list(super().step(observation))
        if observation.t > 8.0:
            ahead, side, _ = self._grip(observation, self.attitude[2])
            command[:4] = [clipped(0.7 * ahead, 0.3), clipped(0.7 * side, 0.3), 0.0, 0.3]
            if abs(ahead) < 0.1 and abs(side) < 0.1:
                command[2] = 0.15
        return command

    def _advance(self, *arguments: Any) -> None:
        self.falling = 0.0


class Dropper(Scripted):
    """Comes over the handle and lets the vehicle fall on it."""

    def step(self, observation: Observation) -> Sequence[float]:
        command = list(super().step(observation))
        if observation.t > 12.0:
            command[2] = 1.0
        return command

    def _advance(self, *arguments: Any) -> None:
        self.falling = 0.0


class Flicker(Scripted):
    """Brings the closed hand beside the end of the lever and flicks it aside."""

    def step(self, observation: Observation) -> Sequence[float]:
        command = list(super().step(observation))
        if self.phase == TURN and self.since_s > 2.0:
            (sine, cosine), speed = sincos(self.handle - self.attitude[2]), 0.4
            command[:2] = [-speed * sine, speed * cosine]
        return command

    def _grip(self, observation: Observation, yaw: float) -> Vector:
        grip = super()._grip(observation, yaw)
        sine, cosine = sincos(self.handle - yaw)
        along, across = 0.04, -0.07
        beside = (along * cosine - across * sine, along * sine + across * cosine, 0.0)
        return plus(grip, beside)

    def _fall(self, off: float, above: float) -> None:
        Approach._fall(self, off, above)  # its closed jaws touch each other

    def _work(self, *arguments: Any) -> None:
        self.falling = 0.0

    def _jaw_speed(self, joints: list[float]) -> float:
        return -self.kinematics.fastest[self.jaw]


class ByDvl(Scripted):
    """Goes to where the handle is on average and turns the wrist; it reads no image."""

    def _look(self, observation: Observation, tilt: Any, yaw: float) -> None:
        if self.work is None:
            x, y, _ = self.camera.mount_m
            sine, cosine = sincos(yaw)
            depth = float(observation.depth) + 1.6 - self.HANDLE_M
            self.work = (cosine * x - sine * y, sine * x + cosine * y, depth)
            self.handle = yaw + 0.5 * np.pi


def rows_of(driver: Driver, trial: int = 0, *, seed: int = SEED) -> NDArray[np.float64]:
    """Return the rows of a level."""
    return attempts.rows_of(EXPERIMENT, CONFIG, driver, seed=seed, trial=trial)


@cache  # several tests compare with the same
def attempt_of(kind: Callable[[Any], Any], trial: int) -> tuple[Driver, NDArray[np.float64]]:
    """Return who drove a level, and the rows of it."""
    driver = Driver(kind(CONFIG.for_program()), CONFIG)
    return driver, rows_of(driver, trial)


def attempts_of(kind: Callable[[Any], Any], trials: Trials) -> list[NDArray[np.float64]]:
    """Return the rows of a level of each trial."""
    return [attempt_of(kind, trial)[1] for trial in trials]


def credit(rows: NDArray[np.float64]) -> float:
    return float(EXPERIMENT.metrics(CONFIG, 0, rows)["credit"])


def turned_deg(rows: NDArray[np.float64]) -> float:
    """Return how far the handle was turned, by whatever."""
    return float(np.degrees(rows[:, WORK_INDEX["workpiece_joint"]].max()))


@over_trials(few=(0,), every=EVERY)
def test_turns_by_the_hull_do_not_count(trials: Trials) -> None:
    tries = attempts_of(HullSpinner, trials)
    hull = [rows[:, WORK_INDEX["work_hull_n"]].max() for rows in tries]

    assert max(hull) > 0.0
    assert max(map(turned_deg, tries)) > GOALS_DEG[-1]
    assert max(map(credit, tries)) <= TOUCHED


@over_trials(few=(2,), every=EVERY)
def test_a_vehicle_that_is_dropped_on_the_handle_turns_it_for_nothing(trials: Trials) -> None:
    tries = attempts_of(Dropper, trials)
    pushes = [rows[:, WORK_INDEX["work_push_n"]].max() for rows in tries]

    assert min(pushes) > STRIKE_N
    assert max(map(turned_deg, tries)) > GOALS_DEG[0]
    assert max(map(credit, tries)) <= TOUCHED


@over_trials(few=(0,), every=EVERY)
def test_a_lever_that_is_flicked_aside_gives_no_more_than_a_touch(trials: Trials) -> None:
    tries = attempts_of(Flicker, trials)

    assert min(map(turned_deg, tries)) > GOALS_DEG[0]
    assert max(map(credit, tries)) <= TOUCHED


@over_trials(few=(0,), every=EVERY)
def test_who_flies_by_the_dvl_alone_does_not_find_the_handle(trials: Trials) -> None:
    assert max(map(credit, attempts_of(ByDvl, trials))) <= TOUCHED


def test_holding_still_gives_nothing() -> None:
    rows = rows_of(Driver(Still(), CONFIG))

    assert credit(rows) == 0.0
    assert rows[:, INDEX["contact_n"]].max() == 0.0


@over_trials(few=(0,), every=EVERY)
def test_commands_that_turned_the_valve_once_turn_it_again_but_no_other(trials: Trials) -> None:
    honest, rows = attempt_of(Scripted, 0)

    def again(trial: int, seed: int = SEED) -> float:
        return credit(rows_of(Driver(Playback(honest.commands), CONFIG), trial, seed=seed))

    assert credit(rows) == STAGES[-1].credit
    assert again(0) == STAGES[-1].credit
    assert max(again(trial, SEED + 1) for trial in trials) <= TOUCHED


@over_trials(few=(0,), every=EVERY)
def test_who_stops_looking_turns_less_than_who_looks_on(trials: Trials) -> None:
    blind, seeing = (sum(map(credit, attempts_of(entry, trials))) for entry in (Blind, Scripted))

    assert blind < 0.5 * seeing
