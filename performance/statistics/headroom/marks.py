"""The entries of a benchmark as a scale: their order, the steps between marks, and a figure."""

import os
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from performance.plots import figure
from performance.statistics.headroom.store import store, stored
from performance.tables import signed
from seamark.sim.numerics.statistics import mean, mean_interval, paired_interval
from seamark.sim.registry import benchmark

REFERENCE_TRIALS = 8
OTHER_TRIALS = 24
OTHER_SEED = 770_001  # trial i has this seed plus i

Steps = dict[str, tuple[float, float] | None]


class Job(NamedTuple):
    """One trial of one entry."""

    entry: str
    trial: int
    seed: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Measured:
    """What an entry scored."""

    title: str
    scores: Sequence[float]  # of all trials, the reference trials first
    overall: Mapping[str, float | None]  # of the trials with other seeds: the columns of the table
    success: Mapping[str, Sequence[tuple[float, float]]]  # of them: axis -> (level, share [%])

    @property
    def reference(self) -> float:
        """Return the score of the reference trials."""
        return mean(self.scores[:REFERENCE_TRIALS])

    @property
    def other(self) -> tuple[float, float]:
        """Return the score of the trials with other seeds, and the end of its interval."""
        scores = self.scores[REFERENCE_TRIALS:]
        interval = mean_interval(scores)
        return mean(scores), interval[1] if interval else mean(scores)


def jobs(name: str, entry: str) -> list[Job]:
    """Return the trials of an entry of a benchmark, the reference trials first."""
    known = [Job(entry, trial, reference_seed(name)) for trial in range(REFERENCE_TRIALS)]
    return known + [Job(entry, trial, OTHER_SEED + trial) for trial in range(OTHER_TRIALS)]


def reference_seed(name: str) -> int:
    """Return the seed of the reference trials of a benchmark."""
    protocol = benchmark(name).protocol
    return 0 if protocol is None else protocol.reference_seed


def known_entries(name: str) -> dict[str, Measured]:
    """Return what was measured of a benchmark, by the short names of the entries."""
    return {key: Measured(**one) for key, one in stored(name).items()}


def measure_and_store(
    name: str, entries: Collection[str], measure: Callable[[str, int], Measured]
) -> dict[str, Measured]:
    """Measure entries of a benchmark on all cores; return all that is known."""
    for key in entries:
        measured = measure(key, len(os.sched_getaffinity(0)))
        known = known_entries(name) | {key: measured}  # another process may have added some
        store(name, {name: asdict(one) for name, one in sorted(known.items())})
    return known_entries(name)


def ordered(results: Mapping[str, Measured]) -> list[str]:
    """Return the short names of the entries, lowest score first."""
    return sorted(results, key=lambda key: results[key].other[0])


def mark_steps(results: Mapping[str, Measured], marks: Collection[str]) -> Steps:
    """Return for each entry by how much it is better than the next mark with a lower score.

    The 95 % interval of the mean difference on the same trials, none of them a reference trial;
    None for the lowest.
    """
    steps: Steps = {}
    below: Measured | None = None
    for key in ordered(results):
        own = results[key].scores[REFERENCE_TRIALS:]
        steps[key] = paired_interval(own, below.scores[REFERENCE_TRIALS:]) if below else None
        if key in marks:
            below = results[key]
    return steps


def score_cells(one: Measured, mark: str, step: tuple[float, float] | None) -> tuple[str, ...]:
    """Return the cells that all tables begin with: entry, mark, scores and the step below."""
    score, high = one.other
    return (
        one.title,
        mark,
        f"{one.reference:.2f}",
        f"{score:.2f} ± {high - score:.2f}",
        "" if step is None else f"{signed(step[0], 3)} to {signed(step[1], 3)}",
    )


def number(value: float | None, digits: int) -> str:
    """Return a cell of a table."""
    return "-" if value is None else f"{value:.{digits}f}"


def rounded(value: float | None) -> float | None:
    """Return a metric as it is stored."""
    return None if value is None else round(value, 4)


def stability(results: Mapping[str, Measured], *, dishonest: Collection[str]) -> str:
    """Return how much the order of the honest entries changes with the trials."""
    honest = {key: one for key, one in results.items() if key not in dishonest}
    halves = [
        _order({key: one.scores[part] for key, one in honest.items()})
        for part in (
            slice(0, REFERENCE_TRIALS),
            slice(REFERENCE_TRIALS, None),
            slice(0, None, 2),
            slice(1, None, 2),
        )
    ]
    agree = [_agreement(halves[0], halves[1]), _agreement(halves[2], halves[3])]
    return (
        f"Pairs of {len(honest)} entries in the same order: {agree[0]:.0f} % with other seeds, "
        f"{agree[1]:.0f} % between the even and the odd trials."
    )


def _order(scores: dict[str, Sequence[float]]) -> list[str]:
    return sorted(scores, key=lambda key: float(np.mean(scores[key])))


def _agreement(first: list[str], second: list[str]) -> float:
    """Return the share of pairs [%] that two orders agree on."""
    place = {key: at for at, key in enumerate(second)}
    pairs = [(a, b) for at, a in enumerate(first) for b in first[at + 1 :]]
    return 100.0 * sum(place[a] < place[b] for a, b in pairs) / len(pairs)


def draw_headroom(
    results: Mapping[str, Measured], out: Path, *, score: str, highest: float
) -> None:
    """Draw the scores with their intervals, from 0 or below to the highest that is possible."""
    entries = [results[key] for key in ordered(results)]
    with figure(out, height=0.4 * len(entries) + 1.0) as axes:
        at = np.arange(len(entries))
        scores = [one.other[0] for one in entries]
        margins = [high - score for score, high in (one.other for one in entries)]
        axes.barh(at, scores, xerr=margins, color="#1d4ed8", alpha=0.75, height=0.6, capsize=3)
        known = [one.reference for one in entries]
        axes.plot(known, at, "o", color="#c2410c", label="reference trials")
        axes.set_yticks(at, [one.title for one in entries])
        axes.set_xlabel(f"{score}, mean and 95 % interval, other seeds")
        lowest = min(score - margin for score, margin in zip(scores, margins, strict=True))
        axes.set_xlim(min(0.0, 1.1 * lowest), highest + 0.2)
        axes.legend(loc="lower right")
