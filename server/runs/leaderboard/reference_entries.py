"""The reference entries of a benchmark: what this service has computed, else what Seamark ships."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

from sqlalchemy import ColumnElement, Row, Select, func, or_, select
from sqlalchemy.orm import Session

from seamark.server.accounts.accounts import RESERVED_PREFIX
from seamark.server.database.tables import (
    IS_BASELINE,
    IS_QUEUED,
    IS_RUNNING,
    Best,
    Result,
    Run,
    User,
)
from seamark.server.runs.record.solutions import solution
from seamark.sim import registry
from seamark.sim.benchmarks import reference_results
from seamark.sim.benchmarks.benchmark import Benchmark
from seamark.sim.benchmarks.reference_results import ReferenceResult

_ORACLE = "oracle"  # in the names of built-in solutions with perfect knowledge


@dataclass(frozen=True, slots=True, kw_only=True)
class ReferenceEntry:
    """A mark on the scale of a benchmark."""

    title: str
    score: float
    low: float  # 95 % interval of the score
    high: float
    is_bound: bool  # doing nothing, the oracle and the like: no solution that a run may use
    is_oracle: bool = False
    notes: str = ""  # such as how it was trained
    run_id: int | None = None  # None: shipped, and not computed by this service
    metrics: Mapping[str, float] = field(default_factory=dict)  # as a rank has them
    is_baseline: Literal[True] = True  # as rows of the leaderboard beside it


def entries(session: Session, benchmark: Benchmark) -> list[ReferenceEntry]:
    """Return the reference entries of a benchmark, the best first.

    A shipped result is over the trials on the public seed, one of this service over its own.
    """
    return _sorted(benchmark, session.execute(_rows().where(Best.benchmark == benchmark.name)))


def of_benchmarks(
    session: Session, benchmarks: Sequence[Benchmark]
) -> dict[str, list[ReferenceEntry]]:
    """Return name -> `entries` of some benchmarks, by one statement."""
    names = [benchmark.name for benchmark in benchmarks]
    rows = session.execute(_rows().where(Best.benchmark.in_(names))).all()
    return {
        benchmark.name: _sorted(benchmark, (row for row in rows if row.benchmark == benchmark.name))
        for benchmark in benchmarks
    }


def live_count(session: Session) -> int:
    """Return how many runs of reference entries are queued or running."""
    every = map(registry.benchmark, registry.BENCHMARKS)
    names = {name for benchmark in every for name in benchmark.baselines}
    return _live_count(session, names)


def are_pending(session: Session, benchmark: Benchmark, marks: Iterable[ReferenceEntry]) -> bool:
    """Return whether this service still computes some of `marks`, the entries of a benchmark."""
    if all(mark.run_id is not None for mark in marks):
        return False
    return bool(_live_count(session, benchmark.baselines, Run.benchmark == benchmark.name))


def deviations(session: Session) -> Iterator[tuple[str, int]]:
    """Iterate over title and run of the entries that differ from the shipped results.

    The water of the reference trials is the same everywhere, so any difference means that this
    service computes something else than the version that shipped the results.
    """
    query = (
        select(Best.benchmark, User.name, Best.run_id, Result.reference_scores)
        .join(User, User.id == Best.user_id)
        .join(Result, Result.run_id == Best.run_id)
        .where(IS_BASELINE)
    )
    for name, user, run_id, scores in session.execute(query):
        if name not in registry.BENCHMARKS or scores is None:
            continue
        benchmark = registry.benchmark(name)
        entry = user.removeprefix(f"{RESERVED_PREFIX}-")
        known: Mapping[str, ReferenceResult] = reference_results.of_benchmark(benchmark)
        if entry in known and list(known[entry].scores) != list(scores):
            yield f"{benchmark.title}: {benchmark.baselines[entry].title}", run_id


def _live_count(session: Session, names: Iterable[str], *which: ColumnElement[bool]) -> int:
    """Return how many runs of some entries are queued or running."""
    keys = [f"{RESERVED_PREFIX}-{name}" for name in names]
    owners = session.scalars(select(User.id).where(User.name_key.in_(keys))).all()
    if not owners:
        return 0
    live = select(func.count()).where(Run.user_id.in_(owners), or_(IS_QUEUED, IS_RUNNING), *which)
    return session.scalars(live).one()


def _rows() -> Select[*tuple[Any, ...]]:
    """Select what `_computed` needs. Columns alone: objects of the ORM take longer."""
    return (
        select(
            *(User.name.label("user"), Best.benchmark, Best.run_id, Best.metrics),
            *(Best.score, Best.score_low, Best.score_high),
            *(Run.title, Run.notes, Run.config, Run.controller, Run.program_name),
        )
        .join(User, User.id == Best.user_id)
        .join(Run, Run.id == Best.run_id)
        .where(IS_BASELINE)
    )


def _sorted(benchmark: Benchmark, rows: Iterable[Row[*tuple[Any, ...]]]) -> list[ReferenceEntry]:
    """Return the entries of a benchmark from their rows and, where there is none, the shipped."""
    here = {row.user.removeprefix(f"{RESERVED_PREFIX}-"): _computed(benchmark, row) for row in rows}
    shipped = {
        name: _shipped(benchmark, name, result)
        for name, result in reference_results.of_benchmark(benchmark).items()
        if name in benchmark.baselines and name not in here
    }
    return sorted((shipped | here).values(), key=lambda entry: entry.score, reverse=True)


def _computed(benchmark: Benchmark, row: Row[*tuple[Any, ...]]) -> ReferenceEntry:
    return ReferenceEntry(
        title=row.title or solution(row),
        score=row.score,
        low=row.score_low,
        high=row.score_high,
        is_bound=row.controller in benchmark.reference_built_in,
        is_oracle=_ORACLE in row.controller,
        notes=row.notes,
        run_id=row.run_id,
        metrics=row.metrics or {},
    )


def _shipped(benchmark: Benchmark, name: str, result: ReferenceResult) -> ReferenceEntry:
    baseline = benchmark.baselines[name]
    low, high = result.interval(benchmark)
    return ReferenceEntry(
        title=baseline.title,
        score=result.score,
        low=low,
        high=high,
        is_bound=baseline.built_in in benchmark.reference_built_in,
        is_oracle=_ORACLE in baseline.built_in,
        notes=baseline.notes,
        metrics=result.metrics,
    )
