"""Measure the entries of visibility-v2 and write their table and figures.

    ./run performance visibility_headroom [ENTRY ...]

Every named entry (all of them without a name) runs the reference trials, and 24 trials in water of
other seeds, the same for all. From docs/headroom.json it prints the table of docs/benchmarks.md and
how far the order depends on the trials, and redraws the figures visibility-v2-headroom.png,
-difficulty.png and -textures.png. It takes about twenty seconds per entry on two idle cores, for
KCF and ECC some minutes.
"""

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from performance import FIGURES
from performance.plots import figure
from performance.statistics.headroom.marks import (
    REFERENCE_TRIALS,
    Job,
    Measured,
    draw_headroom,
    jobs,
    mark_steps,
    measure_and_store,
    number,
    ordered,
    reference_seed,
    rounded,
    score_cells,
    stability,
)
from performance.statistics.opencv_mosse import OpenCvMosse
from performance.statistics.visibility_attacks import Path as CornerPath
from performance.statistics.visibility_attacks import Playback, Remembering, stored_paths
from performance.tables import markdown_table
from seamark.sim.engine.summary import summarise
from seamark.sim.engine.trial import TrialResult, run_trial
from seamark.sim.engine.warm_up import warm_up
from seamark.sim.recording.telemetry import INDEX, Rows
from seamark.sim.registry import benchmark
from seamark.sim.trackers import declaration, make

