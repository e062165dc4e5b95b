"""Run the programs of docs/tutorial.md and plot them; write the table into the page."""

import csv
import json
import re
from collections.abc import Sequence
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

from performance import DOCS, FIGURES
from performance.plots import COLOURS, figure
from performance.tables import markdown_table
from seamark.cli.main import cli

PAGE = DOCS / "tutorial.md"
BENCHMARK, SEED = "currents-v1", 2026
SETTINGS = ("--set", "levels=0.2,0.4", "--set", "level_duration_s=60")  # as on the page
HEAD = ("program", "points of 100", "distance from the station, RMS [m]")
_PROGRAM = re.compile(r"^## Step \d: (.+?)\n.*?^```python\n(.*?)^```$", re.MULTILINE | re.DOTALL)
_TABLE = re.compile(r"(<!-- tutorial:begin -->\n).*?(<!-- tutorial:end -->)", re.DOTALL)


class Run(NamedTuple):
    """One trial of a program, through its levels."""

    t: list[float]  # s
    distance: list[float]  # m, of the camera from its station
    score: float
    rmse_m: float


def programs() -> dict[str, str]:
    """Return title -> source of the programs of the tutorial."""
    return dict(_PROGRAM.findall(PAGE.read_text(encoding="utf-8")))


def run(source: str, *options: str) -> Run:
    """Run a program as a reader does: on the command line, in the sandbox."""
    with TemporaryDirectory() as folder:
        program, out = Path(folder, "controller.py"), Path(folder, "result")
        program.write_text(source, encoding="utf-8")
        arguments = ["run", BENCHMARK, "--controller", str(program), "--seed", str(SEED)]
        command = [*arguments, "--out", str(out), *options]
        with redirect_stdout(StringIO()):
            if code := cli.main(command, "seamark", standalone_mode=False):
                raise RuntimeError(f"`seamark {' '.join(command)}` ended with exit code {code}")
        metrics = json.loads((out / "metrics.json").read_text(encoding="utf-8"))
        with (out / "telemetry.csv").open(encoding="utf-8") as file:
            rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    return Run(
        [float(row["t"]) for row in rows],
        [float(row["distance"]) for row in rows],
        metrics["score"],
        metrics["overall"]["rmse_m"],
    )


def main(_arguments: Sequence[str]) -> int:
    """Write the figure, and the table into the page."""
    runs = {title: run(source, *SETTINGS) for title, source in programs().items()}
    with figure(FIGURES / "tutorial.png", height=3.6) as axes:
        for (title, one), colour in zip(runs.items(), COLOURS, strict=False):
            axes.plot(one.t, one.distance, label=title, color=colour, linewidth=1.0)
        axes.set_xlabel("time [s]; current of 0.2 m/s, from 60 s on 0.4 m/s")
        axes.set_ylabel("distance from the station [m]")
        axes.legend()
    rows = ((title, f"{one.score:.1f}", f"{one.rmse_m:.3f}") for title, one in runs.items())
    text = PAGE.read_text(encoding="utf-8")
    shown = markdown_table(HEAD, rows)
    print(shown)
    PAGE.write_text(_TABLE.sub(lambda match: f"{match[1]}{shown}\n{match[2]}", text), "utf-8")
    return 0
