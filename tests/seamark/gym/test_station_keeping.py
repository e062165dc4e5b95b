"""The single environment of station keeping."""

import warnings
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from seamark.gym import BENCHMARKS
from seamark.gym.spaces import named
from seamark.sim import registry
from seamark.sim.control.position.pi import Controller
from seamark.sim.engine.reward import DISTANCE, TOOL, Goal, reward_of
from seamark.sim.engine.trial import run_trial
from seamark.sim.metrics.station_keeping import SCORE_LENGTH_M
from seamark.sim.metrics.windows import LOST_PX
from seamark.sim.recording.telemetry import INDEX, STEP_US, WIDTH

STATION_KEEPING = [name for name in BENCHMARKS if "StationKeeping" in name]
SHORT = {"levels": [0.1, 0.3], "level_duration_s": 4.0, "settle_s": 1.0}
Env = gymnasium.Env[Any, Any]


def env_of(name: str, **options: Any) -> Env:
    with warnings.catch_warnings():  # of the first versions: that there are second ones
        warnings.simplefilter("ignore", DeprecationWarning)
        return gymnasium.make(name, **options).unwrapped


@pytest.mark.parametrize("name", STATION_KEEPING)
@pytest.mark.parametrize("action", ["velocity", "thrusters"])
def test_the_environment_passes_gymnasiums_checker(name: str, action: str) -> None:
    env = env_of(name, settings=SHORT, action=action, render_mode="rgb_array")

    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message=".*infinity")  # a position has no bound
        warnings.filterwarnings("ignore", message=".*symmetric and normalized")  # SI units
        check_env(env)


@pytest.mark.parametrize("name", STATION_KEEPING)
def test_the_episodes_of_a_seed_are_the_run_with_that_seed(name: str) -> None:
    entry = registry.benchmark(BENCHMARKS[name])
    config: Any = entry.read(SHORT)
    rows: list[Any] = []
    for trial in range(2):
        solution = entry.load().built_in("pi", config)
        run_trial(entry.name, config, solution, seed=5, trial=trial, on_rows=rows.append)
    expected = {(row[0], row[2]): row for part in rows for row in part}
    env = env_of(name, settings=SHORT)
    compared = 0

    for episode in range(4):
        observation, info = env.reset(seed=None if episode else 5)
        controller = Controller(config.for_trial(info["trial"]).for_program())
        controller.reset({})
        over = False
        while not over:
            row = env.telemetry  # type: ignore[attr-defined]
            reference = expected[row[0], row[2]].copy()
            reference[[STEP_US, *range(INDEX["ref_u"], INDEX["ref_r"] + 1)]] = 0.0
            np.testing.assert_array_equal(row, reference)
            compared += 1
            action = np.array(controller.step(named(observation)))
            observation, _reward, _terminated, over, _info = env.step(action)

    assert compared == len(expected)


def test_a_seed_gives_the_same_water_and_another_seed_another_one() -> None:
    env = env_of("seamark/StationKeeping-v3", settings=SHORT | {"tracker": "truth"})

    _, first = env.reset(seed=3)
    _, other = env.reset(seed=4)
    _, again = env.reset(seed=3)

    np.testing.assert_array_equal(first["current"], again["current"])
    assert (first["current"] != other["current"]).any()


def test_options_choose_trial_and_level() -> None:
    env = env_of("seamark/StationKeeping-v3", settings=SHORT | {"tracker": "truth"})

    _, info = env.reset(seed=3, options={"trial": 7, "level": 1})

    assert (info["trial"], info["level"]) == (7, 1)
    with pytest.raises(ValueError, match="level must be from 0 to 1, not 2"):
        env.reset(options={"level": 2})


def test_an_action_that_is_not_a_number_ends_the_episode() -> None:
    env = env_of("seamark/StationKeeping-v1", settings=SHORT | {"tracker": "truth"})
    env.reset(seed=1)

    _, reward, terminated, truncated, _ = env.step(np.full(4, np.nan))

    assert (reward, terminated, truncated) == (0.0, True, False)


def test_thrusters_move_the_vehicle_as_commanded() -> None:
    settings = SHORT | {"tracker": "truth", "vehicle": "girona500", "levels": [0.0]}
    env = env_of("seamark/StationKeeping-v1", settings=settings, action="thrusters")
    env.reset(seed=1)

    for _ in range(40):
        *_, info = env.step(np.array([1.0, 1.0, 0.0, 0.0, 0.0]))

    assert info["velocity"][0] > 0.3
    assert abs(info["velocity"][1]) < 0.05


def test_the_picture_is_what_the_camera_sees_in_colour() -> None:
    env = env_of("seamark/StationKeeping-v3", settings=SHORT, render_mode="rgb_array")
    env.reset(seed=1)

    before: Any = env.render()
    env.step(np.array([0.0, 0.0, 0.0, 0.5]))
    after: Any = env.render()

    assert before.shape == (480, 640, 3)
    assert before.dtype == np.uint8
    assert (before != after).any()


def test_the_reward_falls_with_the_distance_and_is_zero_while_the_target_is_lost() -> None:
    row, anywhere = np.zeros(WIDTH), np.zeros(3)
    goal = Goal(DISTANCE, anywhere, anywhere, 1.0, 1.0, 5)
    row[INDEX["tracker_ok"]], row[INDEX["distance"]] = 1.0, SCORE_LENGTH_M

    assert reward_of(row, goal) == 0.5
    row[INDEX["tracker_error"]] = LOST_PX + 0.1
    assert reward_of(row, goal) == 0.0


def test_the_tools_reward_is_the_share_of_the_circles_it_is_in_less_the_power() -> None:
    row = np.zeros(WIDTH)
    row[INDEX["tracker_ok"]], row[INDEX["thrust_0"]] = 1.0, 4.0
    goal = Goal(TOOL, np.array([1.0, 0.0, 0.0]), np.array([1.1, 0.0, 0.0]), 4.0, 4.0, 5)

    reward = reward_of(row, goal)

    assert reward == pytest.approx(4 / 8 * (1.0 - 0.1 / 5))  # 0.5, 0.32, 0.2 and 0.125 m
