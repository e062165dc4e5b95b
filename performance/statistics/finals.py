"""How often the ranges of ranks of a final are false, and how soon its ranks separate.

Finals are drawn from fields of which the true ranks are known: synthetic ones, and the measured
trials of entries that ran on the same seeds (docs/headroom.json), drawn with replacement. Each
final looks at its scores after every batch and ends when its ranks separate. The same fields are
held with trials of each finalist's own, so that nothing cancels out in a difference, and without
the correction for looks.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from performance.statistics.headroom.store import stored
from performance.tables import markdown_table
from seamark.competitions.standings import Finalist, Standings, Ties, decide
from seamark.server.runs.record.trial_scores import block_of
from seamark.sim.numerics.arrays import Array

FINALS = 400
BATCHES = 5
BLOCKS = 12  # of a batch
SEED = 20261129
BOUNDS = frozenset({"nothing", "blind", "oracle"})
MEASURED = ("currents-v3", "currents-v2", "track-v1", "recover-v1")  # on one seed each
Draw = Callable[[np.random.Generator, int], Array]  # blocks -> (finalists, blocks)


@dataclass(frozen=True, slots=True)
class Field:
    """The finalists of one kind of final: their expected scores, and how scores are drawn."""

    name: str
    truth: Array
    draw: Draw  # on the same trials for all

    def drawn_apart(self, generator: np.random.Generator, blocks: int) -> Array:
        """Return scores, (finalists, blocks), of which each row has trials of its own."""
        return np.array([self.draw(generator, blocks)[at] for at in range(len(self.truth))])


class Outcome(NamedTuple):
    """What came of many finals, in percent unless another unit is said."""

    false_ranges: float
    finals_with_one: float
    separated: float
    batches: float  # mean
    ranks: float  # mean in a range


def normal(name: str, truth: Sequence[float]) -> Field:
    """Return a field whose trials are mostly alike for all: a standard deviation of 1, and 0.3."""

    def draw(generator: np.random.Generator, blocks: int) -> Array:
        water = generator.normal(0.0, 1.0, blocks)
        return np.array(truth)[:, None] + water + generator.normal(0.0, 0.3, (len(truth), blocks))

    return Field(name, np.array(truth), draw)


def skewed(name: str, truth: Sequence[float]) -> Field:
    """Return a field in which now and then a trial of a finalist goes wrong: skewness -2."""

    def draw(generator: np.random.Generator, blocks: int) -> Array:
        water = generator.normal(0.0, 1.0, blocks)
        luck = 0.3 - generator.gamma(1.0, 0.3, (len(truth), blocks))
        return np.array(truth)[:, None] + water + luck

    return Field(name, np.array(truth), draw)


def measured(benchmark: str) -> Field:
    """Return the entries of a benchmark that are no bounds, with their measured blocks."""
    entries = {name: one for name, one in stored(benchmark).items() if name not in BOUNDS}
    scores = np.array([one["scores"] for one in entries.values()])
    table: Array = np.mean(scores.reshape(len(entries), -1, block_of(benchmark)), axis=2)

    def draw(generator: np.random.Generator, blocks: int) -> Array:
        picks: Array = table[:, generator.integers(table.shape[1], size=blocks)]
        return picks

    return Field(f"{benchmark}, {len(entries)} entries", np.mean(table, axis=1), draw)


def held(scores: Array, *, looks: int, blocks: int = BLOCKS) -> tuple[Standings, int]:
    """Return how a final ends, and after how many batches.

    Parameters
    ----------
    scores
        (finalists, blocks) of all batches that there may be.
    looks
        What the correction takes into account: the number of batches, or 1 for none.
    """
    batches = scores.shape[1] // blocks
    for batch in range(1, batches + 1):
        rows = scores[:, : batch * blocks].tolist()
        finalists = [
            Finalist(key=at, submitted_at=float(at), scores=row) for at, row in enumerate(rows)
        ]
        standings = decide(finalists, block=1, looks=looks, ties=Ties.EARLIER)
        if standings.separated:
            break
    return standings, batch


def outcome(
    field: Field,
    *,
    paired: bool = True,
    looks: int | None = None,
    batches: int = BATCHES,
    finals: int = FINALS,
) -> Outcome:
    """Return what came of finals that correct for `looks`, by default for all that there may be."""
    generator = np.random.default_rng(SEED)
    draw = field.draw if paired else field.drawn_apart
    true = [1 + int(np.sum(field.truth > own)) for own in field.truth]
    false, separated, took, width = [], 0, 0, 0
    for _ in range(finals):
        scores = draw(generator, batches * BLOCKS)
        standings, batch = held(scores, looks=batches if looks is None else looks)
        ranges = [(one.key, one.place_low or 0, one.place_high or 0) for one in standings.placings]
        false.append(sum(not low <= true[key] <= high for key, low, high in ranges))
        width += sum(1 + high - low for _, low, high in ranges)
        separated += standings.separated
        took += batch
    count = finals * len(true)
    return Outcome(
        false_ranges=100.0 * sum(false) / count,
        finals_with_one=100.0 * sum(map(bool, false)) / finals,
        separated=100.0 * separated / finals,
        batches=took / finals,
        ranks=width / count,
    )


FIELDS = (
    normal("2 equal finalists", [0.0] * 2),
    normal("6 equal finalists", [0.0] * 6),
    normal("8 finalists, 0.2 apart", [0.2 * at for at in range(8)]),
    skewed("8 finalists, 0.2 apart, skewed", [0.2 * at for at in range(8)]),
    *map(measured, MEASURED),
)


def table() -> str:
    """Return the table of all fields, on the same trials and on trials of each finalist's own."""
    rows = []
    for field in FIELDS:
        same, own = outcome(field), outcome(field, paired=False)
        shares = (f"{same.false_ranges:.1f}", f"{same.finals_with_one:.1f}")
        ends = [
            figure
            for came in (same, own)
            for figure in (f"{came.ranks:.2f}", f"{came.batches:.1f}", f"{came.separated:.0f}")
        ]
        rows.append((field.name, *shares, *ends))
    header = ("finalists", "false ranges [%]", "finals with one [%]", "ranks in a range", "batches")
    own_header = ("on trials of their own: ranks in a range", "batches", "separated [%]")
    return markdown_table((*header, "separated [%]", *own_header), rows)


def often() -> str:
    """Return the table of equal finalists and many looks, with the correction and without."""
    rows = []
    for number in (2, 20):
        field = normal(f"{number} equal finalists", [0.0] * number)
        for batches in (1, 5, 20):
            with_it = outcome(field, batches=batches)
            without = outcome(field, batches=batches, looks=1)
            shares = (with_it.false_ranges, without.false_ranges, with_it.finals_with_one)
            rows.append((field.name, batches, *(f"{share:.1f}" for share in shares)))
    header = ("finalists", "batches at most", "false ranges [%]", "without the correction [%]")
    return markdown_table((*header, "finals with a false range [%]"), rows)


def main(_arguments: Sequence[str]) -> int:
    """Print the tables."""
    print(table(), flush=True)
    print()
    print(often())
    return 0
