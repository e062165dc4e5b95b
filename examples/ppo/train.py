"""Train a controller for currents-v2 with PPO of Stable-Baselines3 and pack it as ONNX.

    pip install "seamark[gym,box]" "stable-baselines3>=2.9" onnx
    python examples/ppo/train.py --out ppo.zip
    seamark run currents-v2 --controller ppo.zip --trials 8
    seamark submit currents-v2 --controller ppo.zip --ranked --wait

All vehicles are one vector environment with true corners, half of them of each kind. The policy
starts from nothing, and no law helps it: `features.py` has what it sees and what its actions mean.
The same seed gives the same policy where PyTorch adds in the same order, which depends on the
processor and the number of threads. In the end the archive runs in a sandbox and has to act as the
policy did in training.
"""

import argparse
import os
import sys
import time
from collections.abc import Callable
from pathlib import Path
from statistics import fmean
from typing import Any

os.environ.setdefault("OMP_WAIT_POLICY", "passive")  # else it is ten times slower on a busy machine

try:
    import torch
    from stable_baselines3 import PPO
    from stable_baselines3.common.callbacks import BaseCallback
    from stable_baselines3.common.vec_env import VecEnvWrapper
except ImportError as missing:
    sys.exit(
        'This example needs Stable-Baselines3: pip install "stable-baselines3>=2.9" onnx '
        f"(with PyTorch, of which the CPU version is enough). Python says: {missing}"
    )
import gymnasium
import numpy as np
from features import ACTIONS, FEATURES, PERIOD_S, STEPS, Features
from packing import Layer, boxed, pack

from seamark.gym.stable_baselines import SeamarkVecEnv

ENVIRONMENT = "seamark/StationKeeping-v2"
KINDS = ("girona500", "bluerov2-heavy")  # of vehicles, in even and in odd trials
VEHICLES = 256
ROLLOUT = 32  # actions of each vehicle in an iteration
BATCHES = 4  # of an iteration
ITERATIONS = 300  # a minute on two cores
LEVEL_S = 30.0  # half of the benchmark's: the start is where most is to be learned
HIDDEN = [64, 64]
RATES = (2e-3, 3e-4)  # of Adam, first and last
SEEDS_APART = 1000  # of the trials of two trainings, which have VEHICLES each
THREADS = 2
SHOWN_EVERY = 20  # iterations
CHECKED_SEED, CHECKED_S = 1_000_001, 60.0
TOLERANCE = 1e-4  # [m/s, rad/s]: float32, added in another order

Each = Callable[[PPO, int, float], None]


class Steered(VecEnvWrapper):
    """The vehicles as the policy sees and steers them: an action lasts STEPS control steps."""

    def __init__(self, count: int, level_s: float, *, seed: int, first_trial: int = 0) -> None:
        times = {"level_duration_s": level_s, "settle_s": 0.25 * level_s}
        vehicles = SeamarkVecEnv(
            ENVIRONMENT,
            num_envs=count,
            settings={"tracker": "truth"} | times,
            seed=seed,
            dtype="float64",
            normalise_actions=False,
        )
        trials = [(first_trial + i) % len(KINDS) for i in range(count)]
        vehicles.set_options([{"trial": trial} for trial in trials])
        seen = gymnasium.spaces.Box(-np.inf, np.inf, (FEATURES,), np.float32)
        moved = gymnasium.spaces.Box(-1.0, 1.0, (ACTIONS,), np.float32)
        super().__init__(vehicles, seen, moved)
        self.every = np.arange(count)
        self.features = Features(count)

    def reset(self) -> np.ndarray:
        """Begin a level of each vehicle."""
        self.features.forget(self.every)
        return self.features.see(self.venv.reset(), self.every)

    def step_async(self, actions: np.ndarray) -> None:
        """Take an action of each vehicle."""
        self.wanted = self.features.command(actions)

    def step_wait(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[dict[str, Any]]]:
        """Simulate; a vehicle whose level is over begins the next one."""
        total = np.zeros(self.num_envs, np.float32)
        for _ in range(STEPS):
            observations, rewards, over, infos = self.venv.step(self.wanted)
            total += rewards
        if over.any():
            ended = np.flatnonzero(over)
            last = np.array([infos[i]["terminal_observation"] for i in ended])
            for i, seen in zip(ended, self.features.see(last, ended), strict=True):
                infos[i]["terminal_observation"] = seen
            self.features.forget(ended)
        return self.features.see(observations, self.every), total / STEPS, over, infos


