"""Measure the reference entries of currents-v2 and write their table and plots.

    ./run performance headroom [ENTRY ...] [--trials N] [--seed S] [--processes P]

Named entries are measured again, by default those that docs/headroom.json does not have yet with
these trials. The scenario is the ranked one; trial i has the seed S + i, none of which is a
benchmark's. Results do not depend on the number of processes, by default one per core.
"""

import argparse
import os
import re
from collections.abc import Mapping, Sequence
from itertools import pairwise
from multiprocessing import get_context
from pathlib import Path
from typing import NamedTuple

from performance import DOCS
from performance.plots import figure
from performance.statistics.headroom.store import store, stored
from performance.tables import markdown_table, signed
from seamark.sim.benchmarks.benchmark import Benchmark
from seamark.sim.benchmarks.currents_v2.settings import ALTERNATING
from seamark.sim.engine.trial import TrialResult, run_trial
from seamark.sim.engine.warm_up import warm_up
from seamark.sim.numerics.statistics import mean, mean_interval, paired_interval
from seamark.sim.registry import benchmark as benchmark_of

NAME = "currents-v2"
SEED = 3001  # neither the reference seed nor one that gains were tuned on
HEAD = (
    *("entry", "current held [m/s], 95 % interval", "% of the scale", "better than the row above"),
    *("Girona 500", "BlueROV2 Heavy", "first half", "second half"),
)
PALETTE = "viridis"
_TABLE = re.compile(r"\| entry \| current held [^\n]*\n(?:\|[^\n]*\n)+")


class Measured(NamedTuple):
    """The trials of an entry; trial i has the seed `seed + i`, the vehicles take turns."""

    seed: int
    scores: Sequence[float]  # [m/s] of each trial
    quality: Sequence[float]  # of each level, the mean over the trials


class Job(NamedTuple):
    """One trial of one entry."""

    entry: str
    trial: int
    seed: int


def measure(job: Job) -> TrialResult:
    """Run a trial in the ranked scenario."""
    entry = benchmark_of(NAME)
    baseline = entry.baselines[job.entry]
    config = entry.ranked(entry.read(baseline.config))
    program = entry.load().built_in(baseline.built_in, config.for_trial(job.trial))
    return run_trial(
        NAME, config, program, seed=job.seed, trial=job.trial, on_rows=lambda _rows: None
    )


def measure_all(entry: str, seed: int, trials: int, processes: int) -> Measured:
    """Return the trials of an entry, rounded to what table and plots show and a few digits more."""
    jobs = [Job(entry, trial, seed + trial) for trial in range(trials)]
    with get_context("spawn").Pool(processes, initializer=warm_up) as pool:
        results = pool.map(measure, jobs, chunksize=1)
    qualities = zip(*([level["quality"] for level in one.levels] for one in results), strict=True)
    return Measured(
        seed,
        scores=[round(one.score, 6) for one in results],
        quality=[round(mean(level), 6) for level in qualities],
    )


def of_vehicle(one: Measured, vehicle: str) -> Sequence[float]:
    """Return the scores of the trials with a vehicle."""
    return one.scores[ALTERNATING.index(vehicle) :: len(ALTERNATING)]


def ordered(entries: Mapping[str, Measured]) -> list[str]:
    """Return the names of the entries, the worst first."""
    return sorted(entries, key=lambda name: mean(entries[name].scores))


def share_of_scale(score: float, scale: tuple[float, float]) -> float:
    """Return a score in percent of the way from doing nothing to the oracle."""
    nothing, oracle = scale
    return 100.0 * (score - nothing) / (oracle - nothing)


def write(entries: Mapping[str, Measured], benchmark: Benchmark, docs: Path) -> None:
    """Write the plots, and the table into benchmarks.md; print the table."""
    names = ordered(entries)
    titles = {name: benchmark.baselines[name].title for name in names}
    text = reference_table(entries, titles, _block(benchmark))
    print(text)
    insert(docs / "benchmarks.md", text)
    _plot_scores(
        entries, titles, _block(benchmark), docs / f"figures/{benchmark.name}-headroom.png"
    )
    _plot_quality(entries, titles, benchmark, docs / f"figures/{benchmark.name}-difficulty.png")


def reference_table(entries: Mapping[str, Measured], titles: Mapping[str, str], block: int) -> str:
    """Return the Markdown table, the worst entry first; intervals by Student's t over blocks."""
    names = ordered(entries)
    scale = (mean(entries["nothing"].scores), mean(entries["oracle"].scores))
    steps = {"": "", names[0]: ""} | {
        name: _step(entries[worse].scores, entries[name].scores, block)
        for worse, name in pairwise(names)
    }
    return markdown_table(
        HEAD, (_row(titles[name], entries[name], steps[name], scale, block) for name in names)
    )


