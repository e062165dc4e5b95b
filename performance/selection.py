"""What the best of many submissions gains by luck, with the measured spread between trials.

    python -m performance.selection [BENCHMARK ...] [--trials N]

Each submission of a benchmark with fresh trials draws other water. Here the scores of its trials
are drawn from those of one built-in solution on many seeds, so all submissions are equally good and
whatever the best of them gains is luck. Prints a table for each benchmark and writes
docs/figures/selection.png.
"""

import argparse
import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from performance.validation.markdown import signed, table
from performance.validation.plots import COLOURS, figure
from seamark.sim.benchmarks.benchmark import RankedProtocol
from seamark.sim.engine.trial import run_trial
from seamark.sim.numerics.statistics import block_means, difference_interval
from seamark.sim.registry import benchmark

FIGURE = Path(__file__).parents[1] / "docs" / "figures" / "selection.png"
SUBMISSIONS = (1, 5, 35, 150)  # one, and five a day for a day, a week and a month
SOLUTIONS = {"currents-v2": "pi", "visibility-v2": "built-in"}
FIRST_SEED = 5001  # not the reference seed
TRIALS = 48
REPEATS = 2000  # of the whole selection
Blocks = NDArray[np.float64]  # means of blocks of trials


@dataclass(frozen=True, slots=True, kw_only=True)
class Population:
    """The means of blocks of trials of one solution, which all submissions are drawn from."""

    name: str
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


def measured(name: str, trials: int) -> Population:
    """Run the ranked scenario on as many seeds as there are trials."""
    entry = benchmark(name)
    if entry.protocol is None:
        raise ValueError(f"{name} has no fresh trials")
    config, experiment = entry.ranked(entry.read({})), entry.load()
    scores = []
    for trial in range(trials):
        solution = experiment.built_in(SOLUTIONS[name], config.for_trial(trial))
        seed = FIRST_SEED + trial
        result = run_trial(name, config, solution, seed=seed, trial=trial, on_rows=lambda _: None)
        scores.append(result.score)
    return Population(
        name=name,
        protocol=entry.protocol,
        unit=entry.headline.unit or entry.headline.label,
        means=np.array(block_means(scores, entry.protocol.block)),
    )


def gain(population: Population, submissions: int, *, repeats: int = REPEATS) -> float:
    """Return the mean of the best score of some submissions minus their true score."""
    best = [entry.mean() for entry, _ in _selections(population, submissions, repeats)]
    return float(np.mean(best) - population.means.mean())


def passes(population: Population, submissions: int, *, repeats: int = REPEATS) -> float:
    """Return how often an interval says that the best is better than one more submission.

    This is the comparison of two rows alone; the leaderboard's ranks are corrected for many.
    """
    intervals = [
        difference_interval(best.tolist(), other.tolist())
        for best, other in _selections(population, submissions, repeats)
    ]
    return sum(found is not None and found[0] > 0.0 for found in intervals) / repeats


def _selections(
    population: Population, submissions: int, repeats: int
) -> Iterator[tuple[Blocks, Blocks]]:
    """Yield the blocks of the best submission, and those of one that was not chosen."""
    random = np.random.default_rng(submissions)
    for _ in range(repeats):
        entries = random.choice(population.means, size=(submissions + 1, population.blocks))
        yield entries[entries[1:].mean(axis=1).argmax() + 1], entries[0]


def text(population: Population) -> str:
    """Return the table of one benchmark."""
    score, unit, protocol = float(population.means.mean()), population.unit, population.protocol
    rows = []
    for count in SUBMISSIONS:
        best, passed = gain(population, count), passes(population, count)
        share, in_errors = signed(100.0 * best / score), signed(best / population.error, 2)
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
            f"`{population.name}`, built-in `{SOLUTIONS[population.name]}`: score {score:.3f} "
            f"{unit}, standard error {population.error:.4f} with {protocol.fresh_trials} fresh "
            f"trials in blocks of {protocol.block}. Measured on {len(population.means)} blocks of "
            f"trials, seeds from {FIRST_SEED} on.",
            table(header, rows),
        ]
    )


def draw(populations: list[Population]) -> None:
    """Draw the gain against the number of submissions."""
    counts = sorted({round(count) for count in np.geomspace(1, SUBMISSIONS[-1], 14)})
    with figure(FIGURE) as axes:
        for colour, population in zip(COLOURS, populations, strict=False):
            gains = [gain(population, count) for count in counts]
            share = 100.0 * np.array(gains) / population.means.mean()
            axes.plot(counts, share, marker="o", color=colour, label=population.name)
        axes.set_xscale("log")
        axes.set_xlabel("submissions")
        axes.set_ylabel("gain of the best [% of the score]")
        axes.legend()


def main() -> None:
    """Print the tables and write the figure."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("benchmarks", nargs="*", default=list(SOLUTIONS))
    parser.add_argument("--trials", type=int, default=TRIALS)
    options = parser.parse_args()
    populations = [measured(name, options.trials) for name in options.benchmarks]
    print("\n\n".join(map(text, populations)), flush=True)
    draw(populations)


if __name__ == "__main__":
    main()
