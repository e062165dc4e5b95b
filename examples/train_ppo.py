"""Train a controller for currents-v2 with PPO of Stable-Baselines3.

    pip install "seamark[gym]" "stable-baselines3>=2.9"
    python examples/train_ppo.py

All vehicles are one vector environment with true corners. The policy sees error, its integral,
velocity, heading and yaw rate, and a tanh network of two layers gives the velocity reference. What
is written is a controller in NumPy alone: it runs and is submitted without Stable-Baselines3. It is
written only if it does better than the policy with which the training began.
"""

import argparse
import json
import sys
import time
from pathlib import Path
from typing import Any

try:
    from stable_baselines3 import PPO
    from stable_baselines3.common.vec_env import VecEnvWrapper, VecMonitor
except ImportError as missing:
    sys.exit(
        'This example needs Stable-Baselines3: pip install "stable-baselines3>=2.9" '
        f"(with PyTorch, of which the CPU version is enough). Python says: {missing}"
    )
import gymnasium
import numpy as np

from seamark.gym.stable_baselines import SeamarkVecEnv

CONTROLLER = '''"""A controller that examples/train_ppo.py trained."""

import numpy as np

LONGEST_INTEGRAL = 10.0  # m s
LAYERS = [(np.array(weights), np.array(bias)) for weights, bias in {layers}]


class Controller:
    def __init__(self, config):
        self.integral = np.zeros(2)

    def reset(self, level):
        self.integral = np.zeros(2)

    def step(self, observation):
        error = observation.error[:2]
        self.integral = self.integral + error * observation.dt
        self.integral = np.clip(self.integral, -LONGEST_INTEGRAL, LONGEST_INTEGRAL)
        yaw, rate = observation.attitude[2], observation.rates[2]
        x = np.concatenate([error, self.integral, observation.velocity[:2], [yaw, rate]])
        for weights, bias in LAYERS[:-1]:
            x = np.tanh(weights @ x + bias)
        weights, bias = LAYERS[-1]
        surge, sway, turn = np.clip(weights @ x + bias, -1.0, 1.0)
        return surge, sway, 0.0, turn
'''
LEVELS = [0.1, 0.3, 0.5, 0.8]  # m/s, half of the benchmark's
LONGEST_INTEGRAL = 10.0  # m s
STEP_S = 0.05
STEPS = 128  # of each vehicle in an iteration
ITERATIONS_MIN = 30  # fewer hardly change a policy
JUDGED, JUDGED_SEED = 64, 1_000_001  # vehicles that judge a policy, in water of their own
# Where the fields are in an observation: docs/training.md has the table.
ERROR, VELOCITY, YAW, YAW_RATE = slice(2, 4), slice(9, 11), 17, 20
FEATURES, ACTIONS = 8, 3  # the policy gives surge, sway [m/s] and yaw rate [rad/s]


class Steered(VecEnvWrapper):
    """The vehicles as the policy sees them, with surge, sway and yaw rate as actions."""

    def __init__(self, count: int, level_s: float, seed: int) -> None:
        times = {"level_duration_s": level_s, "settle_s": 0.25 * level_s}
        settings = {"tracker": "truth", "levels": LEVELS} | times
        vehicles = SeamarkVecEnv(
            num_envs=count, settings=settings, seed=seed, dtype="float64", normalise_actions=False
        )
        seen = gymnasium.spaces.Box(-np.inf, np.inf, (FEATURES,), np.float64)
        moved = gymnasium.spaces.Box(-1.0, 1.0, (ACTIONS,), np.float64)
        super().__init__(vehicles, seen, moved)
        self.integral = np.zeros((count, 2))

    def features(self, observations: np.ndarray, integral: np.ndarray) -> np.ndarray:
        """Return what the policy sees of each vehicle, (n, FEATURES)."""
        parts = observations[:, ERROR], integral, observations[:, VELOCITY]
        return np.concatenate([*parts, observations[:, [YAW, YAW_RATE]]], axis=1)

    def integrated(self, observations: np.ndarray) -> np.ndarray:
        """Add the errors to their integrals, and return the features."""
        self.integral += observations[:, ERROR] * observations[:, 1:2]
        np.clip(self.integral, -LONGEST_INTEGRAL, LONGEST_INTEGRAL, out=self.integral)
        return self.features(observations, self.integral)

    def reset(self) -> np.ndarray:
        """Begin the next level of each vehicle."""
        self.integral[:] = 0.0
        return self.integrated(self.venv.reset())

    def step_async(self, actions: np.ndarray) -> None:
        """Take surge, sway and yaw rate of each vehicle."""
        still = np.zeros(len(actions))
        wanted = np.insert(actions.astype(np.float64), 2, still, axis=1)
        limits = self.venv.action_space  # where the vehicle saturates a reference
        self.venv.step_async(np.clip(wanted, limits.low, limits.high))

    def step_wait(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[dict[str, Any]]]:
        """Simulate a control step; a vehicle whose level is over begins the next one."""
        observations, rewards, over, infos = self.venv.step_wait()
        for i in np.flatnonzero(over).tolist():
            last = infos[i]["terminal_observation"][None]
            infos[i]["terminal_observation"] = self.features(last, self.integral[i : i + 1])[0]
        self.integral[over] = 0.0
        return self.integrated(observations), rewards, over, infos


