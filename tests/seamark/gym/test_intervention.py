"""The environments of benchmarks whose programs move an arm."""

import warnings
from pkgutil import resolve_name
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from seamark.gym import BENCHMARKS
from seamark.gym.intervention import APPROACH_1_M
from seamark.gym.spaces import named
from seamark.gym.stable_baselines import SeamarkVecEnv
from seamark.sim import registry
from seamark.sim.control.manipulation.kinematics import applied, rotation
from seamark.sim.engine.trial import run_trial
from seamark.sim.recording.telemetry import ARM_INDEX, ARM_JOINTS, INDEX, STEP_US

pytestmark = pytest.mark.slow

INTERVENTIONS = {
    gym_id: name for gym_id, name in BENCHMARKS.items() if registry.benchmark(name).moves_arm
}
SHORT = {"levels": [0.1, 0.2], "level_duration_s": 2.0, "tracker": "truth"}
# All stages are over after 48 s, except turning the valve.
WHOLE = {"levels": [0.0], "level_duration_s": 50.0, "tracker": "truth"}
OF_THE_NEXT_ACTION = [
    STEP_US,
    *range(INDEX["ref_u"], INDEX["ref_r"] + 1),
    *range(ARM_INDEX["joint_ref_0"], ARM_INDEX["joint_ref_0"] + ARM_JOINTS),
]
Env = gymnasium.Env[Any, Any]


def env_of(gym_id: str, **options: Any) -> Env:
    return gymnasium.make(gym_id, **options).unwrapped


def expert_of(gym_id: str) -> str:
    """Return the name of the first built-in controller of a benchmark."""
    return next(iter(registry.benchmark(INTERVENTIONS[gym_id]).built_in))


def settings_of(gym_id: str, settings: dict[str, object]) -> dict[str, object]:
    """Return settings with a single level for each current."""
    grid = "loop1_values" if gym_id == "seamark/Mission-v1" else ""
    return settings | ({grid: [0.5]} if grid else {})


def controller_of(gym_id: str, config: Any, trial: int) -> Any:
    """Return the built-in controller of a benchmark, at the start of a level."""
    task = registry.benchmark(INTERVENTIONS[gym_id]).load().task  # type: ignore[attr-defined]
    made = resolve_name(registry.controller_path(expert_of(gym_id), task))
    controller = made(config.for_trial(trial).for_program())
    controller.reset({"dt": config.control_period_s})
    return controller


def steps(env: Env, gym_id: str, settings: dict[str, object], seed: int | None) -> Any:
    """Yield the row before, and what came of each step of an episode with that controller."""
    config: Any = registry.benchmark(INTERVENTIONS[gym_id]).read(settings)
    observation, info = env.reset(seed=seed)
    controller, over = controller_of(gym_id, config, info["trial"]), False
    while not over:
        row = env.telemetry  # type: ignore[attr-defined]
        seen = named(observation, arm=config.arm, search=config.searches())
        action = np.array(controller.step(seen))
        before = info
        observation, reward, _terminated, over, info = env.step(action)
        yield row, before, reward, info


@pytest.mark.parametrize(
    ("gym_id", "reward"),
    # One function tells the rewards of all benchmarks; tests below compare both kinds in each.
    [*((gym_id, "dense") for gym_id in INTERVENTIONS), ("seamark/Recover-v1", "sparse")],
)
def test_the_environment_passes_gymnasiums_checker(gym_id: str, reward: str) -> None:
    env = env_of(
        gym_id, settings=settings_of(gym_id, SHORT), reward=reward, render_mode="rgb_array"
    )

    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message=".*infinity")  # a position has no bound
        warnings.filterwarnings("ignore", message=".*symmetric and normalized")  # SI units
        check_env(env)


