"""Environments with images: an observation has what a controller gets."""

from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import seamark.gym  # noqa: F401 - registers the environments
from seamark.gym.spaces import named
from tests.seamark.gym.test_arm import COMMAND, ENVIRONMENT
from tests.sim.engine.test_arm import SEED, SHORT, run
from tests.sim.engine.test_images import Looking

SETTINGS = SHORT | {"images": "both", "camera_delay_steps": 2}


def make(**options: Any) -> gymnasium.Env[Any, Any]:
    return gymnasium.make(ENVIRONMENT, **({"settings": SETTINGS} | options))


def test_an_episode_has_the_images_that_a_controller_gets() -> None:
    program = Looking()
    program.command = COMMAND
    run(program, images="both", camera_delay_steps=2)
    with make() as env:
        observation, _ = env.reset(seed=SEED)
        for seen in program.kept[:20]:
            here = named(observation, arm="alpha-like")
            assert (here.t, here.image_t) == (seen.t, seen.image_t)
            for camera, image in seen.images.items():
                assert observation[f"image_{camera}"].tobytes() == image.tobytes()
                assert here.images[camera] is observation[f"image_{camera}"]
            observation, *_ = env.step(np.array(COMMAND))


def test_the_space_has_the_state_and_an_image_of_each_camera_that_is_asked_for() -> None:
    with make(settings=SETTINGS | {"images": "arm"}, dtype=np.float32) as env:
        observation, _ = env.reset(seed=SEED)

        assert env.observation_space.contains(observation)
        assert list(observation) == ["state", "image_arm"]
        assert observation["state"].dtype == np.float32
        assert observation["image_arm"].shape == (240, 320)
        assert named(observation, arm="alpha-like").joints == pytest.approx(
            [0.0, 1.0, 2.5, 0.0, 0.3], abs=0.01
        )


def test_an_image_that_a_policy_changes_is_whole_again_in_the_next_observation() -> None:
    with make() as env:
        observation, _ = env.reset(seed=SEED)
        first = observation["image_arm"].copy()
        observation["image_arm"][:] = 0
        observation, *_ = env.step(np.array(COMMAND))

        assert observation["image_arm"].tobytes() == first.tobytes()


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:.*:UserWarning")
def test_the_checker_of_gymnasium_has_no_objections() -> None:
    with make() as env:
        check_env(env.unwrapped, skip_render_check=True)


def test_a_vector_of_vehicles_with_images_is_refused_with_a_sentence() -> None:
    settings = SHORT | {"arm": "none", "images": "vehicle"}
    with pytest.raises(ValueError, match="images of the cameras"):
        gymnasium.make_vec(
            ENVIRONMENT, num_envs=2, vectorization_mode="vector_entry_point", settings=settings
        )
