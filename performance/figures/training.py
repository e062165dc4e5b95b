"""Train both examples of docs/training.md and plot their learning curves.

Stable-Baselines3 is no dependency of the project. Where it is not installed, the curve of PPO in
the file `docs/training_curves.json` stays, which the plot is drawn from.
"""

import importlib.util
import json
import math
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from statistics import fmean
from tempfile import TemporaryDirectory
from typing import Any

from performance import DOCS, FIGURES, ROOT
from performance.plots import COLOURS, figure

CURVES = DOCS / "training_curves.json"
_NEEDS = {"train_station_keeping": "numpy", "train_ppo": "stable_baselines3"}
_LABELS = {  # of each curve of an example, with its colour
    "train_station_keeping": (
        ("cross-entropy method, 5 gains, NumPy alone", COLOURS[0]),
        ("the published PI in the same water", COLOURS[1]),
    ),
    "train_ppo": (("PPO of Stable-Baselines3, 1,443 weights", COLOURS[2]),),
}
_SMOOTH = 20  # iterations


def trained(example: str) -> list[list[float]]:
    """Return the learning curve of an example: see `points`."""
    with TemporaryDirectory() as folder:
        out, curve = Path(folder, "controller.py"), Path(folder, "curve.json")
        script = ROOT / "examples" / f"{example}.py"
        arguments = ["--out", str(out), "--curve", str(curve)]
        subprocess.run([sys.executable, str(script), *arguments], check=True)
        return points(json.loads(curve.read_text("utf-8")))


def points(result: dict[str, Any]) -> list[list[float]]:
    """Return CPU time [s], mean reward, and further ones, of each iteration of an example."""
    rows: list[list[float]] = result["curve"]
    return [[round(number, 4) for number in row[1:4]] for row in rows if not math.isnan(row[2])]


def smooth(rewards: Sequence[float]) -> list[float]:
    """Return the mean of each reward and those before it, at most `_SMOOTH` of them."""
    return [fmean(rewards[max(0, k - _SMOOTH) : k + 1]) for k in range(len(rewards))]


def draw(curves: dict[str, list[list[float]]]) -> None:
    """Write the figure."""
    with figure(FIGURES / "training.png", height=3.6) as axes:
        for example, labels in _LABELS.items():
            seconds, *rewards = zip(*curves[example], strict=True)
            minutes = [second / 60.0 for second in seconds]
            for values, (label, colour) in zip(rewards, labels, strict=False):
                axes.plot(minutes, smooth(values), label=label, color=colour, linewidth=1.2)
        axes.set_xlabel("CPU time of the training [min]")
        axes.set_ylabel("mean reward of a step")
        axes.set_ylim(bottom=0.0)
        axes.legend(loc="lower right")


def main(_arguments: Sequence[str]) -> int:
    """Train what can be trained here, and write the curves and the figure."""
    curves = json.loads(CURVES.read_text("utf-8")) if CURVES.exists() else {}
    for example, package in _NEEDS.items():
        if importlib.util.find_spec(package):
            curves[example] = trained(example)
    CURVES.write_text(json.dumps(curves) + "\n", "utf-8")
    draw(curves)
    return 0
