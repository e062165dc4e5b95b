"""Train a controller for currents-v2 with PPO of Stable-Baselines3.

    pip install "seamark[gym]" "stable-baselines3>=2.9"
    python examples/train_ppo.py

All vehicles are one vector environment with true corners. The policy sees error, its integral,
velocity, heading and yaw rate, and a tanh network of two layers gives the velocity reference. What
is written is a controller in NumPy alone: it runs and is submitted without Stable-Baselines3.
"""

import argparse
import json
import sys
import time
from pathlib import Path
from typing import Any

try:
    from stable_baselines3 import PPO
    from stable_baselines3.common.vec_env import VecEnv, VecMonitor
except ImportError as missing:
    sys.exit(
        'This example needs Stable-Baselines3: pip install "stable-baselines3>=2.9" '
        f"(with PyTorch, of which the CPU version is enough). Python says: {missing}"
    )
import gymnasium
import numpy as np

import seamark.gym  # noqa: F401  # registers the environments

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
# Where the fields are in an observation: docs/training.md has the table.
ERROR, VELOCITY, YAW, YAW_RATE = slice(2, 4), slice(9, 11), 17, 20
FEATURES, ACTIONS = 8, 3  # the policy gives surge, sway [m/s] and yaw rate [rad/s]


class Vehicles(VecEnv):
    """The vector environment in the form that Stable-Baselines3 trains with."""

    def __init__(self, count: int, level_s: float, seed: int) -> None:
        self.env: Any = gymnasium.make_vec(
            "seamark/StationKeeping-v2",
            num_envs=count,
            settings={
                "tracker": "truth",
                "levels": LEVELS,
                "level_duration_s": level_s,
                "settle_s": 0.25 * level_s,
            },
            autoreset_mode="SameStep",
        )
        seen = gymnasium.spaces.Box(-np.inf, np.inf, (FEATURES,), np.float64)
        super().__init__(count, seen, gymnasium.spaces.Box(-1.0, 1.0, (ACTIONS,), np.float64))
        self.first_seed = seed
        self.integral = np.zeros((count, 2))

    def features(self, observations: np.ndarray) -> np.ndarray:
        """Return what the policy sees of each vehicle, (n, FEATURES)."""
        parts = observations[:, ERROR], self.integral, observations[:, VELOCITY]
        return np.concatenate([*parts, observations[:, [YAW, YAW_RATE]]], axis=1)

    def reset(self) -> np.ndarray:
        """Begin with the first level of each vehicle's run."""
        self.integral[:] = 0.0
        observations, _ = self.env.reset(seed=self.first_seed)
        return self.integrated(observations)

    def integrated(self, observations: np.ndarray) -> np.ndarray:
        """Add the errors to their integrals, and return the features."""
        self.integral += observations[:, ERROR] * observations[:, 1:2]
        np.clip(self.integral, -LONGEST_INTEGRAL, LONGEST_INTEGRAL, out=self.integral)
        return self.features(observations)

    def step_async(self, actions: np.ndarray) -> None:
        """Keep the actions."""
        surge, sway, turn = actions.T
        self.actions = np.stack([surge, sway, np.zeros(self.num_envs), turn], axis=1)

    def step_wait(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[dict[str, Any]]]:
        """Simulate a control step; a vehicle whose level is over begins the next one."""
        observations, rewards, terminated, truncated, info = self.env.step(self.actions)
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        over = terminated | truncated
        for i in np.flatnonzero(over).tolist():
            last = info["final_obs"][i][None]
            ended = np.concatenate([last[0, ERROR], self.integral[i], last[0, VELOCITY]])
            infos[i]["terminal_observation"] = np.concatenate([ended, last[0, [YAW, YAW_RATE]]])
            infos[i]["TimeLimit.truncated"] = bool(truncated[i])
        self.integral[over] = 0.0
        return self.integrated(observations), rewards, over, infos

    def close(self) -> None:
        """Release the vehicles."""
        self.env.close()

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """Return an attribute of each vehicle: they have only `render_mode`, which is None."""
        return [getattr(self.env, attr_name, None)] * self.num_envs

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Refuse: the vehicles are rows of arrays."""
        raise NotImplementedError

    def env_method(self, method_name: str, *args: Any, indices: Any = None, **kwargs: Any) -> Any:
        """Refuse: the vehicles are rows of arrays."""
        raise NotImplementedError

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> list[bool]:
        """Return that no vehicle has a wrapper of its own."""
        return [False] * self.num_envs


def train(chosen: argparse.Namespace) -> tuple[PPO, list[tuple[float, float, float]]]:
    """Return the model and the learning curve: seconds, CPU seconds, mean reward of a step."""
    env = VecMonitor(Vehicles(chosen.vehicles, chosen.level_s, seed=1))
    model = PPO(
        "MlpPolicy",
        env,
        n_steps=128,
        batch_size=chosen.vehicles * 16,
        n_epochs=5,
        learning_rate=1e-3,
        gamma=0.98,
        policy_kwargs={"net_arch": [32, 32], "log_std_init": -1.5},
        device="cpu",
        seed=0,
    )
    curve: list[tuple[float, float, float]] = []
    begin, steps_per_level = time.monotonic(), round(chosen.level_s / 0.05)
    while not curve or curve[-1][0] < chosen.seconds:
        model.learn(chosen.vehicles * 128, reset_num_timesteps=not curve)
        returns = [episode["r"] for episode in model.ep_info_buffer]
        reward = float(np.mean(returns)) / steps_per_level if returns else float("nan")
        curve.append((time.monotonic() - begin, time.process_time(), reward))
        print(f"{curve[-1][0]:5.0f} s  {model.num_timesteps} steps, mean reward {reward:.3f}")
    env.close()
    return model, curve


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
    parser.add_argument("--seconds", type=float, default=240.0)
    parser.add_argument("--vehicles", type=int, default=256)
    parser.add_argument("--level-s", type=float, default=30.0, help="simulated time of a level")
    parser.add_argument("--out", type=Path, default=Path("ppo_controller.py"))
    parser.add_argument("--curve", type=Path, help="file for the learning curve, JSON")
    chosen = parser.parse_args()
    model, curve = train(chosen)
    chosen.out.write_text(CONTROLLER.format(layers=json.dumps(layers_of(model))))
    if chosen.curve:
        chosen.curve.write_text(json.dumps({"curve": curve}))
    print(f"Wrote {chosen.out}. Evaluate and submit it:")
    print(f"  seamark run currents-v2 --controller {chosen.out} --trials 8")
    print(f"  seamark submit currents-v2 --controller {chosen.out} --ranked --wait")


if __name__ == "__main__":
    main()
