"""Table and plots of the reference entries, from their stored trials."""

import re
from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

from performance.validation.markdown import signed, table
from performance.validation.plots import figure
from seamark.sim.benchmarks.benchmark import Benchmark
from seamark.sim.numerics.statistics import mean, mean_interval, paired_interval

Trials = Sequence[Mapping[str, Any]]  # of one entry, as __main__ stores them
HEAD = (
    *("entry", "current held [m/s], 95 % interval", "% of the scale", "better than the row above"),
    *("Girona 500", "BlueROV2 Heavy", "first half", "second half"),
)
PALETTE = "viridis"
_TABLE = re.compile(r"\| entry \| current held [^\n]*\n(?:\|[^\n]*\n)+")


def scores(trials: Trials, vehicle: str = "") -> list[float]:
    """Return the scores of the trials, or of those with one vehicle."""
    return [one["score"] for one in trials if not vehicle or one["vehicle"] == vehicle]


def ordered(entries: Mapping[str, Trials]) -> list[str]:
    """Return the names of the entries, the worst first."""
    return sorted(entries, key=lambda name: mean(scores(entries[name])))


def share_of_scale(score: float, scale: tuple[float, float]) -> float:
    """Return a score in percent of the way from doing nothing to the oracle."""
    nothing, oracle = scale
    return 100.0 * (score - nothing) / (oracle - nothing)


def write(entries: Mapping[str, Trials], benchmark: Benchmark, docs: Path) -> None:
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


def reference_table(entries: Mapping[str, Trials], titles: Mapping[str, str], block: int) -> str:
    """Return the Markdown table, the worst entry first; intervals by Student's t over blocks."""
    names = ordered(entries)
    scale = (mean(scores(entries["nothing"])), mean(scores(entries["oracle"])))
    steps = {"": "", names[0]: ""} | {
        name: _step(scores(entries[worse]), scores(entries[name]), block)
        for worse, name in pairwise(names)
    }
    return table(
        HEAD, (_row(titles[name], entries[name], steps[name], scale, block) for name in names)
    )


def _row(
    title: str, trials: Trials, step: str, scale: tuple[float, float], block: int
) -> tuple[str, ...]:
    all_scores = scores(trials)
    half = len(all_scores) // 2
    centre, interval = mean(all_scores), mean_interval(all_scores, block=block)
    span = f" ({signed(interval[0], 3)} to {signed(interval[1], 3)})" if interval else ""
    parts = (
        scores(trials, "girona500"),
        scores(trials, "bluerov2-heavy"),
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
    path.write_text(_TABLE.sub(lambda _found: f"{text}\n", before), "utf-8")


def _plot_scores(
    entries: Mapping[str, Trials], titles: Mapping[str, str], block: int, out: Path
) -> None:
    """Draw the score of each entry with its interval, and the vehicles beside it."""
    names = ordered(entries)
    with figure(out, height=4.5) as axes:
        for at, name in enumerate(names):
            all_scores = scores(entries[name])
            low, high = mean_interval(all_scores, block=block) or (all_scores[0], all_scores[0])
            axes.plot((low, high), (at, at), color="#1d4ed8", linewidth=6, alpha=0.35)
            axes.plot(mean(all_scores), at, "o", color="#1d4ed8")
            for vehicle, marker in (("girona500", "<"), ("bluerov2-heavy", ">")):
                own = mean(scores(entries[name], vehicle))
                axes.plot(own, at, marker, color="#c2410c", markersize=5)
        axes.set_yticks(range(len(names)), [titles[name] for name in names])
        axes.set_xlabel("current held [m/s], 95 % interval; ◁ Girona 500, ▷ BlueROV2 Heavy")
        axes.set_xlim(left=0.0)


def _plot_quality(
    entries: Mapping[str, Trials], titles: Mapping[str, str], benchmark: Benchmark, out: Path
) -> None:
    """Draw the quality of each entry over the current: the difficulty curve."""
    from matplotlib import colormaps  # noqa: PLC0415  (a development dependency)

    names = ordered(entries)
    levels = benchmark.read({}).level_values()
    with figure(out, height=4.5) as axes:
        for at, name in enumerate(names):
            columns = zip(*(one["quality"] for one in entries[name]), strict=True)
            colour = colormaps[PALETTE](0.9 * at / max(len(names) - 1, 1))
            curve = [mean(list(column)) for column in columns]
            axes.plot(levels, curve, marker="o", color=colour, label=titles[name])
        axes.set_xlabel("mean speed of the current [m/s]")
        axes.set_ylabel("quality")
        axes.set_ylim(0.0, 1.0)
        axes.legend(fontsize=8)


def _block(benchmark: Benchmark) -> int:
    return benchmark.protocol.block if benchmark.protocol is not None else 1
