"""Train a controller for currents-v2 with NumPy alone, within five minutes on two cores.

    python examples/train_station_keeping.py

The policy is linear: its features are error, integral of the error and velocity of each axis, and
the heading. The cross-entropy method draws candidates, all of which run the same levels, and moves
towards the best of them. Training uses true corners, so that no image is rendered;
`seamark run` then evaluates with the benchmark's camera and tracker.
"""

import argparse
import json
import time
from pathlib import Path

import gymnasium
import numpy as np

import seamark.gym  # noqa: F401  # registers the environments

HERE = Path(__file__).parent
STARTS = {  # gain -> mean and standard deviation from which the search starts
    "kp": (0.5, 0.3),  # 1/s, surge and sway per metre of error
    "ki": (0.02, 0.1),  # 1/s², per metre and second
    "kd": (0.0, 0.3),  # 1, per m/s over ground
    "kp_yaw": (0.0, 0.5),  # 1/s, yaw rate per radian off north
    "kd_yaw": (0.0, 0.3),  # 1, per rad/s
}
LEVELS = [0.1, 0.3, 0.5, 0.8]  # m/s, half of the benchmark's
LONGEST_INTEGRAL = 10.0  # m s
# Where the fields are in an observation: docs/training.md has the table.
ERROR, VELOCITY, YAW, YAW_RATE = slice(2, 4), slice(9, 11), 17, 20


class Policy:
    """One set of gains per vehicle, (n, gains)."""

    def __init__(self, gains: np.ndarray, dt: float) -> None:
        self.gains, self.dt = np.abs(gains), dt
        self.integral = np.zeros((len(gains), 2))

    def act(self, observations: np.ndarray) -> np.ndarray:
        """Return the actions, (n, 4), for the observations, (n, size)."""
        kp, ki, kd, kp_yaw, kd_yaw = self.gains.T[..., None]
        error = observations[:, ERROR]
        self.integral += error * self.dt
        np.clip(self.integral, -LONGEST_INTEGRAL, LONGEST_INTEGRAL, out=self.integral)
        actions = np.zeros((len(observations), 4))
        actions[:, :2] = kp * error + ki * self.integral - kd * observations[:, VELOCITY]
        yaw, rate = observations[:, YAW, None], observations[:, YAW_RATE, None]
        actions[:, 3:] = -kp_yaw * yaw - kd_yaw * rate
        return actions


def returns(env: gymnasium.vector.VectorEnv, gains: np.ndarray, seed: int) -> np.ndarray:
    """Return the mean reward of each candidate, (candidates,), over the same levels.

    Every candidate runs each level with each of the two vehicles once; the n-th of them has the
    same seed, trial and level for all candidates.
    """
    candidates, levels = len(gains), env.num_envs // (2 * len(gains))
    observations = None
    for trial in range(2):  # even trials have the one vehicle, odd ones the other
        for level in range(levels):
            mask = np.zeros((candidates, 2, levels), bool)
            mask[:, trial, level] = True
            observations, _ = env.reset(
                seed=[seed] * env.num_envs,
                options={"trial": trial, "level": level, "reset_mask": mask.ravel()},
            )
    policy = Policy(np.repeat(gains, 2 * levels, axis=0), dt=0.05)
    total, steps, over = np.zeros(env.num_envs), 0, False
    while not over:
        observations, rewards, _, truncated, _ = env.step(policy.act(observations))
        total += rewards
        steps += 1
        over = truncated.any()
    return (total / steps).reshape(candidates, -1).mean(axis=1)


def train(seconds: float, *, candidates: int, elite: int, settings: dict[str, object]) -> dict:
    """Return the best gains and the learning curve."""
    random = np.random.default_rng(0)
    start, spread = np.array(list(STARTS.values())).T
    mean = start
    levels = len(settings["levels"])
    env = gymnasium.make_vec(
        "seamark/StationKeeping-v2",
        num_envs=candidates * 2 * levels,
        settings={"tracker": "truth", **settings},
        autoreset_mode="Disabled",
    )
    curve, begin, iteration = [], time.monotonic(), 0
    while not curve or curve[-1][0] < seconds:
        drawn = mean + spread * random.standard_normal((candidates, len(mean)))
        drawn[0] = mean  # the candidate that would be the result
        drawn[1] = start  # the published PI, to compare with on the same levels
        scores = returns(env, drawn, seed=iteration)
        best = drawn[np.argsort(scores)[-elite:]]
        mean, spread = np.abs(best).mean(axis=0), 0.8 * best.std(axis=0) + 0.2 * spread
        seconds_so_far = time.monotonic() - begin
        rewards = tuple(map(float, (scores[0], scores[1], scores.max())))
        curve.append((seconds_so_far, time.process_time(), *rewards))
        print("{:5.0f} s  mean reward {:.3f}, PI {:.3f}".format(seconds_so_far, *rewards))
        iteration += 1
    env.close()
    gains = dict(zip(STARTS, np.abs(mean).round(4).tolist(), strict=True))
    return {"gains": gains, "curve": curve}


def main() -> None:
    """Train, and write the controller and the learning curve."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=240.0)
    parser.add_argument("--candidates", type=int, default=16)
    parser.add_argument("--out", type=Path, default=Path("trained_controller.py"))
    parser.add_argument("--curve", type=Path, help="file for the learning curve, JSON")
    parser.add_argument("--level-s", type=float, default=30.0, help="simulated time of a level")
    chosen = parser.parse_args()
    settings = {
        "levels": LEVELS,
        "level_duration_s": chosen.level_s,
        "settle_s": 0.25 * chosen.level_s,
    }
    elite = max(2, chosen.candidates // 4)
    result = train(chosen.seconds, candidates=chosen.candidates, elite=elite, settings=settings)
    template = (HERE / "linear_controller.py").read_text()
    line = next(line for line in template.splitlines() if line.startswith("GAINS = "))
    chosen.out.write_text(template.replace(line, f"GAINS = {json.dumps(result['gains'])}"))
    if chosen.curve:
        chosen.curve.write_text(json.dumps(result))
    print(f"Wrote {chosen.out}. Evaluate and submit it:")
    print(f"  seamark run currents-v2 --controller {chosen.out} --trials 8")
    print(f"  seamark submit currents-v2 --controller {chosen.out} --ranked --wait")


if __name__ == "__main__":
    main()
