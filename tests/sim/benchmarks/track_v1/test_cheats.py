"""Programs that do not navigate and follow stay at the bottom of track-v1."""

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

import numpy as np
import pytest

from seamark.sim.benchmarks.track_v1.experiment import EXPERIMENT
from seamark.sim.benchmarks.track_v1.settings import TrackConfiguration
from seamark.sim.control.observation import PIPE, ROUTE_POINTS, Observation
from seamark.sim.control.track.guidance import Blind, LineOfSight
from seamark.sim.engine.program import BuiltIn, Command
from tests.sim.benchmarks.attempts import Driver, Playback, over_trials, rows_of

pytestmark = pytest.mark.slow
CONFIG = TrackConfiguration.read({"levels": [0.2]})
SEED = 90
Trials = tuple[int, ...]
PIPES = TrackConfiguration.read({"levels": [0.2], "route": PIPE, "level_duration_s": 60.0})


class Shortcut(LineOfSight):
    """Goes straight to the end of the told route, with a guide that knows no other point."""

    sees = False

    def step(self, observation: Observation) -> Sequence[float]:
        if self._guide is None:
            super().step(observation)
            route = observation.route.reshape(ROUTE_POINTS, 3)
            self._guide = type(self._guide)(
                np.linspace(route[0], route[-1] + 0.1, ROUTE_POINTS), 1.0, 1.5
            )
        return super().step(observation)


class Drifter:
    """Lets the water carry it."""

    def reset(self, level: Mapping[str, float | int]) -> None:
        pass

    def step(self, observation: Observation) -> Command:
        u, v, w = observation.velocity.tolist()
        return (u, v, w, 0.0)


def followed(program: Any, trial: int, seed: int = SEED, settings: Any = CONFIG) -> float:
    config = settings.for_trial(trial)
    rows = rows_of(EXPERIMENT, config, program, seed=seed, trial=trial)
    share: float = EXPERIMENT.metrics(config, 0, rows)["followed"]
    return share


def controller(kind: Any, trial: int, settings: Any = CONFIG) -> Driver:
    return Driver(kind(settings.for_trial(trial).for_program()), settings)


def on_average(kind: Any, trials: Trials, settings: Any = CONFIG) -> float:
    shares = [followed(controller(kind, t, settings), t, settings=settings) for t in trials]
    return float(np.mean(shares))


@cache  # several tests compare with the same
def follower(trial: int) -> tuple[Driver, float]:
    """Return a driver by line of sight, with its commands, and what it follows of a route."""
    driver = controller(LineOfSight, trial)
    return driver, followed(driver, trial)


def honest(trials: Trials) -> float:
    return float(np.mean([follower(trial)[1] for trial in trials]))


HONEST = 0.55  # what line of sight reaches at least on average
# One of each vehicle and kind of route that is told; each vehicle and each kind.
ROUTES = over_trials(few=(1, 2, 5), every=(0, 1, 2, 3, 4, 5))


@ROUTES
def test_a_program_that_navigates_by_fixes_follows_most_of_its_routes(trials: Trials) -> None:
    assert honest(trials) > HONEST


@ROUTES
def test_dead_reckoning_alone_stays_far_behind(trials: Trials) -> None:
    assert on_average(Blind, trials) < 0.6 * honest(trials)


@ROUTES
def test_going_straight_to_the_end_earns_little(trials: Trials) -> None:
    assert on_average(Shortcut, trials) < 0.4 * honest(trials)


@ROUTES
def test_letting_the_water_carry_it_earns_next_to_nothing(trials: Trials) -> None:
    drifted = [followed(Driver(Drifter(), CONFIG), trial) for trial in trials]

    assert np.mean(drifted) < 0.1


@ROUTES
def test_playing_back_the_commands_of_a_run_is_of_no_use_in_another(trials: Trials) -> None:
    elsewhere = []
    for trial in trials:
        driver, share = follower(trial)
        playback = Playback(driver.commands)
        # The same water, the same commands: the playback itself works.
        assert followed(Driver(playback, CONFIG), trial) == share
        elsewhere.append(followed(Driver(playback, CONFIG), trial, seed=SEED + 1))

    assert np.mean(elsewhere) < 0.2 * honest(trials)


@cache  # several tests compare with the same
def watcher(trial: int) -> tuple[Driver, float]:
    """Return a driver by camera, with its commands, and what it follows of a pipe."""
    driver = controller(LineOfSight, trial, PIPES)
    return driver, followed(driver, trial, settings=PIPES)


def seen(trials: Trials) -> float:
    return float(np.mean([watcher(trial)[1] for trial in trials]))


EACH_PIPE = over_trials(few=(1,), every=(0, 1, 2))


@EACH_PIPE
def test_a_program_that_sees_the_pipe_follows_most_of_it(trials: Trials) -> None:
    assert seen(trials) > 0.5


@EACH_PIPE
@pytest.mark.parametrize("kind", [Blind, Shortcut])
def test_a_pipe_is_not_where_it_would_be_if_it_went_straight_on(kind: Any, trials: Trials) -> None:
    """Both go along the told line: one by the points of the route, one straight to its end."""
    assert on_average(kind, trials, PIPES) < 0.4 * seen(trials)


@EACH_PIPE
def test_the_fixes_do_not_tell_where_a_pipe_goes(trials: Trials) -> None:
    class Unseeing(LineOfSight):
        sees = False

    exact = PIPES.model_copy(update={"fix_angle_sigma_rad": 0.0, "fix_range_sigma_m": 0.0})

    assert on_average(Unseeing, trials, exact) < 0.4 * seen(trials)


@EACH_PIPE
def test_playing_back_the_commands_along_one_pipe_is_of_no_use_on_another(trials: Trials) -> None:
    elsewhere = []
    for trial in trials:
        driver, share = watcher(trial)
        playback = Playback(driver.commands)
        assert followed(Driver(playback, PIPES), trial, settings=PIPES) == share
        elsewhere.append(followed(Driver(playback, PIPES), trial, SEED + 1, PIPES))

    assert np.mean(elsewhere) < 0.3 * seen(trials)


def test_a_built_in_controller_scores_what_the_same_controller_scores_as_a_program() -> None:
    config = CONFIG.for_trial(1)

    assert followed(BuiltIn("los", config, task="track", route=True), 1) == follower(1)[1]
