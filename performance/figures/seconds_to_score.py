"""Seconds of training until PPO beats the published PI and LQG in currents-v2, over five seeds.

A policy beats an entry if it scores more in fresh water: in trials that no training meets, with the
benchmark's own tracker and the policy's archive in its sandbox, all by `seamark run`. To find the
first such policy, those along the training are first judged by their mean rewards on the same
trials with true corners, without a camera. Seconds are those of the training alone: the simulation
is compiled, and nothing is judged in them. It needs Stable-Baselines3.

`--drawn` trains nothing: it draws the figure and writes the table anew.
"""

import json
import math
import re
import runpy
import statistics
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import gymnasium
import numpy as np
from numpy.typing import NDArray

import seamark.gym  # noqa: F401  # registers the environments
from performance import DOCS, FIGURES, ROOT
from performance.plots import COLOURS, figure
from performance.tables import markdown_table
from seamark.sim import registry
from seamark.sim.benchmarks.level_area import area_over_current

RESULTS = DOCS / "seconds_to_score.json"
PAGE = DOCS / "training.md"
EXAMPLE = ROOT / "examples" / "ppo"
BENCHMARK, ENVIRONMENT = "currents-v2", "seamark/StationKeeping-v2"
ENTRIES = {"pi": "the published PI", "lqr": "LQG"}
SEEDS = range(5)
JUDGED = {"seed": 90001, "trials": 24}  # as many trials as a ranked run has fresh ones
# After so many iterations a policy is judged: every fifth at first, when it learns fast.
JUDGED_AFTER = frozenset({*range(5, 100, 5), *range(100, 10_000, 20)})
HEAD = ("until", "seconds on two cores: median", "range", "CPU seconds: median", "range")
_TABLE = re.compile(r"(<!-- seconds:begin -->\n).*?(<!-- seconds:end -->)", re.DOTALL)

Array = NDArray[Any]
Layers = list[tuple[Array, Array]]
Run = dict[str, Any]  # of a seed: "curve", when it has "beaten" which entry, and "score" at the end


class Snapshot(NamedTuple):
    """The policy along a training."""

    seconds: float
    cpu_seconds: float
    layers: Layers


class FreshWater:
    """All levels of all judged trials at once, with true corners."""

    def __init__(self, features: Any) -> None:
        config: Any = registry.benchmark(BENCHMARK).read({})
        self._speeds = config.levels
        self._places = [(t, k) for t in range(JUDGED["trials"]) for k in range(len(self._speeds))]
        self._steps = round(config.level_duration_s / config.control_period_s)
        self._features = features
        self._envs = gymnasium.make_vec(
            ENVIRONMENT,
            num_envs=len(self._places),
            settings={"tracker": "truth"},
            autoreset_mode="Disabled",
        )

    def score(self, layers: Layers) -> float:
        """Return about what a policy scores: by mean rewards instead of qualities [m/s]."""
        count = len(self._places)
        for i, (trial, level) in enumerate(self._places):
            options = {"trial": trial, "level": level, "reset_mask": np.arange(count) == i}
            observations, _ = self._envs.reset(seed=JUDGED["seed"], options=options)
        features, rewards = self._features["Features"](count), np.zeros(count)
        for step in range(self._steps):
            if step % self._features["STEPS"] == 0:
                x = features.see(observations, np.arange(count))
                for weights, biases in layers[:-1]:
                    x = np.tanh(x @ weights + biases)
                commands = features.command(x @ layers[-1][0] + layers[-1][1])
            observations, reward, *_ = self._envs.step(commands)
            rewards += reward
        levels = [
            {"speed": self._speeds[level], "quality": quality}
            for (_, level), quality in zip(self._places, rewards / self._steps, strict=True)
        ]
        return area_over_current(levels, "quality")


def held(controller: str) -> float:
    """Return the score [m/s] of a built-in controller or of a program, by `seamark run`."""
    options = ["--controller", controller, "--json"]
    options += [word for name, value in JUDGED.items() for word in (f"--{name}", str(value))]
    command = [sys.executable, "-m", "seamark.cli.main", "run", BENCHMARK, *options]
    with TemporaryDirectory() as folder:
        command += ["--out", str(Path(folder, "result"))]
        done = subprocess.run(command, check=True, capture_output=True, text=True)
    return float(json.loads(done.stdout)["metrics"]["score"])


def snapshots(example: dict[str, Any], seed: int) -> list[Snapshot]:
    """Train, and return the policies along it, the last one at the end."""
    model, taken = example["new_model"](seed), []
    begin, begin_cpu = time.monotonic(), time.process_time()

    def take(_model: Any, done: int, _reward: float) -> None:
        if done in JUDGED_AFTER or done == example["ITERATIONS"]:
            passed = time.monotonic() - begin, time.process_time() - begin_cpu
            taken.append(Snapshot(*passed, example["layers_of"](model)))

    example["train"](model, example["ITERATIONS"], take)
    return taken


