"""Train the example of docs/training.md that needs NumPy alone, and plot its learning curve."""

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

CURVE = DOCS / "training_curves.json"
_LABELS = (
    ("cross-entropy method, 5 gains, NumPy alone", COLOURS[0]),
    ("the published PI in the same water", COLOURS[1]),
)
_SMOOTH = 20  # iterations


def trained() -> list[list[float]]:
    """Return the learning curve: see `points`."""
    with TemporaryDirectory() as folder:
        out, curve = Path(folder, "controller.py"), Path(folder, "curve.json")
        script = ROOT / "examples" / "train_station_keeping.py"
        arguments = ["--out", str(out), "--curve", str(curve)]
        subprocess.run([sys.executable, str(script), *arguments], check=True)
        return points(json.loads(curve.read_text("utf-8")))


def points(result: dict[str, Any]) -> list[list[float]]:
    """Return CPU time [s], mean reward, and that of the PI, of each iteration."""
    rows: list[list[float]] = result["curve"]
    return [[round(number, 4) for number in row[1:4]] for row in rows if not math.isnan(row[2])]


def smooth(rewards: Sequence[float]) -> list[float]:
    """Return the mean of each reward and those before it, at most `_SMOOTH` of them."""
    return [fmean(rewards[max(0, k - _SMOOTH) : k + 1]) for k in range(len(rewards))]


def draw(curve: list[list[float]]) -> None:
    """Write the figure."""
    with figure(FIGURES / "training.png", height=3.6) as axes:
        seconds, *rewards = zip(*curve, strict=True)
        minutes = [second / 60.0 for second in seconds]
        for values, (label, colour) in zip(rewards, _LABELS, strict=True):
            axes.plot(minutes, smooth(values), label=label, color=colour, linewidth=1.2)
        axes.set_xlabel("CPU time of the training [min]")
        axes.set_ylabel("mean reward of a step")
        axes.set_ylim(bottom=0.0)
        axes.legend(loc="lower right")


def main(_arguments: Sequence[str]) -> int:
    """Train, and write the curve and the figure."""
    curve = trained()
    CURVE.write_text(json.dumps({"train_station_keeping": curve}) + "\n", "utf-8")
    draw(curve)
    return 0
