"""Environments go on from the state of another one with the same bytes."""

import hashlib
import io
import json
import subprocess
import sys
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

from seamark.gym import BENCHMARKS
from seamark.gym.checkpoints import CheckpointInvalid
from seamark.gym.stable_baselines import SeamarkVecEnv
from seamark.gym.vector import StationKeepingVectorEnv
from seamark.sim import registry

SHORT: dict[str, Any] = {"levels": [0.1, 0.6], "level_duration_s": 2.0, "settle_s": 1.0}
TRUTH = SHORT | {"tracker": "truth"}
STEPS = 40  # of a level
VEHICLES = 3
NAME = "seamark/StationKeeping-v2"
RUN = """
import sys
import gymnasium, numpy as np
from tests.seamark.gym.test_checkpoints import NAME, TRUTH, VEHICLES, digest
one = gymnasium.make(NAME, settings=TRUTH)
for env in (one, gymnasium.make_vec(NAME, num_envs=VEHICLES, settings=TRUTH)):
    env.reset()
    with np.load(f"{sys.argv[1]}/{'one' if env is one else 'many'}.npz") as state:
        env.unwrapped.set_state(state)
    print(digest(env))
"""


def single(gym_id: str, **options: Any) -> Any:
    with warnings.catch_warnings():  # of the first versions: that there are second ones
        warnings.simplefilter("ignore", DeprecationWarning)
        env = gymnasium.make(gym_id, disable_env_checker=True, **options)
    return env.unwrapped


def many(count: int = VEHICLES, **options: Any) -> StationKeepingVectorEnv:
    return StationKeepingVectorEnv(num_envs=count, benchmark="currents-v2", **options)


def bits(value: Any) -> Any:
    """Return what a step gave, with the bytes of all its numbers."""
    if isinstance(value, dict):
        return {key: bits(value[key]) for key in sorted(value)}
    if isinstance(value, tuple | list):
        return [bits(each) for each in value]
    array = np.asarray(value)
    return [bits(each) for each in array] if array.dtype == object else array.tobytes()


def going_on(env: Any, steps: int, *, seed: int = 5) -> list[Any]:
    """Take random actions; return the bits of all that the steps gave."""
    env.action_space.seed(seed)
    return [bits(env.step(env.action_space.sample())) for _ in range(steps)]


def digest(env: Any) -> str:
    return hashlib.sha256(repr(going_on(env, 5)).encode()).hexdigest()


def filed(state: dict[str, Any]) -> Any:
    """Return a state as it comes from a file."""
    file = io.BytesIO()
    np.savez(file, **state)
    file.seek(0)
    return np.load(file)


def changed(state: dict[str, Any], name: str, change: Callable[[Any], Any]) -> dict[str, Any]:
    return state | {name: change(state[name])}


def with_header(state: dict[str, Any], **others: Any) -> dict[str, Any]:
    return changed(
        state, "header", lambda text: np.array(json.dumps(json.loads(str(text)) | others))
    )


@pytest.fixture(scope="module")
def one() -> Any:
    env = single(NAME, settings=TRUTH)
    env.reset(seed=3)
    return env


@pytest.fixture(scope="module")
def fleet() -> Any:
    env = many(settings=TRUTH)
    env.reset(seed=3)
    going_on(env, 3)
    return env


@pytest.mark.slow
@pytest.mark.parametrize("gym_id", sorted(BENCHMARKS))
def test_an_environment_of_every_benchmark_goes_on_from_a_state_in_a_file(gym_id: str) -> None:
    settings = dict(registry.benchmark(BENCHMARKS[gym_id]).quick_settings)
    first, second = (single(gym_id, settings=settings) for _ in range(2))
    first.reset(seed=3)
    first.reset()
    going_on(first, 6, seed=1)

    with filed(first.get_state()) as state:
        _, info = second.set_state(state)

    assert {"seed", "trial", "level"} <= info.keys()
    assert going_on(first, 4) == going_on(second, 4)
    assert bits(first.reset()) == bits(second.reset())


@pytest.mark.slow
@pytest.mark.parametrize("mode", ["NextStep", "SameStep"])
@pytest.mark.parametrize(
    "options",
    [
        {"settings": TRUTH},
        {"settings": TRUTH, "action": "thrusters", "dtype": "float32"},
        {"settings": SHORT, "observation": "state+corners+image+depth"},
        {"settings": SHORT, "channels": "rgb", "observation": "image"},
    ],
    ids=["truth", "thrusters", "camera", "colours"],
)
def test_many_vehicles_go_on_with_the_same_bits_over_the_ends_of_levels(
    mode: str, options: Any
) -> None:
    first, second = (many(autoreset_mode=mode, **options) for _ in range(2))
    first.reset(seed=3)
    going_on(first, STEPS, seed=1)  # under NextStep, all vehicles are at the ends of their levels

    with filed(first.get_state()) as state:
        second.set_state(state)

    assert going_on(first, STEPS + 5) == going_on(second, STEPS + 5)
    assert bits(first.reset()) == bits(second.reset())


