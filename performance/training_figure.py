"""`python -m performance.training_figure`: train both examples of docs/training.md and plot them.

Stable-Baselines3 is no dependency of the project. Where it is not installed, the curve of PPO in
the file `docs/training_curves.json` stays, which the plot is drawn from.
"""

import importlib.util
import json
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from performance.validation.plots import COLOURS, figure

ROOT = Path(__file__).resolve().parents[1]
CURVES = ROOT / "docs" / "training_curves.json"
_NEEDS = {"train_station_keeping": "numpy", "train_ppo": "stable_baselines3"}
_LABELS = {
    "train_station_keeping": "cross-entropy method, 5 gains, NumPy alone",
    "train_ppo": "PPO of Stable-Baselines3, 1,500 weights",
}


def trained(example: str) -> list[list[float]]:
    """Return the learning curve of an example: CPU time [s] and mean reward of a step."""
    with TemporaryDirectory() as folder:
        out, curve = Path(folder, "controller.py"), Path(folder, "curve.json")
        script = ROOT / "examples" / f"{example}.py"
        arguments = ["--out", str(out), "--curve", str(curve)]
        subprocess.run([sys.executable, str(script), *arguments], check=True)
        return points(json.loads(curve.read_text("utf-8")))


def points(result: dict[str, Any]) -> list[list[float]]:
    """Return CPU time [s] and mean reward of each iteration that an example wrote."""
    return [[round(row[1], 1), round(row[2], 4)] for row in result["curve"] if row[2] == row[2]]


def draw(curves: dict[str, list[list[float]]]) -> None:
    """Write the figure."""
    with figure(ROOT / "docs" / "figures" / "training.png", height=3.6) as axes:
        for (example, curve), colour in zip(curves.items(), COLOURS, strict=False):
            seconds, rewards = zip(*curve, strict=True)
            minutes = [second / 60.0 for second in seconds]
            axes.plot(minutes, rewards, label=_LABELS[example], color=colour, linewidth=1.2)
        axes.set_xlabel("CPU time of the training [min], on one or two cores")
        axes.set_ylabel("mean reward of a step")
        axes.set_ylim(bottom=0.0)
        axes.legend()


def main() -> None:
    """Train what can be trained here, and write the curves and the figure."""
    curves = json.loads(CURVES.read_text("utf-8")) if CURVES.exists() else {}
    for example, package in _NEEDS.items():
        if importlib.util.find_spec(package):
            curves[example] = trained(example)
    CURVES.write_text(json.dumps(curves) + "\n", "utf-8")
    draw(curves)


if __name__ == "__main__":
    main()