class AfterIterations(BaseCallback):
    """Calls a function before the first iteration and after each: see `train`."""

    def __init__(self, each: Each) -> None:
        super().__init__()
        self.each, self.done, self.rewards = each, 0, [0.0]

    def _on_step(self) -> bool:
        self.rewards.append(float(self.locals["rewards"].mean()))
        return True

    def _told(self) -> None:
        self.each(self.model, self.done, fmean(self.rewards))
        self.done, self.rewards = self.done + 1, []

    _on_rollout_start = _on_training_end = _told


def compiled() -> None:
    """Compile the simulation, which takes about a minute on some machines the first time."""
    env = Steered(len(KINDS), LEVEL_S, seed=CHECKED_SEED)
    env.reset()
    env.step(np.zeros((len(KINDS), ACTIONS)))
    env.close()


def new_model(seed: int) -> PPO:
    """Return PPO with a policy that has not been trained."""
    torch.set_num_threads(THREADS)
    model = PPO(
        "MlpPolicy",
        Steered(VEHICLES, LEVEL_S, seed=1 + SEEDS_APART * seed),
        n_steps=ROLLOUT,
        batch_size=VEHICLES * ROLLOUT // BATCHES,
        n_epochs=4,
        learning_rate=lambda left: RATES[1] + left * (RATES[0] - RATES[1]),
        gamma=0.98,
        policy_kwargs={"net_arch": HIDDEN, "log_std_init": -1.5},
        device="cpu",
        seed=seed,
    )
    with torch.no_grad():  # so that the first actions are small
        model.policy.action_net.weight *= 0.1
    return model


def train(model: PPO, iterations: int, each: Each) -> None:
    """Train, and call `each` with the model, the iterations done from 0 on, and their reward.

    The reward is the mean of the last iteration, whose actions explore.
    """
    model.learn(iterations * ROLLOUT * VEHICLES, callback=AfterIterations(each))
    model.env.close()


def layers_of(model: PPO) -> list[Layer]:
    """Return weights (inputs, outputs) and biases of the policy's mean, layer after layer."""
    policy = model.policy
    linear = [layer for layer in policy.mlp_extractor.policy_net if hasattr(layer, "weight")]
    return [
        (layer.weight.detach().numpy().T.copy(), layer.bias.detach().numpy().copy())
        for layer in [*linear, policy.action_net]
    ]


def checked(model: PPO, archive: Path) -> float:
    """Return by how much the archive in its box differs from the policy in training [m/s, rad/s].

    The archive steers each kind of vehicle through a level that no training meets, and at each step
    the policy says what it would have done. It remembers what was done: by itself, the memory of
    commands would make a difference of rounding grow.
    """
    difference, alone = 0.0, np.arange(1)
    for trial, kind in enumerate(KINDS):
        env = Steered(1, CHECKED_S, seed=CHECKED_SEED, first_trial=trial)
        features, observations = Features(1), env.venv.reset()
        with boxed(archive, kind) as answer:
            for _ in range(round(CHECKED_S / PERIOD_S)):
                actions, _ = model.predict(features.see(observations, alone), deterministic=True)
                wanted = features.command(actions)
                for _ in range(STEPS):
                    done = answer(observations[0])[None]
                    difference = max(difference, float(np.abs(done - wanted).max()))
                    observations, *_ = env.venv.step(done)
                features.commands = done[:, [0, 1, 3]]
        env.close()
    return difference


def main() -> None:
    """Train, pack and check."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--iterations", type=int, default=ITERATIONS)
    parser.add_argument("--seed", type=int, default=0, help="Of the training.")
    parser.add_argument("--out", type=Path, default=Path("ppo.zip"))
    chosen = parser.parse_args()
    print("Compiling the simulation ...", flush=True)
    compiled()
    begin = time.monotonic()

    def shown(model: PPO, done: int, reward: float) -> None:
        if done and done % SHOWN_EVERY == 0:
            passed = time.monotonic() - begin
            print(f"{passed:5.0f} s  {model.num_timesteps} actions, mean reward {reward:.3f}")

    model = new_model(chosen.seed)
    train(model, chosen.iterations, shown)
    pack(layers_of(model), chosen.out)
    if (difference := checked(model, chosen.out)) > TOLERANCE:
        sys.exit(f"{chosen.out} acts otherwise in its box than in training, by {difference:g} m/s.")
    print(f"Wrote {chosen.out}. In its box it acts as in training, to {difference:.1g} m/s.")
    print("Evaluate and submit it:")
    print(f"  seamark run currents-v2 --controller {chosen.out} --trials 8")
    print(f"  seamark submit currents-v2 --controller {chosen.out} --ranked --wait")


if __name__ == "__main__":
    main()
