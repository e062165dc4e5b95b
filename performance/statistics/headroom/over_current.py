"""Reference entries of a benchmark whose score is an area over the current: table and plots.

A command declares a `Headroom` and calls `main`. Results do not depend on the number of processes,
by default one per core.
"""

import argparse
import os
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from multiprocessing import get_context
from pathlib import Path
from typing import Any, NamedTuple

from performance import DOCS
from performance.plots import figure
from performance.statistics.headroom.store import store, stored
from performance.statistics.reference_results import Job, measure
from performance.tables import markdown_table, signed
from seamark.sim.benchmarks.benchmark import Benchmark
from seamark.sim.engine.trial import TrialResult
from seamark.sim.engine.warm_up import warm_up
from seamark.sim.numerics.statistics import mean, mean_interval, paired_interval
from seamark.sim.registry import benchmark as benchmark_of

PALETTE = "viridis"
MARKERS = {"<": "◁", ">": "▷"}  # of Matplotlib, and as a letter
Scores = Sequence[float]  # [m/s] of trials
Parts = Mapping[str, Callable[[Scores], Scores]]  # what it is -> some of the trials


class Measured(NamedTuple):
    """The trials of an entry."""

    seed: int
    scores: Scores
    levels: Mapping[str, Sequence[float]]  # metric -> of each level, the mean over the trials

    @classmethod
    def read(cls, values: Mapping[str, Any]) -> "Measured":
        """Return what `as_dict` wrote."""
        levels = {name: value for name, value in values.items() if name not in ("seed", "scores")}
        return cls(values["seed"], values["scores"], levels)

    def as_dict(self) -> dict[str, Any]:
        """Return it as plain JSON values."""
        return {"seed": self.seed, "scores": self.scores, **self.levels}


@dataclass(frozen=True, slots=True, kw_only=True)
class Headroom:
    """What of a benchmark is measured, and how it is shown."""

    benchmark: str
    command: str  # of `./run performance`
    seed: int
    trials: int
    seed_per_trial: bool  # trial i has the seed plus i, not the seed of all
    score: str  # its name in the table
    curve: str  # the metric of a level that is drawn over the current
    levels: tuple[str, ...]  # all metrics of a level that are kept
    columns: Callable[[Measured], Mapping[str, str]]  # beside the score: head -> cell
    parts: Parts  # two, that the plot of scores shows beside the whole

    @property
    def definition(self) -> Benchmark:
        """Return the benchmark."""
        return benchmark_of(self.benchmark)

    @property
    def block(self) -> int:
        """Return how many consecutive trials are one observation."""
        protocol = self.definition.protocol
        return protocol.block if protocol is not None else 1

    def known(self) -> dict[str, Measured]:
        """Return what is stored of today's entries."""
        results = stored(self.benchmark)
        names = (name for name in self.definition.baselines if name in results)
        return {name: Measured.read(results[name]) for name in names}

    def titles(self) -> dict[str, str]:
        """Return the title of each entry."""
        return {name: mark.title for name, mark in self.definition.baselines.items()}


def measure_all(plan: Headroom, entry: str, seed: int, trials: int, processes: int) -> Measured:
    """Return the trials of an entry, rounded to what table and plots show and a few digits more."""
    jobs = [
        Job(plan.benchmark, entry, trial, seed + trial * plan.seed_per_trial)
        for trial in range(trials)
    ]
    with get_context("spawn").Pool(processes, initializer=warm_up) as pool:
        results = pool.map(measure, jobs, chunksize=1)
    return Measured(
        seed,
        scores=[round(one.score, 6) for one in results],
        levels={name: _means(results, name) for name in plan.levels},
    )


def _means(results: Sequence[TrialResult], metric: str) -> list[float]:
    levels = zip(*([level[metric] for level in one.levels] for one in results), strict=True)
    return [round(mean(level), 6) for level in levels]


def ordered(entries: Mapping[str, Measured]) -> list[str]:
    """Return the names of the entries, the worst first."""
    return sorted(entries, key=lambda name: mean(entries[name].scores))


def share_of_scale(score: float, scale: tuple[float, float]) -> float:
    """Return a score in percent of the way from doing nothing to the oracle."""
    nothing, oracle = scale
    return 100.0 * (score - nothing) / (oracle - nothing)


def in_turn(labels: Sequence[str]) -> Parts:
    """Return the trials of each of what takes turns from trial to trial."""
    return {label: _every(len(labels), at) for at, label in enumerate(labels)}


def _every(count: int, first: int) -> Callable[[Scores], Scores]:
    return lambda scores: scores[first::count]


