"""Finals of which the expected scores are known, drawn from fixed seeds."""

from collections.abc import Iterator, Sequence

import numpy as np

from seamark.competitions.standings import Finalist, Standings, Ties, decide
from seamark.sim.numerics.arrays import Array


def finalists(rows: Sequence[Sequence[float] | None]) -> list[Finalist]:
    """Return finalists with their place in the list as key and as time of submission."""
    return [
        Finalist(key=at, submitted_at=float(at), scores=scores) for at, scores in enumerate(rows)
    ]


def drawn(generator: np.random.Generator, skills: Sequence[float], trials: int) -> Array:
    """Return scores, (finalists, trials): what a trial has in common varies most."""
    water = generator.normal(0.0, 1.0, trials)
    return np.array(skills)[:, None] + water + generator.normal(0.0, 0.5, (len(skills), trials))


def held(scores: Array, *, batch: int, looks: int) -> Standings:
    """Return the standings of a final that ends when its ranks separate, or with the last batch.

    `looks` is what the correction takes into account, not the number of batches that there are.
    """
    standings: Standings
    for trials in range(batch, scores.shape[1] + 1, batch):
        rows = finalists(scores[:, :trials].tolist())
        standings = decide(rows, block=1, looks=looks, ties=Ties.EARLIER)
        if standings.separated:
            break
    return standings


def false_ranges(
    skills: Sequence[float], *, finals: int, batches: int, batch: int, looks: int
) -> Iterator[bool]:
    """Yield for each finalist of each final whether its range misses its true rank."""
    generator = np.random.default_rng(20261129)
    true = [1 + sum(other > own for other in skills) for own in skills]
    for _ in range(finals):
        standings = held(drawn(generator, skills, batches * batch), batch=batch, looks=looks)
        for placing in standings.placings:
            low, high = placing.place_low or 0, placing.place_high or 0
            yield not low <= true[placing.key] <= high