def new_model(vehicles: int, level_s: float) -> PPO:
    """Return PPO with a policy that has not been trained."""
    return PPO(
        "MlpPolicy",
        VecMonitor(Steered(vehicles, level_s, seed=1)),
        n_steps=STEPS,
        batch_size=vehicles * 16,
        n_epochs=5,
        learning_rate=1e-3,
        gamma=0.98,
        policy_kwargs={"net_arch": [32, 32], "log_std_init": -1.5},
        device="cpu",
        seed=0,
    )


def judged(model: PPO, level_s: float) -> float:
    """Return the mean reward of a step without exploring, in trials that no training meets.

    The first call also compiles the simulation, which takes minutes on some machines.
    """
    env = Steered(JUDGED, level_s, seed=JUDGED_SEED)
    seen, total, steps = env.reset(), 0.0, round(level_s / STEP_S)
    for _ in range(steps):
        actions, _ = model.predict(seen, deterministic=True)
        seen, rewards, _, _ = env.step(actions)
        total += float(np.mean(rewards))
    env.close()
    return total / steps


def train(model: PPO, seconds: float, level_s: float) -> list[tuple[float, float, float]]:
    """Return the learning curve: seconds, CPU seconds, mean reward of a step.

    An iteration in which no level ends has no reward; it is left out of the curve.
    """
    curve: list[tuple[float, float, float]] = []
    begin, done = time.monotonic(), 0
    while done < ITERATIONS_MIN or time.monotonic() - begin < seconds:
        model.learn(model.n_envs * STEPS, reset_num_timesteps=not done)
        done += 1
        passed = time.monotonic() - begin
        shown = "no level has ended yet"
        if returns := [episode["r"] for episode in model.ep_info_buffer]:
            reward = float(np.mean(returns)) * STEP_S / level_s
            curve.append((passed, time.process_time(), reward))
            shown = f"mean reward {reward:.3f}"
        print(f"{passed:5.0f} s  {model.num_timesteps} steps, {shown}")
    if done == ITERATIONS_MIN:
        print(
            f"Warning: the training took {ITERATIONS_MIN} iterations, the fewest that this example "
            f"makes; {seconds:g} s were not enough for more. Train longer, with --seconds."
        )
    return curve


def layers_of(model: PPO) -> list[tuple[list[list[float]], list[float]]]:
    """Return weights and biases of the policy's mean, layer after layer."""
    policy = model.policy
    linear = [layer for layer in policy.mlp_extractor.policy_net if hasattr(layer, "weight")]
    return [
        (layer.weight.detach().numpy().tolist(), layer.bias.detach().numpy().tolist())
        for layer in [*linear, policy.action_net]
    ]


def main() -> None:
    """Train, and write the controller and the learning curve."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "--seconds", type=float, default=240.0, help="of training, without compilation"
    )
    parser.add_argument("--vehicles", type=int, default=256)
    parser.add_argument("--level-s", type=float, default=30.0, help="simulated time of a level")
    parser.add_argument("--out", type=Path, default=Path("ppo_controller.py"))
    parser.add_argument("--curve", type=Path, help="file for the learning curve, JSON")
    chosen = parser.parse_args()
    model = new_model(chosen.vehicles, chosen.level_s)
    print("Compiling the simulation, and judging the policy before its training ...", flush=True)
    before = judged(model, chosen.level_s)
    curve = train(model, chosen.seconds, chosen.level_s)
    after = judged(model, chosen.level_s)
    model.env.close()
    print(f"Mean reward of a step: {before:.3f} before the training, {after:.3f} after it.")
    if chosen.curve:
        chosen.curve.write_text(json.dumps({"curve": curve}))
    if not after > before:
        sys.exit(f"The training made nothing better, so {chosen.out} is not written. Train longer.")
    chosen.out.write_text(CONTROLLER.format(layers=json.dumps(layers_of(model))))
    print(f"Wrote {chosen.out}. Evaluate and submit it:")
    print(f"  seamark run currents-v2 --controller {chosen.out} --trials 8")
    print(f"  seamark submit currents-v2 --controller {chosen.out} --ranked --wait")


if __name__ == "__main__":
    main()