def _row(
    title: str, one: Measured, step: str, scale: tuple[float, float], block: int
) -> tuple[str, ...]:
    all_scores = one.scores
    half = len(all_scores) // 2
    centre, interval = mean(all_scores), mean_interval(all_scores, block=block)
    span = f" ({signed(interval[0], 3)} to {signed(interval[1], 3)})" if interval else ""
    parts = (
        *(of_vehicle(one, vehicle) for vehicle in ALTERNATING),
        all_scores[:half],
        all_scores[half:],
    )
    share = signed(share_of_scale(centre, scale))
    return (title, f"{centre:.3f}{span}", share, step, *(f"{mean(part):.3f}" for part in parts))


def _step(worse: Sequence[float], better: Sequence[float], block: int) -> str:
    interval = paired_interval(better, worse, block=block)
    if interval is None:
        return ""
    low, high = interval
    return f"{signed(low, 3)} to {signed(high, 3)}"


def insert(path: Path, text: str) -> None:
    """Replace the table of a page that has the same first columns."""
    before = path.read_text("utf-8")
    path.write_text(_TABLE.sub(lambda _match: f"{text}\n", before), "utf-8")


def _plot_scores(
    entries: Mapping[str, Measured], titles: Mapping[str, str], block: int, out: Path
) -> None:
    """Draw the score of each entry with its interval, and the vehicles beside it."""
    names = ordered(entries)
    with figure(out, height=4.5) as axes:
        for at, name in enumerate(names):
            all_scores = entries[name].scores
            low, high = mean_interval(all_scores, block=block) or (all_scores[0], all_scores[0])
            axes.plot((low, high), (at, at), color="#1d4ed8", linewidth=6, alpha=0.35)
            axes.plot(mean(all_scores), at, "o", color="#1d4ed8")
            for vehicle, marker in zip(ALTERNATING, "<>", strict=True):
                own = mean(of_vehicle(entries[name], vehicle))
                axes.plot(own, at, marker, color="#c2410c", markersize=5)
        axes.set_yticks(range(len(names)), [titles[name] for name in names])
        axes.set_xlabel("current held [m/s], 95 % interval; ◁ Girona 500, ▷ BlueROV2 Heavy")
        axes.set_xlim(left=0.0)


def _plot_quality(
    entries: Mapping[str, Measured], titles: Mapping[str, str], benchmark: Benchmark, out: Path
) -> None:
    """Draw the quality of each entry over the current: the difficulty curve."""
    from matplotlib import colormaps  # noqa: PLC0415  (a development dependency)

    names = ordered(entries)
    levels = benchmark.read({}).level_values()
    with figure(out, height=4.5) as axes:
        for at, name in enumerate(names):
            colour = colormaps[PALETTE](0.9 * at / max(len(names) - 1, 1))
            axes.plot(levels, entries[name].quality, marker="o", color=colour, label=titles[name])
        axes.set_xlabel("mean speed of the current [m/s]")
        axes.set_ylabel("quality")
        axes.set_ylim(0.0, 1.0)
        axes.legend(fontsize=8)


def _block(benchmark: Benchmark) -> int:
    return benchmark.protocol.block if benchmark.protocol is not None else 1


def known_entries() -> dict[str, Measured]:
    """Return what is stored of today's entries."""
    results = stored(NAME)
    return {
        name: Measured(**results[name]) for name in benchmark_of(NAME).baselines if name in results
    }


def main(arguments: Sequence[str]) -> int:
    """Measure what is missing or named, then write table and plots."""
    known = benchmark_of(NAME).baselines
    parser = argparse.ArgumentParser(prog="./run performance headroom")
    parser.add_argument("entries", nargs="*", metavar="ENTRY", help=", ".join(known))
    parser.add_argument("--trials", type=int, default=48)
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--processes", type=int, default=len(os.sched_getaffinity(0)))
    args = parser.parse_args(arguments)
    if unknown := set(args.entries) - set(known):
        parser.error(f"there is no entry {', '.join(sorted(unknown))}")
    entries = known_entries()
    wanted = (args.seed, args.trials)
    have = {name: (one.seed, len(one.scores)) for name, one in entries.items()}
    missing = [name for name in known if have.get(name) != wanted]
    for name in args.entries or missing:  # stored one by one: an interruption loses little
        entries[name] = measure_all(name, args.seed, args.trials, args.processes)
        store(NAME, {name: one._asdict() for name, one in entries.items()})
        print(f"{name}: {args.trials} trials", flush=True)
    write(entries, benchmark_of(NAME), DOCS)
    return 0
