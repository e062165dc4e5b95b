"""Programs that do not navigate and follow stay at the bottom of track-v1."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pytest

from seamark.sim.benchmarks.track_v1.experiment import EXPERIMENT
from seamark.sim.benchmarks.track_v1.settings import TrackConfiguration
from seamark.sim.control.observation import PIPE, ROUTE_POINTS, Observation
from seamark.sim.control.track.guidance import Blind, LineOfSight
from seamark.sim.engine.program import BuiltIn, Command
from tests.sim.benchmarks.attempts import Driver, Playback, rows_of

pytestmark = pytest.mark.slow
CONFIG = TrackConfiguration.read({"levels": [0.2]})
SEED, TRIALS = 90, 6  # one of each vehicle and kind of route that is told
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


def on_average(kind: Any) -> float:
    return float(np.mean([followed(controller(kind, t), t) for t in range(TRIALS)]))


HONEST = 0.55  # what line of sight reaches at least on average


@pytest.fixture(scope="module")
def followers() -> list[tuple[Driver, float]]:
    """What line of sight follows, and the commands that did it."""
    drivers = [controller(LineOfSight, trial) for trial in range(TRIALS)]
    return [(driver, followed(driver, trial)) for trial, driver in enumerate(drivers)]


@pytest.fixture(scope="module")
def honest(followers: list[tuple[Driver, float]]) -> float:
    return float(np.mean([share for _, share in followers]))


def test_a_program_that_navigates_by_fixes_follows_most_of_its_routes(honest: float) -> None:
    assert honest > HONEST


def test_dead_reckoning_alone_stays_far_behind(honest: float) -> None:
    assert on_average(Blind) < 0.6 * honest


def test_going_straight_to_the_end_earns_little(honest: float) -> None:
    assert on_average(Shortcut) < 0.4 * honest


def test_letting_the_water_carry_it_earns_next_to_nothing() -> None:
    drifted = [followed(Driver(Drifter(), CONFIG), trial) for trial in range(TRIALS)]

    assert np.mean(drifted) < 0.1


def test_playing_back_the_commands_of_a_run_is_of_no_use_in_another(
    followers: list[tuple[Driver, float]], honest: float
) -> None:
    seen, again, elsewhere = [], [], []
    for trial, (driver, share) in enumerate(followers):
        seen.append(share)
        playback = Playback(driver.commands)
        again.append(followed(Driver(playback, CONFIG), trial))
        elsewhere.append(followed(Driver(playback, CONFIG), trial, seed=SEED + 1))

    assert again == seen  # the same water, the same commands: the playback itself works
    assert np.mean(elsewhere) < 0.2 * honest


@pytest.fixture(scope="module")
def watchers() -> list[tuple[Driver, float]]:
    """What line of sight by camera follows of pipes, and the commands that did it."""
    drivers = [controller(LineOfSight, trial, PIPES) for trial in range(3)]
    return [(driver, followed(driver, t, settings=PIPES)) for t, driver in enumerate(drivers)]


@pytest.fixture(scope="module")
def seen(watchers: list[tuple[Driver, float]]) -> list[float]:
    return [share for _, share in watchers]


def test_a_program_that_sees_the_pipe_follows_most_of_it(seen: list[float]) -> None:
    assert np.mean(seen) > 0.5


@pytest.mark.parametrize("kind", [Blind, Shortcut])
def test_a_pipe_is_not_where_it_would_be_if_it_went_straight_on(
    kind: Any, seen: list[float]
) -> None:
    """Both go along the told line: one by the points of the route, one straight to its end."""
    straight = [followed(controller(kind, t, PIPES), t, settings=PIPES) for t in range(3)]

    assert np.mean(straight) < 0.4 * np.mean(seen)


def test_the_fixes_do_not_tell_where_a_pipe_goes(seen: list[float]) -> None:
    class Unseeing(LineOfSight):
        sees = False

    exact = PIPES.model_copy(update={"fix_angle_sigma_rad": 0.0, "fix_range_sigma_m": 0.0})
    told = [followed(controller(Unseeing, t, exact), t, settings=exact) for t in range(3)]

    assert np.mean(told) < 0.4 * np.mean(seen)


def test_playing_back_the_commands_along_one_pipe_is_of_no_use_on_another(
    watchers: list[tuple[Driver, float]], seen: list[float]
) -> None:
    elsewhere = []
    for trial, (driver, share) in enumerate(watchers):
        playback = Playback(driver.commands)
        assert followed(Driver(playback, PIPES), trial, settings=PIPES) == share
        elsewhere.append(followed(Driver(playback, PIPES), trial, SEED + 1, PIPES))

    assert np.mean(elsewhere) < 0.3 * np.mean(seen)


def test_a_built_in_controller_scores_what_the_same_controller_scores_as_a_program(
    followers: list[tuple[Driver, float]],
) -> None:
    config = CONFIG.for_trial(0)

    assert followed(BuiltIn("los", config, task="track", route=True), 0) == followers[0][1]
