"""The vector environment, beside Gymnasium's own vectorisation of single environments."""

import os
import subprocess
import sys
import warnings
from functools import partial
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode, SyncVectorEnv, VectorEnv

from seamark.gym.station_keeping import StationKeepingEnv
from seamark.gym.vector import StationKeepingVectorEnv

TRUTH = {"tracker": "truth", "levels": [0.1, 0.6], "level_duration_s": 2.0, "settle_s": 1.0}
CAMERA = TRUTH | {"tracker": "esm"}
PLACE = TRUTH | {"current_place": "ria", "wave_height_m": 0.4}
MURKY = TRUTH | {"caustics": 0.2, "camera_exposure_s": 0.02, "camera_delay_steps": 1}
VEHICLES = 11  # more than one block of lanes, and a part of another one


def assert_equal(one: Any, other: Any) -> None:
    if isinstance(other, dict):
        assert one.keys() == other.keys()
        for key in other:
            np.testing.assert_array_equal(one[key], other[key])
    else:
        np.testing.assert_array_equal(one, other)


def assert_same(ours: Any, theirs: Any) -> None:
    for one, other in zip(ours[:-1], theirs[:-1], strict=True):
        assert_equal(one, other)
    for name in ("pose", "velocity", "current", "distance", "tracker_error"):
        np.testing.assert_array_equal(ours[-1][name], theirs[-1][name])


def pair(mode: AutoresetMode, **options: Any) -> tuple[Any, Any]:
    ours = StationKeepingVectorEnv(num_envs=VEHICLES, autoreset_mode=mode, **options)
    single = partial(StationKeepingEnv, **options)
    return ours, SyncVectorEnv([single] * VEHICLES, autoreset_mode=mode)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("mode", "options"),
    [
        (AutoresetMode.NEXT_STEP, {"benchmark": "currents-v2", "settings": TRUTH}),
        (AutoresetMode.SAME_STEP, {"benchmark": "currents-v1", "settings": TRUTH}),
        (
            AutoresetMode.NEXT_STEP,
            {"benchmark": "currents-v2", "settings": TRUTH, "action": "thrusters"},
        ),
        (AutoresetMode.NEXT_STEP, {"benchmark": "currents-v2", "settings": CAMERA}),
        (AutoresetMode.NEXT_STEP, {"benchmark": "currents-v2", "settings": PLACE}),
        (
            AutoresetMode.SAME_STEP,
            {"benchmark": "currents-v2", "settings": TRUTH, "observation": "image"},
        ),
        (
            AutoresetMode.NEXT_STEP,
            {"benchmark": "currents-v2", "settings": MURKY, "observation": "image+state"}
            | {"channels": "rgb", "image_size": (60, 40)},
        ),
        (
            AutoresetMode.NEXT_STEP,
            {"benchmark": "currents-v2", "settings": CAMERA, "observation": "corners"},
        ),
        (
            AutoresetMode.NEXT_STEP,
            {"benchmark": "currents-v1", "settings": TRUTH, "observation": "depth+segmentation"},
        ),
    ],
    ids=[
        *("velocity", "at once", "thrusters", "camera", "place"),
        *("images", "coloured images and numbers", "corners", "surveys"),
    ],
)
def test_every_bit_is_that_of_single_environments(mode: AutoresetMode, options: Any) -> None:
    ours, theirs = pair(mode, **options)
    ours.action_space.seed(1)
    assert_same(ours.reset(seed=7), theirs.reset(seed=7))
    ended = 0

    for _ in range(130):  # over three levels, so over the change of vehicles
        actions = ours.action_space.sample()
        mine, reference = ours.step(actions), theirs.step(actions)
        assert_same(mine, reference)
        ended += int(mine[3].sum())
        if "final_obs" in reference[-1]:
            for one, other in zip(mine[-1]["final_obs"], reference[-1]["final_obs"], strict=True):
                assert_equal(one, other)

    assert ended >= 3 * VEHICLES