@pytest.mark.parametrize("gym_id", INTERVENTIONS)
def test_the_episodes_of_a_seed_are_the_run_with_that_seed(gym_id: str) -> None:
    entry = registry.benchmark(INTERVENTIONS[gym_id])
    config: Any = entry.read(settings_of(gym_id, SHORT))
    rows: list[Any] = []
    for trial in range(2):
        solution = entry.load().built_in(expert_of(gym_id), config)
        run_trial(entry.name, config, solution, seed=5, trial=trial, on_rows=rows.append)
    expected = {(row[0], row[2]): row.copy() for part in rows for row in part}
    env, compared = env_of(gym_id, settings=settings_of(gym_id, SHORT)), 0

    for episode in range(4):
        for row, *_ in steps(env, gym_id, settings_of(gym_id, SHORT), None if episode else 5):
            reference = expected[row[0], row[2]]
            reference[OF_THE_NEXT_ACTION] = 0.0
            np.testing.assert_array_equal(row, reference)
            compared += 1

    assert compared == len(expected)


@pytest.mark.slow
@pytest.mark.parametrize("gym_id", INTERVENTIONS)
def test_the_sparse_rewards_of_a_level_add_up_to_its_credit(gym_id: str) -> None:
    settings = settings_of(gym_id, WHOLE)
    entry = registry.benchmark(INTERVENTIONS[gym_id])
    config: Any = entry.read(settings)

    taken = [
        (row.copy(), reward, info)
        for row, _, reward, info in steps(
            env_of(gym_id, settings=settings, reward="sparse"), gym_id, settings, 5
        )
    ]

    # Its rows are those of the run with that seed, as the test above shows.
    rows, rewards, (*_, last) = (
        np.array([row for row, *_ in taken]),
        [one[1] for one in taken],
        taken[-1],
    )
    credit = entry.load().metrics(config.for_trial(0), 0, rows)["credit"]
    assert credit > 0.2
    assert sum(rewards) == pytest.approx(credit, abs=1e-12)
    assert last["credit"] == credit
    assert rewards.count(0.0) > 0.8 * len(rewards)
    assert last["stages"] >= 3


@pytest.mark.parametrize("gym_id", INTERVENTIONS)
def test_the_dense_reward_is_the_credit_gained_and_the_way_of_the_tool_to_the_grip(
    gym_id: str,
) -> None:
    for _, before, reward, after in steps(
        env_of(gym_id, settings=settings_of(gym_id, SHORT)), gym_id, settings_of(gym_id, SHORT), 5
    ):
        gained = after["credit"] - before["credit"]
        closer = before["reach"] - after["reach"]

        assert closer != 0.0
        assert reward == pytest.approx(gained + APPROACH_1_M * closer, abs=1e-12)


def test_the_true_work_and_tool_are_in_the_info() -> None:
    _, info = env_of("seamark/Recover-v1", settings=SHORT).reset(seed=5)
    turn = rotation(*info["workpiece"][3:])
    off = info["workpiece"][:3] + applied(turn, (0.0, 0.0, -0.17)) - info["tool"][:3]

    assert info["reach"] == pytest.approx(np.linalg.norm(off))
    assert (info["credit"], info["stages"]) == (0.0, 0)


def test_vehicles_for_stable_baselines_are_single_ones_in_processes() -> None:
    options = {"settings": SHORT, "dtype": np.float32, "normalise_actions": True}
    many = SeamarkVecEnv("seamark/Recover-v1", num_envs=2, settings=SHORT, seed=7)
    singles = [env_of("seamark/Recover-v1", **options) for _ in range(2)]
    first = np.array([env.reset(seed=7 + i)[0] for i, env in enumerate(singles)])
    np.testing.assert_array_equal(many.reset(), first)
    actions = np.random.default_rng(1).uniform(-1.0, 1.0, (40, 2, 9)).astype(np.float32)

    for step, pair in enumerate(actions):
        observations, rewards, over, infos = many.step(pair)
        for i, env in enumerate(singles):
            expected, reward, _, truncated, _ = env.step(pair[i])
            seen = infos[i]["terminal_observation"] if truncated else observations[i]
            np.testing.assert_array_equal(seen, expected)
            assert (rewards[i], over[i]) == (np.float32(reward), truncated)
            assert truncated is (step == len(actions) - 1)
    many.close()


def test_an_unknown_reward_is_refused() -> None:
    with pytest.raises(ValueError, match="reward must be one of sparse, dense, not 'mean'"):
        env_of("seamark/Recover-v1", settings=SHORT, reward="mean")
