"""Environments of a vehicle with an arm: actions and observations have its joints."""

from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.spaces import Box

import seamark.gym  # noqa: F401 - registers the environments
from seamark.gym.spaces import named
from seamark.sim.recording.telemetry import ARM_INDEX
from tests.sim.engine.test_arm import SEED, SHORT, Moving, run

COMMAND = (0.1, 0.0, 0.0, 0.0, 0.3, -0.2, 0.0, 0.0, -0.1)
ENVIRONMENT = "seamark/StationKeeping-v3"


def make(**options: Any) -> gymnasium.Env[Any, Any]:
    return gymnasium.make(ENVIRONMENT, settings=SHORT, **options)


def test_an_episode_has_the_rows_of_a_run_with_the_same_commands() -> None:
    rows, kept = run(Moving(COMMAND)), []
    with make() as env:
        env.reset(seed=SEED)
        for _ in range(40):
            kept.append(env.get_wrapper_attr("telemetry"))
            env.step(np.array(COMMAND))

    joints = slice(ARM_INDEX["joint_0"], ARM_INDEX["joint_ref_0"])
    assert np.array(kept)[:, joints].tobytes() == np.ascontiguousarray(rows[:40, joints]).tobytes()
    assert np.array(kept)[:, :30].tobytes() == np.ascontiguousarray(rows[:40, :30]).tobytes()


def test_observations_have_the_arm_by_name_and_actions_its_joints_within_their_limits() -> None:
    with make() as env:
        observation, _ = env.reset(seed=SEED)
        seen = named(observation, arm="alpha-like")

        assert env.observation_space.contains(observation)
        assert len(seen.thrust) == 8
        assert seen.joints == pytest.approx([0.0, 1.0, 2.5, 0.0, 0.3], abs=0.01)
        assert env.action_space.shape == (9,)
        assert isinstance(env.action_space, Box)
        assert env.action_space.high[4:] == pytest.approx(0.5)


def test_a_level_with_an_arm_goes_to_its_end() -> None:
    with make() as env:
        env.reset(seed=SEED)
        over = False
        while not over:
            observation, _reward, terminated, over, _info = env.step(np.zeros(9))

    assert not terminated
    assert named(observation, arm="alpha-like").t == pytest.approx(SHORT["level_duration_s"])


def test_thrusters_and_joints_can_be_commanded_together() -> None:
    with make(action="thrusters", normalise_actions=True) as env:
        env.reset(seed=SEED)
        for _ in range(20):
            observation, *_ = env.step(np.array([0.0] * 8 + [1.0, 0.0, 0.0, 0.0, 0.0]))

        assert env.action_space.shape == (13,)
        assert named(observation, arm="alpha-like").joint_speeds[0] == pytest.approx(0.5, abs=0.03)


def test_a_vehicle_with_fewer_thrusters_than_another_keeps_its_arm_at_the_end() -> None:
    both = SHORT | {"vehicle": "both", "arm": "hook"}
    with gymnasium.make(ENVIRONMENT, settings=both) as env:
        first, _ = env.reset(seed=SEED, options={"trial": 0, "level": 0})
        second, _ = env.reset(options={"trial": 1, "level": 0})

        assert first.shape == second.shape
        for observation in (first, second):
            assert named(observation, arm="hook").joints == pytest.approx([0.0, 0.0], abs=0.01)


def test_a_vector_of_vehicles_with_arms_is_refused_with_a_sentence() -> None:
    with pytest.raises(ValueError, match="with an arm"):
        gymnasium.make_vec(
            ENVIRONMENT, num_envs=2, vectorization_mode="vector_entry_point", settings=SHORT
        )
