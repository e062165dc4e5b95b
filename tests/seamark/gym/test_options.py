"""What policies need: float32, actions from -1 to 1, a warning, and Stable-Baselines3's form."""

import subprocess
import sys
import warnings
from typing import Any

import gymnasium
import numpy as np
import pytest

import seamark.gym  # noqa: F401  # registers the environments
from seamark.gym.stable_baselines import SeamarkVecEnv

NAME = "seamark/StationKeeping-v3"
TRUTH = {"tracker": "truth", "levels": [0.1], "level_duration_s": 2.0, "settle_s": 0.5}
NORMALISED: dict[str, Any] = {"dtype": "float32", "normalise_actions": True}


@pytest.mark.parametrize("many", [False, True])
def test_a_normalised_action_in_float32_is_a_share_of_the_limit(many: bool) -> None:
    make = gymnasium.make_vec if many else gymnasium.make
    options: dict[str, Any] = {"num_envs": 2} if many else {}
    plain: Any = make(NAME, settings=TRUTH, **options)
    ours: Any = make(NAME, settings=TRUTH, **options, **NORMALISED)
    first, _ = plain.reset(seed=7)
    begin, _ = ours.reset(seed=7)
    share = np.full(ours.action_space.shape, 0.25, np.float32)

    mine = ours.step(share)
    reference = plain.step(0.25 * plain.action_space.high)

    assert ours.observation_space.contains(begin)
    assert ours.observation_space.dtype == ours.action_space.dtype == mine[0].dtype == np.float32
    assert (ours.action_space.high == 1.0).all()
    np.testing.assert_array_equal(begin, first.astype(np.float32))
    np.testing.assert_array_equal(mine[0], reference[0].astype(np.float32))
    np.testing.assert_array_equal(mine[1], reference[1])


@pytest.mark.parametrize("options", [{}, NORMALISED])
@pytest.mark.parametrize("action", ["velocity", "thrusters"])
def test_an_action_that_the_vehicle_saturates_is_warned_of_once(
    options: dict[str, Any], action: str
) -> None:
    env = gymnasium.make(NAME, settings=TRUTH, action=action, disable_env_checker=True, **options)
    env.reset(seed=7)
    highest = env.action_space.high  # type: ignore[attr-defined]
    env.step(highest)

    with pytest.warns(UserWarning, match="saturates it") as found:
        env.step(1.01 * highest)
    env.step(2.0 * highest)

    assert len(found) == 1


def test_numbers_of_another_type_are_refused() -> None:
    with pytest.raises(ValueError, match="float32 or float64, not float16"):
        gymnasium.make(NAME, dtype="float16")


def test_the_form_for_stable_baselines_steps_as_the_vector_environment() -> None:
    ours = SeamarkVecEnv(NAME, num_envs=3, settings=TRUTH, seed=7)
    theirs: Any = gymnasium.make_vec(
        NAME, num_envs=3, settings=TRUTH, autoreset_mode="SameStep", **NORMALISED
    )
    np.testing.assert_array_equal(ours.reset(), theirs.reset(seed=7)[0])
    random, ended = np.random.default_rng(1), 0
    for _ in range(50):  # over the end of a level
        actions = random.uniform(-1.0, 1.0, (3, 4)).astype(np.float32)
        observations, rewards, over, infos = ours.step(actions)
        expected = theirs.step(actions)

        np.testing.assert_array_equal(observations, expected[0])
        np.testing.assert_array_equal(rewards, expected[1].astype(np.float32))
        np.testing.assert_array_equal(over, expected[2] | expected[3])
        for i in np.flatnonzero(over):
            np.testing.assert_array_equal(
                infos[i]["terminal_observation"], expected[4]["final_obs"][i]
            )
            assert infos[i]["TimeLimit.truncated"]
            ended += 1
    assert ended == 3
    assert observations.dtype == rewards.dtype == np.float32
    ours.close()


def test_each_vehicle_for_stable_baselines_begins_where_its_options_say() -> None:
    ours = SeamarkVecEnv(NAME, num_envs=3, settings=TRUTH, seed=7)
    ours.set_options([{"trial": 1}, {}, {"trial": 1}])
    first, second = ours.reset(), ours.reset()

    theirs: Any = gymnasium.make_vec(NAME, num_envs=3, settings=TRUTH, dtype=np.float32)
    as_usual, _ = theirs.reset(seed=7)
    elsewhere, _ = theirs.reset(options={"trial": 1})
    np.testing.assert_array_equal(first[[0, 2]], elsewhere[[0, 2]])
    np.testing.assert_array_equal(first[1], as_usual[1])
    after, _ = theirs.reset()  # options are of one reset: the next one goes on in their trial
    np.testing.assert_array_equal(second[[0, 2]], after[[0, 2]])
    ours.close()
    theirs.close()


def test_seeds_and_indices_are_those_of_a_vec_env() -> None:
    env = SeamarkVecEnv(NAME, num_envs=3, settings=TRUTH)

    assert env.seed(5) == [5, 6, 7]
    first = env.reset()
    assert not np.array_equal(first, env.reset())  # the next level
    env.seed(5)
    np.testing.assert_array_equal(first, env.reset())
    assert env.get_attr("render_mode") == [None] * 3
    assert env.env_is_wrapped(gymnasium.Wrapper, indices=[0, 2]) == [False, False]
    for call in (lambda: env.set_attr("x", 1), lambda: env.env_method("x")):
        with pytest.raises(NotImplementedError, match="rows of arrays"):
            call()


@pytest.mark.slow
def test_importing_the_form_for_stable_baselines_needs_it_not() -> None:
    code = (
        "import sys; sys.modules['stable_baselines3'] = None; sys.modules['torch'] = None; "
        "from seamark.gym.stable_baselines import SeamarkVecEnv"
    )

    subprocess.run([sys.executable, "-c", code], check=True)


def test_actions_within_the_space_are_not_warned_of() -> None:
    env: Any = gymnasium.make_vec(NAME, num_envs=2, settings=TRUTH, **NORMALISED)
    env.reset(seed=7)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        env.step(env.action_space.high)
