"""Measure the entries of visibility-v3 or visibility-v2 and write their table and figures.

    ./run performance visibility_headroom [--benchmark NAME] [ENTRY ...]

Every named entry (all of them without a name) runs the reference trials, and 24 trials in water of
other seeds, the same for all. From docs/headroom.json it prints the table of docs/benchmarks.md and
how far the order depends on the trials, and redraws the figures NAME-headroom.png, -difficulty.png
and -textures.png. It takes about a minute per entry on two idle cores, for KCF, ECC and the ideal
observer some minutes.
"""

import argparse
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, partial
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
from performance.statistics.visibility_attacks import Always, Playback, Remembering, stored_paths
from performance.statistics.visibility_attacks import Path as CornerPath
from performance.tables import markdown_table
from seamark.sim.engine.replay import Replay
from seamark.sim.engine.summary import summarise
from seamark.sim.engine.trial import TrialResult, run_trial
from seamark.sim.engine.warm_up import warm_up
from seamark.sim.recording.telemetry import Rows
from seamark.sim.registry import benchmark
from seamark.sim.trackers import Tracker, make

SECOND, THIRD = "visibility-v2", "visibility-v3"
AXES = {"turbidity": "optical depth", "motion": "px per image", "jump": "jump [px]"}
_LOSSES = ("admitted_loss_percent", "false_loss_percent", "unreported_loss_percent")
COLUMNS: Mapping[str, Mapping[str, tuple[str, int]]] = {  # metric -> its heading and digits
    SECOND: {
        "tau_midpoint": ("τ midpoint", 2),
        "motion_held_px": ("motion px", 1),
        "basin_px": ("basin px", 1),
        **dict(zip(_LOSSES, (("admitted %", 0), ("false %", 0), ("unreported %", 0)), strict=True)),
    },
    THIRD: {
        "tau_midpoint": ("τ midpoint", 2),
        "motion_held_px": ("motion px", 1),
        "basin_px": ("basin px", 1),
        "p5_percent": ("p@5 %", 0),
        "wrong_percent": ("wrong %", 0),
        **dict(zip(_LOSSES[:2], (("admitted %", 0), ("false %", 0)), strict=True)),
    },
}
SUCCESS = {SECOND: "p5_percent", THIRD: "net_percent"}  # of a level that is not one of jumps
DISHONEST = ("playback", "remembers", "always")
SHOWN_DEPTHS = (0.0, 2.0, 4.0)
DRAWN = (
    *("nothing", "blind", "match", "filter", "ssd-homography", "box", "kcf", "ecc", "klt"),
    *("zncc-homography", "zncc-srt", "mosse", "median-flow", "ideal", "oracle"),
)
_NOT_DRAWN = {SECOND: ("zncc-srt",), THIRD: ("nothing", "ssd-homography", "kcf", "median-flow")}


@dataclass(frozen=True, slots=True, kw_only=True)
class Entry:
    """A solution: its title, settings, and what makes it if it is not the built-in tracker."""

    title: str
    config: dict[str, object]
    make: Callable[[Any], Any]  # configuration -> solution


def _reference(benchmark_name: str, name: str) -> Callable[[Any], Any]:
    return lambda config: benchmark(benchmark_name).load().built_in(name, config)


def _configured(config: Any) -> Tracker:
    return make(config.tracker, truth=None, **config.tracker_options())


def _remembering(config: Any) -> Remembering:
    return Remembering(_configured(config))


def _always(config: Any) -> Always:
    return Always(_configured(config))


@cache  # once per process
def _reference_paths(name: str) -> dict[bytes, CornerPath]:
    return stored_paths(name, seed=reference_seed(name), trials=REFERENCE_TRIALS)