@pytest.mark.slow
def test_vehicles_that_were_reset_with_a_mask_go_on_with_the_same_bits() -> None:
    first, second = (many(settings=TRUTH, autoreset_mode="Disabled") for _ in range(2))
    first.reset(seed=3)
    going_on(first, 7)
    mask = np.array([True, False, False])
    first.reset(options={"reset_mask": mask})
    going_on(first, STEPS - 7)
    state = first.get_state()
    second.set_state(state)

    for env in (first, second):  # two vehicles are at the ends of their levels
        with pytest.raises(gymnasium.error.ResetNeeded, match="whose episodes are over"):
            env.step(np.zeros((VEHICLES, 4)))

    assert bits(first.reset(options={"reset_mask": ~mask})) == bits(
        second.reset(options={"reset_mask": ~mask})
    )
    assert going_on(first, 5) == going_on(second, 5)


@pytest.mark.slow
def test_a_vehicle_in_contact_with_the_bottom_goes_on_with_the_same_bits() -> None:
    settings = TRUTH | {"level_duration_s": 12.0}
    dive = np.tile([0.0, 0.0, 1.0, 0.0], (VEHICLES, 1))
    first, second = many(settings=settings), many(settings=settings)
    first.reset(seed=1)
    while not (state := first.get_state())["contacts"].any():
        first.step(dive)
    second.set_state(state)

    for _ in range(10):
        assert bits(first.step(dive)) == bits(second.step(dive))
        assert bits(first.telemetry) == bits(second.telemetry)


@pytest.mark.slow
def test_a_vehicle_that_diverged_goes_on_with_the_same_bits() -> None:
    first, second = many(settings=TRUTH), many(settings=TRUTH)
    first.reset(seed=1)
    actions = np.zeros((VEHICLES, 4))
    actions[1] = np.nan
    while not first.step(actions)[2].any():
        pass

    second.set_state(first.get_state())

    assert going_on(first, 5) == going_on(second, 5)


@pytest.mark.slow
def test_another_process_goes_on_with_the_same_bits(one: Any, fleet: Any, tmp_path: Path) -> None:
    for name, env in (("one", one), ("many", fleet)):
        np.savez(tmp_path / f"{name}.npz", **env.get_state())

    done = subprocess.run(
        [sys.executable, "-c", RUN, tmp_path], capture_output=True, text=True, check=True
    )

    assert done.stdout.split() == [digest(one), digest(fleet)]


def test_a_state_branches_into_as_many_futures_as_are_asked_for(fleet: Any) -> None:
    others = many(4, settings=TRUTH)

    seen, _ = others.set_state(fleet.get_state(), source=[2, 2, 0, 2])
    actions = np.zeros((4, 4))
    actions[3, 0] = 0.5
    others.step(actions)
    after = others.step(actions)[0]

    np.testing.assert_array_equal(seen[0], seen[1])
    assert (seen[0] != seen[2]).any()
    np.testing.assert_array_equal(after[0], after[1])


def test_an_environment_goes_back_to_an_earlier_state_of_its_own(fleet: Any) -> None:
    state = fleet.get_state()
    kept = {name: array.copy() for name, array in state.items()}
    before = going_on(fleet, 4)

    fleet.set_state(state)

    assert going_on(fleet, 4) == before
    assert bits(state) == bits(kept)


def test_the_form_for_stable_baselines_goes_on_from_a_state() -> None:
    first, second = (SeamarkVecEnv(num_envs=2, settings=TRUTH, seed=seed) for seed in (3, 4))
    first.reset()
    second.reset()
    first.step(np.full((2, 4), 0.3, np.float32))

    seen = second.set_state(first.get_state())

    action = np.full((2, 4), -0.3, np.float32)
    assert seen.dtype == np.float32
    assert bits(first.step(action)) == bits(second.step(action))


