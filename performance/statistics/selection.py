"""What the best of many submissions gains by luck, with the measured spread between trials.

Each submission of a benchmark with fresh trials draws other seeds. Here the scores of its trials
are drawn from a measured population (`population`), so all submissions are
equally good and whatever the best of them gains is luck. Prints a table for each benchmark and
writes docs/figures/selection.png.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from performance import FIGURES
from performance.plots import COLOURS, figure
from performance.statistics import population
from performance.tables import markdown_table, signed
from seamark.sim.benchmarks.benchmark import RankedProtocol
from seamark.sim.numerics.statistics import block_means, difference_interval
from seamark.sim.registry import benchmark

SUBMISSIONS = (1, 5, 35, 150)  # one, and five a day for a day, a week and a month
REPEATS = 2000  # of the whole selection
Blocks = NDArray[np.float64]  # means of blocks of trials


@dataclass(frozen=True, slots=True, kw_only=True)
class Population:
    """The means of blocks of trials of one solution, which all submissions are drawn from."""

    name: str
    solution: str
    protocol: RankedProtocol
    unit: str
    means: Blocks  # (blocks,) [unit]

    @property
    def blocks(self) -> int:
        """Number of blocks that decide the score of a submission."""
        return self.protocol.fresh_trials // self.protocol.block

    @property
    def error(self) -> float:
        """Standard error of a score."""
        return float(self.means.std(ddof=1)) / math.sqrt(self.blocks)


def populations() -> list[Population]:
    """Return the measured populations of benchmarks with fresh trials."""
    all_populations = []
    for title, scores in population.stored().items():
        name, solution = title.split()
        entry = benchmark(name)
        if entry.protocol is not None:
            all_populations.append(
                Population(
                    name=name,
                    solution=solution,
                    protocol=entry.protocol,
                    unit=entry.headline.unit or entry.headline.label,
                    means=np.array(block_means(scores, entry.protocol.block)),
                )
            )
    return all_populations


def gain(entry: Population, submissions: int, *, repeats: int = REPEATS) -> float:
    """Return the mean of the best score of some submissions minus their true score."""
    best = [entry.mean() for entry, _ in _selections(entry, submissions, repeats)]
    return float(np.mean(best) - entry.means.mean())


def passes(entry: Population, submissions: int, *, repeats: int = REPEATS) -> float:
    """Return how often an interval says that the best is better than one more submission.

    This is the comparison of two rows alone; the leaderboard's ranks are corrected for many.
    """
    intervals = [
        difference_interval(best.tolist(), other.tolist())
        for best, other in _selections(entry, submissions, repeats)
    ]
    return sum(interval is not None and interval[0] > 0.0 for interval in intervals) / repeats


def _selections(
    entry: Population, submissions: int, repeats: int
) -> Iterator[tuple[Blocks, Blocks]]:
    """Yield the blocks of the best submission, and those of one that was not chosen."""
    random = np.random.default_rng(submissions)
    for _ in range(repeats):
        drawn = random.choice(entry.means, size=(submissions + 1, entry.blocks))
        yield drawn[drawn[1:].mean(axis=1).argmax() + 1], drawn[0]


def text(entry: Population) -> str:
    """Return the table of one benchmark."""
    score, unit, protocol = float(entry.means.mean()), entry.unit, entry.protocol
    rows = []
    for count in SUBMISSIONS:
        best, passed = gain(entry, count), passes(entry, count)
        share, in_errors = signed(100.0 * best / score), signed(best / entry.error, 2)
        rows.append((count, signed(best, 4), f"{share} %", in_errors, f"{100.0 * passed:.0f} %"))
    header = (
        "submissions",
        f"gain of the best [{unit}]",
        "of its score",
        "in standard errors",
        "better than its equal by a t interval",
    )
    return "\n\n".join(
        [
            f"`{entry.name}`, built-in `{entry.solution}`: score {score:.3f} "
            f"{unit}, standard error {entry.error:.4f} with {protocol.fresh_trials} fresh "
            f"trials in blocks of {protocol.block}. The population has {len(entry.means)} "
            "blocks.",
            markdown_table(header, rows),
        ]
    )


def draw(entries: list[Population]) -> None:
    """Draw the gain against the number of submissions."""
    counts = sorted({round(count) for count in np.geomspace(1, SUBMISSIONS[-1], 14)})
    with figure(FIGURES / "selection.png") as axes:
        for colour, entry in zip(COLOURS, entries, strict=False):
            gains = [gain(entry, count) for count in counts]
            share = 100.0 * np.array(gains) / entry.means.mean()
            axes.plot(counts, share, marker="o", color=colour, label=entry.name)
        axes.set_xscale("log")
        axes.set_xlabel("submissions")
        axes.set_ylabel("gain of the best [% of the score]")
        axes.legend()


def main(_arguments: Sequence[str]) -> int:
    """Print the tables and write the figure."""
    all_populations = populations()
    print("\n\n".join(map(text, all_populations)))
    draw(all_populations)
    return 0