def measured(example: dict[str, Any], water: FreshWater, seed: int, entries: Run) -> Run:
    """Train with a seed; return its curve and when it has beaten each entry.

    Policies that beat an entry with true corners are tried in the benchmark as it is, from the
    first one on, until one beats it there. If one does not, the next one that is tried has more
    than that one has lost.
    """
    taken = snapshots(example, seed)
    curve = [water.score(each.layers) for each in taken]
    with TemporaryDirectory() as folder:
        archive = Path(folder, "ppo.zip")

        def boxed(number: int) -> float:
            example["pack"](taken[number].layers, archive)
            return held(str(archive))

        beaten: dict[str, Any] = {}
        for name, score in entries.items():
            beaten[name], lost = None, 0.0
            for number, value in enumerate(curve):
                if value <= score + lost:
                    continue
                own = boxed(number)
                print(f"seed {seed}: {value:.3f} with true corners, {own:.3f} in full", flush=True)
                if own > score:
                    passed = taken[number]
                    beaten[name] = [round(passed.seconds, 2), round(passed.cpu_seconds, 2), own]
                    break
                lost = value - own
        last = boxed(len(taken) - 1)
    points = [
        [round(each.seconds, 2), round(each.cpu_seconds, 2), round(value, 4)]
        for each, value in zip(taken, curve, strict=True)
    ]
    return {"seed": seed, "curve": points, "beaten": beaten, "score": last}


def _spread(values: Sequence[float], digits: int = 1) -> tuple[str, str]:
    """Return median and range as they are printed; infinite is never."""

    def shown(value: float) -> str:
        return f"{value:.{digits}f}" if math.isfinite(value) else "never"

    return shown(statistics.median(values)), f"{shown(min(values))} to {shown(max(values))}"


def table(results: dict[str, Any]) -> str:
    """Return the table of the page."""
    runs, rows = results["runs"], []
    for name, label in ENTRIES.items():
        times = [run["beaten"][name] or [math.inf, math.inf] for run in runs]
        wall, cpu = ([each[k] for each in times] for k in range(2))
        what = f"it beats {label} ({results['entries'][name]:.3f} m/s)"
        rows.append((what, *_spread(wall), *_spread(cpu)))
    ends = [run["curve"][-1] for run in runs]
    score = "{} m/s ({})".format(*_spread([run["score"] for run in runs], digits=3))
    wall, cpu = ([each[k] for each in ends] for k in range(2))
    rows.append((f"the end, when it holds {score}", *_spread(wall), *_spread(cpu)))
    return markdown_table(HEAD, rows)


def draw(results: dict[str, Any]) -> None:
    """Write the figure."""
    with figure(FIGURES / "seconds-to-score.png", height=3.6) as axes:
        for run in results["runs"]:
            seconds, _, scores = zip(*run["curve"], strict=True)
            label = "PPO, true corners, five seeds" if run is results["runs"][0] else None
            axes.plot(seconds, scores, label=label, color=COLOURS[2], linewidth=0.9)
        for (name, label), colour in zip(ENTRIES.items(), COLOURS, strict=False):
            score = results["entries"][name]
            axes.axhline(score, label=label, color=colour, linewidth=1.2)
            beaten = [run["beaten"][name][0] for run in results["runs"] if run["beaten"][name]]
            axes.plot(beaten, [score] * len(beaten), "o", color=colour, markersize=4)
        axes.set_xlabel("seconds of training on two cores; dots: beaten, with the tracker")
        axes.set_ylabel("current held [m/s]")
        axes.set_ylim(bottom=0.0)
        axes.legend(loc="center right")


def main(arguments: Sequence[str]) -> int:
    """Train and measure, unless the results are only drawn anew; write figure and table."""
    if "--drawn" not in arguments:
        sys.path.insert(0, str(EXAMPLE))  # the example's files import each other
        example = runpy.run_path(str(EXAMPLE / "train.py"))
        example["compiled"]()
        entries = {name: held(name) for name in ENTRIES}
        print(f"entries {entries}", flush=True)
        water = FreshWater(runpy.run_path(str(EXAMPLE / "features.py")))
        results: dict[str, Any] = {**JUDGED, "entries": entries, "runs": []}
        for seed in SEEDS:
            results["runs"].append(measured(example, water, seed, entries))
            run = results["runs"][-1]
            print(f"seed {seed} beaten {run['beaten']} score {run['score']:.3f}", flush=True)
        lines = ",\n".join(f"  {json.dumps(run)}" for run in results.pop("runs"))
        head = json.dumps(results)[:-1]
        RESULTS.write_text(f'{head},\n "runs": [\n{lines}\n ]}}\n', "utf-8")
    results = json.loads(RESULTS.read_text("utf-8"))
    draw(results)
    shown = table(results)
    print(shown)
    text = PAGE.read_text("utf-8")
    PAGE.write_text(_TABLE.sub(lambda match: f"{match[1]}{shown}\n{match[2]}", text), "utf-8")
    return 0