NAME = "visibility-v2"
AXES = {"turbidity": "optical depth", "motion": "px per image", "jump": "jump [px]"}
COLUMNS = (
    *("tau_midpoint", "motion_held_px", "basin_px"),
    *("admitted_loss_percent", "false_loss_percent", "unreported_loss_percent"),
)
DISHONEST = ("playback", "remembers")
SHOWN_DEPTHS = (0.0, 2.0, 4.0)
DRAWN = (
    *("nothing", "blind", "ssd-homography", "box", "kcf", "ecc", "klt", "zncc-homography"),
    *("mosse", "median-flow", "oracle"),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Entry:
    """A solution: its title, settings, and what makes it if it is not the built-in tracker."""

    title: str
    config: dict[str, object]
    make: Callable[[Any], Any]  # configuration -> solution


def _reference(name: str) -> Callable[[Any], Any]:
    return lambda config: benchmark(NAME).load().built_in(name, config)


def _remembering(config: Any) -> Remembering:
    return Remembering(make(config.tracker, truth=None, **config.tracker_options()))


@cache  # once per process
def _reference_paths() -> dict[bytes, CornerPath]:
    return stored_paths(NAME, seed=reference_seed(NAME), trials=REFERENCE_TRIALS)


def _playback(_config: Any) -> Playback:
    return Playback(_reference_paths())


def entries() -> dict[str, Entry]:
    """Return the marks of the leaderboard, and what else is compared with them, by short names."""
    by_name = {
        name: Entry(title=mark.title, config=dict(mark.config), make=_reference(mark.built_in))
        for name, mark in benchmark(NAME).baselines.items()
    }
    built_in = _reference("built-in")
    by_name["playback"] = Entry(title="Playback of the reference trials", config={}, make=_playback)
    by_name["remembers"] = Entry(
        title="ZNCC, homography, remembers the path", config={}, make=_remembering
    )
    by_name["kcf"] = Entry(title="KCF", config={"tracker": "kcf"}, make=built_in)
    by_name["ssd-homography"] = Entry(
        title="Template tracker, SSD, homography", config={"criterion": "ssd"}, make=built_in
    )
    by_name["mi-srt"] = Entry(
        title="Template tracker, MI, SRT", config={"criterion": "mi", "warp": "srt"}, make=built_in
    )
    by_name["median-flow"] = Entry(
        title="Median flow", config={"tracker": "median-flow"}, make=built_in
    )
    by_name["mosse-opencv"] = Entry(
        title="MOSSE, OpenCV", config={}, make=lambda _config: OpenCvMosse()
    )
    if not declaration("visp").unavailable():
        by_name["visp"] = Entry(
            title="ViSP, ZNCC, homography", config={"tracker": "visp"}, make=built_in
        )
    return by_name


def measure(name: str, processes: int) -> Measured:
    """Run an entry on the reference trials and on others; results do not depend on `processes`."""
    entry = entries()[name]
    with get_context("spawn").Pool(processes, initializer=warm_up) as pool:
        results = pool.map(_run, jobs(NAME, name), chunksize=1)
    config = benchmark(NAME).read(entry.config)
    other_metrics = summarise(NAME, config, results[REFERENCE_TRIALS:])
    return Measured(
        title=entry.title,
        scores=[round(result.score, 6) for result in results],
        overall={name: rounded(other_metrics["overall"][name]) for name in COLUMNS},
        success={
            axis: [
                (level["value"], round(level[_success(axis)], 3))
                for level in other_metrics["levels"]
                if level["axis"] == axis
            ]
            for axis in AXES
        },
    )


def _success(axis: str) -> str:
    """Return the metric that counts as success on an axis."""
    return "p1_percent" if axis == "jump" else "p5_percent"


def _run(job: Job) -> TrialResult:
    entry = entries()[job.entry]
    config = benchmark(NAME).read(entry.config)
    solution = entry.make(config)
    return run_trial(
        NAME, config, solution, seed=job.seed, trial=job.trial, on_rows=lambda _rows: None
    )


def report(results: dict[str, Measured]) -> str:
    """Return the table, lowest score first."""
    head = (
        *("entry", "mark", "reference", "other seeds", "better than the mark above"),
        *("τ midpoint", "motion px", "basin px", "admitted %", "false %", "unreported %"),
    )
    marks = benchmark(NAME).baselines
    steps = mark_steps(results, marks)
    return markdown_table(
        head,
        (_row(results[key], "yes" if key in marks else "", steps[key]) for key in ordered(results)),
    )


def _row(one: Measured, mark: str, step: tuple[float, float] | None) -> tuple[str, ...]:
    columns = zip(COLUMNS, (2, 1, 1, 0, 0, 0), strict=True)
    return (
        *score_cells(one, mark, step),
        *(number(one.overall[name], digits) for name, digits in columns),
    )


def draw_difficulty(results: dict[str, Measured], out: Path) -> None:
    """Draw the share of success over the levels of each axis."""
    shown = [key for key in DRAWN if key in results]
    with figure(out, rows=len(AXES), height=10.0, share_x=False) as panels:
        for panel, (axis, label) in zip(panels, AXES.items(), strict=True):
            for number, key in enumerate(shown):
                values, shares = zip(*results[key].success[axis], strict=True)
                style = "-" if number % 2 else "--"
                panel.plot(values, shares, style, marker=".", label=results[key].title)
            panel.set_xlabel(label)
            panel.set_ylabel("p@1 [%]" if axis == "jump" else "p@5 [%]")
        panels[1].legend(fontsize=7, loc="center right")


def draw_textures(out: Path) -> None:
    """Write a column for each reference trial: its target at three optical depths."""
    entry = benchmark(NAME)
    experiment, config = entry.load(), entry.read({})
    seed = reference_seed(NAME)
    columns = []
    for trial in range(REFERENCE_TRIALS):
        kept: list[Rows] = []
        turbid = config.level_values().index(SHOWN_DEPTHS[-1])
        experiment.level(config, None, seed=seed, trial=trial, level=turbid).run(kept.append)
        pose = kept[0][0, INDEX["x"] : INDEX["yaw"] + 1]
        drawn = []
        for depth in SHOWN_DEPTHS:
            level = config.level_values().index(depth)
            camera = experiment.camera(config, seed=seed, trial=trial, level=level)
            column, row = camera.corners(pose).mean(axis=0).round().astype(int)
            padded = np.pad(camera.grey(pose, 0), 60)  # the crop may reach beyond the image
            drawn.append(padded[row + 20 : row + 100, column : column + 120])
        columns.append(np.vstack(drawn))
    cv2.imwrite(str(out), np.hstack(columns))


def main(names: Sequence[str]) -> int:
    """Measure, store, print and draw."""
    chosen = [key for key in entries() if not names or key in names]
    results = measure_and_store(NAME, chosen, measure)
    sys.stdout.write(f"{report(results)}\n\n{stability(results, dishonest=DISHONEST)}\n")
    draw_headroom(
        results,
        FIGURES / "visibility-v2-headroom.png",
        score="turbidity held [optical depth]",
        highest=7.0,
    )
    draw_difficulty(results, FIGURES / "visibility-v2-difficulty.png")
    draw_textures(FIGURES / "visibility-v2-textures.png")
    return 0