@pytest.mark.slow
@pytest.mark.parametrize(
    ("settings", "observation"),
    [(TRUTH, "state"), (TRUTH, "image"), (CAMERA, "state"), (CAMERA, "image")],
)
def test_a_vehicle_that_hits_the_bottom_moves_and_sees_as_in_the_single_environment(
    settings: Any, observation: str
) -> None:
    options: Any = {"settings": settings | {"level_duration_s": 12.0}, "observation": observation}
    ours, theirs = pair(AutoresetMode.NEXT_STEP, benchmark="currents-v1", **options)
    assert_same(ours.reset(seed=1), theirs.reset(seed=1))
    force = 0.0

    for _ in range(200):
        actions = np.tile([0.0, 0.0, 1.0, 0.0], (VEHICLES, 1))
        assert_same(ours.step(actions), theirs.step(actions))
        force = max(force, ours.telemetry[:, -2].max())

    assert force > 0.0


@pytest.mark.long  # it compiles everything again; the test above is the one that it runs
def test_no_index_of_a_fleet_is_out_of_bounds(tmp_path: Path) -> None:
    checked = {"NUMBA_BOUNDSCHECK": "1", "NUMBA_CACHE_DIR": str(tmp_path)}

    ended = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", __file__, "-k", "bottom"],
        env=os.environ | checked,
        capture_output=True,
        text=True,
        check=False,
    )

    assert "4 passed" in ended.stdout, ended.stdout[-2000:]


@pytest.mark.slow
@pytest.mark.parametrize(
    "options",
    [{"settings": TRUTH}, {"settings": CAMERA, "observation": "image+corners"}],
    ids=["true corners", "camera"],
)
def test_the_number_of_threads_changes_no_bit(options: Any) -> None:
    runs = []
    for threads in (1, 2, 3):
        env = StationKeepingVectorEnv(
            num_envs=100, benchmark="currents-v2", threads=threads, **options
        )
        env.action_space.seed(1)
        env.reset(seed=2)
        for _ in range(10):
            observations, *_ = env.step(env.action_space.sample())
        runs.append(observations)
        env.close()

    assert_equal(runs[0], runs[1])
    assert_equal(runs[0], runs[2])


def test_only_the_vehicles_in_the_mask_are_reset() -> None:
    env = StationKeepingVectorEnv(
        num_envs=VEHICLES,
        benchmark="currents-v2",
        settings=TRUTH,
        autoreset_mode=AutoresetMode.DISABLED,
    )
    env.reset(seed=3)
    for _ in range(40):
        before, *_, truncated, _info = env.step(np.zeros((VEHICLES, 4)))
    assert truncated.all()
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.step(np.zeros((VEHICLES, 4)))

    mask = np.arange(VEHICLES) % 3 != 1
    after, _info = env.reset(options={"reset_mask": mask})

    assert ((before != after).any(axis=1) == mask).all()


def test_images_under_way_stay_when_another_vehicle_is_reset() -> None:
    def images(reset_at: int) -> list[Any]:
        env = StationKeepingVectorEnv(
            num_envs=3,
            benchmark="currents-v2",
            settings=TRUTH | {"levels": [0.3]},
            observation="image",
            autoreset_mode=AutoresetMode.DISABLED,
        )
        env.reset(seed=1)
        shown = []
        for step in range(8):
            if step == reset_at:
                env.reset(options={"reset_mask": np.array([True, False, False])})
            shown.append(env.step(np.full((3, 4), 0.2))[0][1:])
        return shown

    np.testing.assert_array_equal(images(reset_at=4), images(reset_at=-1))


def test_gymnasium_makes_the_vector_environment_from_the_name() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        env: VectorEnv[Any, Any, Any] = gymnasium.make_vec(
            "seamark/StationKeeping-v1", num_envs=2, settings=TRUTH
        )

    assert isinstance(env, StationKeepingVectorEnv)
    assert env.metadata["autoreset_mode"] is AutoresetMode.NEXT_STEP
    observations, _info = env.reset(seed=1)
    assert observations in env.observation_space


def test_what_only_one_vehicle_can_have_is_refused_with_a_sentence() -> None:
    with pytest.raises(ValueError, match="fault_thruster"):
        StationKeepingVectorEnv(
            num_envs=1, benchmark="currents-v1", settings=TRUTH | {"fault_thruster": 0}
        )
