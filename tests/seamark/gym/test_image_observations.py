"""Observations with images: their pixels, when they come, and what is refused."""

from typing import Any

import gymnasium
import numpy as np
import pytest

import seamark.gym  # noqa: F401  # registers the environments
from seamark.gym.stable_baselines import SeamarkVecEnv
from seamark.sim.camera import Camera, Optics

NAME = "seamark/StationKeeping-v3"
SHORT = {"tracker": "truth", "levels": [0.2], "level_duration_s": 2.0, "settle_s": 1.0}
PARTS = "state+corners+image+depth+segmentation"
STEPS = 15


def single(**options: Any) -> Any:
    return gymnasium.make(NAME, settings=SHORT | options.pop("settings", {}), **options)


def several(**options: Any) -> Any:
    return gymnasium.make_vec(NAME, num_envs=3, settings=SHORT, **options)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"observation": "pixels"}, "observation is 'pixels', but its parts are state, corners"),
        ({"observation": "image+image"}, "has a part twice"),
        ({"observation": ""}, "observation is ''"),
        ({"observation": "image", "channels": "bgr"}, "channels must be one of grey, rgb"),
        ({"observation": "image", "image_size": (8, 84)}, "8x84 px is not within 16..4096"),
    ],
)
@pytest.mark.parametrize("make", [single, several])
def test_what_no_observation_can_be_is_refused_with_what_it_can(
    make: Any, options: dict[str, Any], message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        make(**options)


@pytest.mark.parametrize("observation", [PARTS, *PARTS.split("+")])
def test_observations_are_in_their_space(observation: str) -> None:
    for make in (single, several):
        env = make(observation=observation, dtype="float32")
        shown, _ = env.reset(seed=3)
        assert env.observation_space.contains(shown)
        for _ in range(3):
            shown, *_ = env.step(env.action_space.sample())
            assert env.observation_space.contains(shown)


def test_an_image_is_what_a_camera_of_its_size_sees_from_the_true_pose() -> None:
    env = single(observation="image", image_size=(128, 96))
    shown, info = env.reset(seed=5)
    inside = env.unwrapped
    usual = inside._world.camera
    optics = Optics(width=128, height=96, focal_px=514.7 * 96 / 480, mount_m=usual.optics.mount_m)

    camera = Camera(optics, usual.water, usual.target, noise_seed=usual._grain.seed)

    np.testing.assert_array_equal(shown[:, :, 0], camera.grey(info["pose"], 0))


def test_images_come_when_a_program_gets_them() -> None:
    size = {"camera_width_px": 320, "camera_height_px": 240, "camera_focal_px": 257.35}
    settings = size | {"images": "vehicle", "start_offset_m": 0.0, "altitude_m": 2.0}
    program = single(settings=settings)
    policy = single(settings=settings, observation="image", image_size=(320, 240))
    given, _ = program.reset(seed=7)
    shown, _ = policy.reset(seed=7)
    changes = 0

    for _ in range(STEPS):
        np.testing.assert_array_equal(shown[:, :, 0], given["image_vehicle"])
        before = shown
        given, *_ = program.step([0.2, 0.1, 0.0, 0.1])
        shown, *_ = policy.step([0.2, 0.1, 0.0, 0.1])
        changes += not np.array_equal(before, shown)

    assert 3 <= changes < STEPS  # the first is the only one for the time of the delay


def test_what_a_policy_does_with_the_images_of_many_vehicles_changes_no_later_ones() -> None:
    env, untouched = several(observation="image"), several(observation="image")
    env.reset(seed=3)
    untouched.reset(seed=3)

    for _ in range(STEPS):  # an image comes at every second step: the others are those before
        shown, *_ = env.step(np.full((3, 4), 0.1))
        expected, *_ = untouched.step(np.full((3, 4), 0.1))
        kept = expected.copy()
        np.testing.assert_array_equal(shown, expected)
        shown[:] = 0
        untouched.step(np.full((3, 4), 0.1))
        env.step(np.full((3, 4), 0.1))
        np.testing.assert_array_equal(expected, kept)


def test_the_target_of_a_segmentation_is_nearer_than_the_bottom() -> None:
    env = several(observation="depth+segmentation")
    shown, _ = env.reset(seed=1)

    for depth, labels in zip(shown["depth"], shown["segmentation"], strict=True):
        assert 10 < labels.sum() < labels.size / 4
        assert depth[labels == 1].mean() < depth[labels == 0].mean()


def test_stable_baselines_gets_a_dict_of_images_and_numbers() -> None:
    env = SeamarkVecEnv(NAME, num_envs=2, settings=SHORT, observation="image+state", seed=1)
    first = env.reset()

    for _ in range(40):
        shown, _, over, infos = env.step(np.zeros((2, 4), np.float32))

    assert over.all()
    spaces: Any = env.observation_space
    for name, space in spaces.items():
        assert first[name].shape == shown[name].shape == (2, *space.shape)
        assert infos[1]["terminal_observation"][name].shape == space.shape
