"""Comparison of ranked runs, trial by trial: the paired difference on their reference trials.

What the trials have in common cancels out, so that small differences show. It does not decide
ranks, since reference trials are public and a solution could be fitted to them.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from sqlalchemy import Select, select
from sqlalchemy.orm import Session

from seamark.server.database.tables import IS_BASELINE, Best, Result, Run
from seamark.server.runs.record.states import RunKind, RunState
from seamark.server.runs.record.trial_scores import block_of
from seamark.sim.benchmarks.benchmark import Benchmark
from seamark.sim.numerics.statistics import mean, paired_interval


@dataclass(frozen=True, slots=True, kw_only=True)
class Comparison:
    """How much higher the score of a run is than that of another one on the same trials."""

    other_id: int
    title: str  # of the other run
    trials: int
    difference: float  # in the unit of the benchmark's score
    low: float | None  # of the 95 % interval, None for a single block of trials
    high: float | None


@dataclass(frozen=True, slots=True)
class ReferenceEntry:
    """A run of the service's own on the leaderboard, such as P."""

    run_id: int
    title: str
    score: float


def reference_entries(session: Session, benchmark: Benchmark) -> list[ReferenceEntry]:
    """Return the reference entries of a benchmark that are public, in their declared order."""
    query = select(Best, Run).join(Run, Run.id == Best.run_id)
    query = query.where(Best.benchmark == benchmark.name, IS_BASELINE)
    rows = {run.title: (best, run) for best, run in session.execute(query)}
    titles = [baseline.title for baseline in benchmark.baselines.values()]
    order = sorted(rows, key=lambda title: titles.index(title) if title in titles else len(titles))
    return [ReferenceEntry(rows[title][1].id, title, rows[title][0].score) for title in order]


def comparisons(session: Session, run_id: int, *, with_previous: bool) -> list[Comparison]:
    """Compare a run with the baselines of its benchmark, the best first.

    Parameters
    ----------
    with_previous
        Put the user's previous ranked run of the benchmark before them, also a private one.
    """
    row = session.execute(_runs().where(Run.id == run_id)).one_or_none()
    if row is None:
        return []
    run, own = row
    baselines = (
        _runs()
        .join(Best, Best.run_id == Run.id)
        .where(Best.benchmark == run.benchmark, IS_BASELINE, Run.id != run.id)
        .order_by(Best.score.desc())
    )
    compared = [_comparison(run, own, other, its) for other, its in session.execute(baselines)]
    previous = session.execute(_previous(run)).one_or_none() if with_previous else None
    if previous is not None and (earlier := _comparison(run, own, *previous)) is not None:
        compared.insert(0, replace(earlier, title=f"Your previous run: {earlier.title}"))
    return [each for each in compared if each is not None]


def _runs() -> Select[Run, list[float] | None]:
    return (
        select(Run, Result.reference_scores)
        .join(Result, Result.run_id == Run.id)
        .where(Run.kind == RunKind.RANKED, Run.state == RunState.SUCCEEDED)
        .where(Result.reference_scores.is_not(None), Run.deleted_at.is_(None))
    )


def _previous(run: Run) -> Select[Run, list[float] | None]:
    mine = _runs().where(Run.user_id == run.user_id, Run.benchmark == run.benchmark)
    return mine.where(Run.id < run.id).order_by(Run.id.desc()).limit(1)


def _comparison(
    run: Run, own: Sequence[float] | None, other: Run, its: Sequence[float] | None
) -> Comparison | None:
    if not own or not its or len(own) != len(its):
        return None
    low, high = paired_interval(own, its, block=block_of(run.benchmark)) or (None, None)
    return Comparison(
        other_id=other.id,
        title=other.title or other.program_name or other.controller,
        trials=len(own),
        difference=mean(own) - mean(its),
        low=low,
        high=high,
    )