def entries(name: str) -> dict[str, Entry]:
    """Return the marks of the leaderboard, and what else is compared with them, by short names."""
    by_name = {
        key: Entry(title=mark.title, config=dict(mark.config), make=_reference(name, mark.built_in))
        for key, mark in benchmark(name).baselines.items()
    }
    built_in = _reference(name, "built-in")
    by_name["playback"] = Entry(
        title="Playback of the reference trials",
        config={},
        make=lambda _config: Playback(_reference_paths(name)),
    )
    by_name["remembers"] = Entry(
        title="ZNCC, homography, remembers the path", config={}, make=_remembering
    )
    if name == THIRD:
        for tracker in ("klt", "ecc"):
            by_name[tracker] = Entry(
                title=f"{tracker.upper()}, homography", config={"tracker": tracker}, make=built_in
            )
        by_name["always"] = Entry(
            title="ZNCC, SRT, never admits a loss", config={"warp": "srt"}, make=_always
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
    return by_name


def measure(name: str, key: str, processes: int) -> Measured:
    """Run an entry on the reference trials and on others; results do not depend on `processes`."""
    entry = entries(name)[key]
    with get_context("spawn").Pool(processes, initializer=warm_up) as pool:
        results = pool.map(partial(_run, name), jobs(name, key), chunksize=1)
    config = benchmark(name).read(entry.config)
    other_metrics = summarise(name, config, results[REFERENCE_TRIALS:])
    return Measured(
        title=entry.title,
        scores=[round(result.score, 6) for result in results],
        overall={column: rounded(other_metrics["overall"][column]) for column in COLUMNS[name]},
        success={
            axis: [
                (level["value"], round(level[_success(name, axis)], 3))
                for level in other_metrics["levels"]
                if level["axis"] == axis
            ]
            for axis in AXES
        },
    )


def _success(name: str, axis: str) -> str:
    """Return the metric that counts as success on an axis."""
    return "p1_percent" if axis == "jump" else SUCCESS[name]


def _run(name: str, job: Job) -> TrialResult:
    entry = entries(name)[job.entry]
    config = benchmark(name).read(entry.config)
    solution = entry.make(config)
    return run_trial(
        name, config, solution, seed=job.seed, trial=job.trial, on_rows=lambda _rows: None
    )


def report(name: str, results: dict[str, Measured]) -> str:
    """Return the table, lowest score first."""
    head = (
        *("entry", "mark", "reference", "other seeds", "better than the mark above"),
        *(heading for heading, _digits in COLUMNS[name].values()),
    )
    marks = benchmark(name).baselines
    steps = mark_steps(results, marks)
    return markdown_table(
        head,
        (
            (
                *score_cells(results[key], "yes" if key in marks else "", steps[key]),
                *(
                    number(results[key].overall[column], digits)
                    for column, (_heading, digits) in COLUMNS[name].items()
                ),
            )
            for key in ordered(results)
        ),
    )


def draw_difficulty(name: str, results: dict[str, Measured], out: Path) -> None:
    """Draw the share of success over the levels of each axis."""
    shown = [key for key in DRAWN if key in results and key not in _NOT_DRAWN[name]]
    followed = "p@5 [%]" if name == SECOND else "right less wrong [%]"
    with figure(out, rows=len(AXES), height=10.0, share_x=False) as panels:
        for panel, (axis, label) in zip(panels, AXES.items(), strict=True):
            for at, key in enumerate(shown):
                values, shares = zip(*results[key].success[axis], strict=True)
                style = "-" if at % 2 else "--"
                panel.plot(values, shares, style, marker=".", label=results[key].title)
            panel.set_xlabel(label)
            panel.set_ylabel("p@1 [%]" if axis == "jump" else followed)
        panels[1].legend(fontsize=7, loc="center right")


def draw_textures(name: str, out: Path) -> None:
    """Write a column for each reference trial: its target at three optical depths."""
    entry = benchmark(name)
    config, seed = entry.read({}), reference_seed(name)
    replay = Replay(name, config, lambda _trial: seed)
    columns = []
    for trial in range(REFERENCE_TRIALS):
        kept: list[Rows] = []
        drawn = []
        for depth in SHOWN_DEPTHS:
            level = config.level_values().index(depth)
            entry.load().level(config, None, seed=seed, trial=trial, level=level).run(kept.append)
            motion = replay.frame(kept[-1][0]).motion
            camera = replay.camera(trial, level)
            column, row = camera.corners(motion).mean(axis=0).round().astype(int)
            padded = np.pad(camera.grey(motion, 0), 60)  # the crop may reach beyond the image
            drawn.append(padded[row + 20 : row + 100, column : column + 120])
        columns.append(np.vstack(drawn))
    cv2.imwrite(str(out), np.hstack(columns))


def main(arguments: Sequence[str]) -> int:
    """Measure, store, print and draw."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("names", nargs="*", metavar="ENTRY")
    parser.add_argument("--benchmark", choices=tuple(COLUMNS), default=THIRD)
    options = parser.parse_args(arguments)
    name: str = options.benchmark
    chosen = [key for key in entries(name) if not options.names or key in options.names]
    results = measure_and_store(name, chosen, partial(measure, name))
    sys.stdout.write(f"{report(name, results)}\n\n{stability(results, dishonest=DISHONEST)}\n")
    draw_headroom(
        results,
        FIGURES / f"{name}-headroom.png",
        score="turbidity held [optical depth]",
        highest=benchmark(name).score_bar_max,
    )
    draw_difficulty(name, results, FIGURES / f"{name}-difficulty.png")
    draw_textures(name, FIGURES / f"{name}-textures.png")
    return 0
