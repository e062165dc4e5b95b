"""The plot of the history of a rank."""

import time
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from seamark.server.database.publication_tables import RankPoint
from seamark.server.pages.charts.plots import Axis

Step = tuple[float, float, float, float | None]  # from x, y to x; then to y if another step follows


@dataclass(frozen=True, slots=True)
class RankPlot:
    """Steps of a rank over time, in percent of the plot."""

    ranks: Axis  # downwards
    ticks: Sequence[int]
    steps: Sequence[Step]
    begin: float  # [s since 1970]
    sentence: str


def rank_plot(points: Sequence[RankPoint], rank: int | None) -> RankPlot | None:
    """Return the plot of stored points and the present rank; None without any rank.

    Parameters
    ----------
    points
        Oldest first. A point without a rank is a gap.
    rank
        The present one.
    """
    known = [(point.at, point.rank) for point in points]
    if rank is not None:
        known.append((max(time.time(), known[-1][0] if known else 0.0), rank))
    held = [value for _, value in known if value is not None]
    if len(known) < 2 or not held:
        return None
    times = Axis.over(at for at, _ in known)
    ranks = Axis(min(held), max(held)) if min(held) < max(held) else Axis(held[0] - 1, held[0] + 1)
    ticks = [int(tick) for tick in ranks.ticks() if tick >= 1.0 and tick.is_integer()]
    return RankPlot(ranks, ticks, _steps(known, times, ranks), known[0][0], _sentence(held))


def _steps(known: Sequence[tuple[float, int | None]], times: Axis, ranks: Axis) -> list[Step]:
    steps: list[Step] = []
    for (begin, rank), (end, following) in pairwise(known):
        if rank is not None:
            to = None if following is None else ranks.at(following)
            steps.append((times.at(begin), ranks.at(rank), times.at(end), to))
    return steps


def _sentence(held: Sequence[int]) -> str:
    return f"first {held[0]}, best {min(held)}, last {held[-1]}"
