"""Measure the entries of patterns-v1 and write their table and figures.

    ./run performance patterns_headroom [ENTRY ...]

Every named entry (all of them without a name) runs the reference trials, and 24 trials with other
seeds, the same for all. From docs/headroom.json it prints the table of docs/benchmarks.md and how
far the order depends on the trials, and redraws the figures patterns-v1-headroom.png, -depths.png
and -bottoms.webp.
"""

import sys
from collections.abc import Mapping, Sequence
from multiprocessing import get_context
from pathlib import Path

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
from performance.tables import markdown_table
from seamark.sim.benchmarks.patterns_v1.scenario import draw_scenario
from seamark.sim.benchmarks.patterns_v1.settings import PatternsConfiguration
from seamark.sim.engine.summary import summarise
from seamark.sim.engine.trial import TrialResult, run_trial
from seamark.sim.engine.warm_up import warm_up_benchmark
from seamark.sim.metrics.recognition import AP
from seamark.sim.registry import benchmark

NAME = "patterns-v1"
AXIS = "depth"
COLUMNS = ("f_measure", "recall_percent", "precision_percent", "hit_corner_px")
DIGITS = (2, 0, 0, 1)
SHOWN_DEPTHS = (0, 2, 4)  # levels of the picture


def measure(name: str, processes: int) -> Measured:
    """Run an entry on the reference trials and on others; results do not depend on `processes`."""
    entry = benchmark(NAME).baselines[name]
    with get_context("spawn").Pool(processes, warm_up_benchmark, (NAME,)) as pool:
        results = pool.map(_run, jobs(NAME, name), chunksize=1)
    config = benchmark(NAME).read(entry.config)
    metrics = summarise(NAME, config, results[REFERENCE_TRIALS:])
    return Measured(
        title=entry.title,
        scores=[round(result.score, 6) for result in results],
        overall={name: rounded(metrics["overall"][name]) for name in COLUMNS},
        success={
            AXIS: [
                (level["optical_depth"], round(level[AP.name], 3)) for level in metrics["levels"]
            ]
        },
    )


def _run(job: Job) -> TrialResult:
    entry = benchmark(NAME).baselines[job.entry]
    config = benchmark(NAME).read(entry.config)
    solution = benchmark(NAME).load().built_in(entry.built_in, config)
    return run_trial(
        NAME, config, solution, seed=job.seed, trial=job.trial, on_rows=lambda _rows: None
    )


def report(results: Mapping[str, Measured]) -> str:
    """Return the table, lowest score first."""
    depths = [f"{depth:g}" for depth in benchmark(NAME).read({}).level_values()]
    head = (
        *("entry", "mark", "reference", "other seeds", "better than the mark above"),
        *("F measure", "recall %", "precision %", "corners px"),
        *(f"AP at {depth}" for depth in depths),
    )
    marks = benchmark(NAME).baselines
    steps = mark_steps(results, marks)
    return markdown_table(
        head,
        (_row(results[key], "yes" if key in marks else "", steps[key]) for key in ordered(results)),
    )


def _row(one: Measured, mark: str, step: tuple[float, float] | None) -> tuple[str, ...]:
    columns = zip(COLUMNS, DIGITS, strict=True)
    return (
        *score_cells(one, mark, step),
        *(number(one.overall[name], digits) for name, digits in columns),
        *(number(share, 0) for _, share in one.success[AXIS]),
    )


def draw_depths(results: Mapping[str, Measured], out: Path) -> None:
    """Draw average precision over optical depth."""
    with figure(out, height=4.0) as axes:
        for index, key in enumerate(ordered(results)):
            depths, shares = zip(*results[key].success[AXIS], strict=True)
            style = "-" if index % 2 else "--"
            axes.plot(depths, shares, style, marker=".", label=results[key].title)
        axes.set_xlabel("optical depth")
        axes.set_ylabel("average precision [%]")
        axes.legend(fontsize=7, loc="upper right")


def draw_bottoms(out: Path) -> None:
    """Write an image of each of the first reference trials, at three optical depths."""
    config, seed = PatternsConfiguration.read({}), reference_seed(NAME)
    rows = []
    for depth in SHOWN_DEPTHS:
        images = []
        for trial in range(REFERENCE_TRIALS // 2):
            scenario = draw_scenario(config, seed, trial, config.level_values().index(depth))
            pose, _ = scenario.path.pose_and_velocity(0.5 * config.level_duration_s)
            images.append(scenario.camera.colour(np.array(pose), 0))
        rows.append(np.hstack(images))
    cv2.imwrite(str(out), np.vstack(rows), [cv2.IMWRITE_WEBP_QUALITY, 85])


def main(names: Sequence[str]) -> int:
    """Measure, store, print and draw."""
    chosen = [key for key in benchmark(NAME).baselines if not names or key in names]
    results = measure_and_store(NAME, chosen, measure)
    sys.stdout.write(f"{report(results)}\n\n{stability(results, dishonest=())}\n")
    draw_headroom(
        results,
        FIGURES / "patterns-v1-headroom.png",
        score="patterns recognised [optical depth]",
        highest=6.0,
    )
    draw_depths(results, FIGURES / "patterns-v1-depths.png")
    draw_bottoms(FIGURES / "patterns-v1-bottoms.webp")
    return 0