@pytest.mark.parametrize("name", ["one", "fleet"])
def test_a_state_of_something_else_is_refused_with_a_sentence(
    name: str, request: pytest.FixtureRequest
) -> None:
    env = request.getfixturevalue(name)
    state, before = env.get_state(), bits(env.telemetry)
    options = json.loads(str(state["header"]))["options"]
    episode = json.loads(str(state["header"]))["episodes"][0]
    wrong = [
        (None, "no header"),
        ({"telemetry": np.zeros(3)}, "no header"),
        (state | {"header": np.array("[" * 100_000)}, "header of the state cannot be read"),
        (state | {"header": np.array("[]")}, "header of the state cannot be read"),
        (with_header(state, random={"bit_generator": "MT19937"}), "cannot be read"),
        (with_header(state, options=options | {"Seamark": "0.1"}), "Seamark '0.1', not"),
        (with_header(state, options=options | {"tracker": "esm"}), "tracker 'esm', not 'truth'"),
        (with_header(state, options=options | {"depth_of_water": 3}), "depth_of_water 3, not None"),
        (with_header(state, episodes=[[1, 2]]), "cannot be read"),
        (with_header(state, episodes=[[-1, 0, 0, 0]] * VEHICLES), "four whole numbers"),
        (with_header(state, episodes=[]), "0 episodes|of 0 vehicles"),
    ]
    if name == "one":
        beyond = [*episode[:3], 9**99]
        wrong += [
            (with_header(state, episodes=[[episode[0], 2**31, 0, 0]]), "trial must be from 0"),
            (with_header(state, episodes=[beyond]), "no such level"),
        ]

    for other, sentence in wrong:
        with pytest.raises(CheckpointInvalid, match=sentence):
            env.set_state(other)

    assert bits(env.telemetry) == before


def test_a_state_of_one_vehicle_is_none_of_many(one: Any, fleet: Any) -> None:
    with pytest.raises(CheckpointInvalid, match="vehicles 'one', not 'many'"):
        fleet.set_state(one.get_state())


def test_a_state_with_changed_actions_is_refused(one: Any) -> None:
    other = single(NAME, settings=TRUTH)
    one.reset(seed=3)
    going_on(one, 3)
    state = one.get_state()
    endless = np.zeros((STEPS + 1, 4))

    for actions, sentence in (
        (state["actions"][:-1], "gave other bits"),
        (0.5 * state["actions"], "gave other bits"),
        (state["actions"].astype(np.float32), "float32 and shape"),
        (state["actions"][:, :3], r"shape \(3, 3\)"),
        (np.zeros((0,)), r"shape \(0,\)"),
        (endless, "after the end of its level"),
    ):
        with pytest.raises(CheckpointInvalid, match=sentence):
            other.set_state(state | {"actions": actions})
    with pytest.raises(CheckpointInvalid, match="gave other bits"):
        other.set_state(state | {"telemetry": np.zeros(3)})


def test_changed_arrays_of_many_vehicles_are_refused(fleet: Any) -> None:
    state, before = fleet.get_state(), bits(fleet.telemetry)
    everything = [name for name in state if name != "header"]

    for name in everything:
        lacking = {key: array for key, array in state.items() if key != name}
        for other in (
            lacking,
            changed(state, name, lambda array: array[:-1]),
            changed(state, name, lambda array: array.astype(np.complex64)),
            changed(state, name, lambda array: array[..., None]),
        ):
            with pytest.raises(CheckpointInvalid):
                fleet.set_state(other)
    for name, number in (
        ("progress.step", -1),
        ("progress.step", STEPS),
        ("progress.step", 2**60),
        ("dvl.readings", 2**60),
        ("ahrs.readings", -1),
    ):
        with pytest.raises(CheckpointInvalid, match=r"is not from|after the end"):
            fleet.set_state(state | {name: np.full_like(state[name], number)})
    for source in ([0, 1], [0, 1, 3], [0, 1, -1]):
        with pytest.raises(CheckpointInvalid, match="3 numbers of 3 vehicles"):
            fleet.set_state(state, source=source)

    assert bits(fleet.telemetry) == before


def test_a_broken_file_is_refused(one: Any, tmp_path: Path) -> None:
    path = tmp_path / "state.npz"
    np.savez(path, **one.get_state())
    content = bytearray(path.read_bytes())
    content[content.index("options".encode("utf-32-le"))] ^= 1
    path.write_bytes(content)

    with np.load(path) as state, pytest.raises(CheckpointInvalid, match="cannot be read"):
        one.set_state(state)


def test_what_nobody_can_copy_is_refused_with_a_sentence() -> None:
    for settings in ({"tracker": "kcf"}, {"tracker": "truth", "contacts": "pybullet"}):
        env = many(1, settings=SHORT | settings)
        env.reset(seed=3)
        with pytest.raises(CheckpointInvalid, match="nobody can copy"):
            env.get_state()


def test_a_state_needs_an_episode() -> None:
    for env in (many(1, settings=TRUTH), single(NAME, settings=TRUTH)):
        with pytest.raises(gymnasium.error.ResetNeeded):
            env.get_state()