def first_half(scores: Scores) -> Scores:
    """Return the scores of the first half of the trials."""
    return scores[: len(scores) // 2]


def second_half(scores: Scores) -> Scores:
    """Return the scores of the second half of the trials."""
    return scores[len(scores) // 2 :]


HALVES: Parts = {"first half": first_half, "second half": second_half}


def of_parts(one: Measured, parts: Parts) -> dict[str, str]:
    """Return the mean score of parts of the trials, as columns of the table."""
    return {name: f"{mean(of(one.scores)):.3f}" for name, of in parts.items()}


def reference_table(
    plan: Headroom, entries: Mapping[str, Measured], titles: Mapping[str, str]
) -> str:
    """Return the Markdown table, the worst entry first; intervals by Student's t over blocks."""
    names, block = ordered(entries), plan.block
    scale = (mean(entries["nothing"].scores), mean(entries["oracle"].scores))
    steps = {names[0]: ""} | {
        name: _step(entries[worse].scores, entries[name].scores, block)
        for worse, name in pairwise(names)
    }
    rows = (_row(plan, titles[name], entries[name], steps[name], scale) for name in names)
    score = f"{plan.score} [m/s], 95 % interval"
    more = plan.columns(entries[names[0]])
    return markdown_table(
        ("entry", score, "% of the scale", "better than the row above", *more), rows
    )


def _row(
    plan: Headroom, title: str, one: Measured, step: str, scale: tuple[float, float]
) -> tuple[str, ...]:
    centre, interval = mean(one.scores), mean_interval(one.scores, block=plan.block)
    span = f" ({signed(interval[0], 3)} to {signed(interval[1], 3)})" if interval else ""
    share = signed(share_of_scale(centre, scale))
    return (title, f"{centre:.3f}{span}", share, step, *plan.columns(one).values())


def _step(worse: Scores, better: Scores, block: int) -> str:
    interval = paired_interval(better, worse, block=block)
    if interval is None:
        return ""
    low, high = interval
    return f"{signed(low, 3)} to {signed(high, 3)}"


def insert(path: Path, text: str) -> None:
    """Replace the table of a page that has the same first columns."""
    first, score = (cell.strip() for cell in text.strip("|").split("|")[:2])
    head = re.escape(f"| {first} | {score.partition(' [')[0]} [")
    table = re.compile(rf"{head}[^\n]*\n(?:\|[^\n]*\n)+")
    before = path.read_text("utf-8")
    path.write_text(table.sub(lambda _match: f"{text}\n", before), "utf-8")


def write(plan: Headroom, entries: Mapping[str, Measured], docs: Path) -> None:
    """Write the plots, and the table into benchmarks.md; print the table."""
    text = reference_table(plan, entries, plan.titles())
    print(text)
    insert(docs / "benchmarks.md", text)
    _plot_scores(plan, entries, docs / f"figures/{plan.benchmark}-headroom.png")
    _plot_levels(plan, entries, docs / f"figures/{plan.benchmark}-difficulty.png")


def _plot_scores(plan: Headroom, entries: Mapping[str, Measured], out: Path) -> None:
    """Draw the score of each entry with its interval, and the parts of its trials beside it."""
    names, titles = ordered(entries), plan.titles()
    with figure(out, height=4.5) as axes:
        for at, name in enumerate(names):
            scores = entries[name].scores
            low, high = mean_interval(scores, block=plan.block) or (scores[0], scores[0])
            axes.plot((low, high), (at, at), color="#1d4ed8", linewidth=6, alpha=0.35)
            axes.plot(mean(scores), at, "o", color="#1d4ed8")
            for marker, of in zip(MARKERS, plan.parts.values(), strict=True):
                axes.plot(mean(of(scores)), at, marker, color="#c2410c", markersize=5)
        axes.set_yticks(range(len(names)), [titles[name] for name in names])
        signs = zip(MARKERS.values(), plan.parts, strict=True)
        parts = ", ".join(f"{sign} {part}" for sign, part in signs)
        axes.set_xlabel(f"{plan.score} [m/s], 95 % interval; {parts}")
        axes.set_xlim(left=0.0)


def at_speeds(speeds: Sequence[float], values: Sequence[float]) -> dict[float, float]:
    """Return speed -> mean over the levels with that speed, which in a grid are several."""
    levels = [*zip(speeds, values, strict=True)]
    return {
        each: mean([value for speed, value in levels if speed == each])
        for each in sorted(set(speeds))
    }


def _plot_levels(plan: Headroom, entries: Mapping[str, Measured], out: Path) -> None:
    """Draw what each entry did over the current: the difficulty curve."""
    from matplotlib import colormaps  # noqa: PLC0415  (a development dependency)

    names, titles = ordered(entries), plan.titles()
    speeds = plan.definition.read({}).level_values()
    with figure(out, height=4.5) as axes:
        for at, name in enumerate(names):
            colour = colormaps[PALETTE](0.9 * at / max(len(names) - 1, 1))
            means = at_speeds(speeds, entries[name].levels[plan.curve])
            axes.plot([*means], [*means.values()], marker="o", color=colour, label=titles[name])
        axes.set_xlabel("mean speed of the current [m/s]")
        axes.set_ylabel(plan.curve)
        axes.set_ylim(top=1.0)
        axes.set_ylim(bottom=min(0.0, axes.get_ylim()[0]))
        axes.legend(fontsize=8)


def main(plan: Headroom, arguments: Sequence[str]) -> int:
    """Measure what is missing or named, then write table and plots."""
    known = plan.definition.baselines
    parser = argparse.ArgumentParser(prog=f"./run performance {plan.command}")
    parser.add_argument("entries", nargs="*", metavar="ENTRY", help=", ".join(known))
    parser.add_argument("--trials", type=int, default=plan.trials)
    parser.add_argument("--seed", type=int, default=plan.seed)
    parser.add_argument("--processes", type=int, default=len(os.sched_getaffinity(0)))
    args = parser.parse_args(arguments)
    if unknown := set(args.entries) - set(known):
        parser.error(f"there is no entry {', '.join(sorted(unknown))}")
    entries = plan.known()
    wanted = (args.seed, args.trials)
    have = {name: (one.seed, len(one.scores)) for name, one in entries.items()}
    missing = [name for name in known if have.get(name) != wanted]
    for name in args.entries or missing:  # stored one by one: an interruption loses little
        entries[name] = measure_all(plan, name, args.seed, args.trials, args.processes)
        store(plan.benchmark, {name: one.as_dict() for name, one in entries.items()})
        print(f"{name}: {args.trials} trials", flush=True)
    write(plan, entries, DOCS)
    return 0
