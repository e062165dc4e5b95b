"""The further programs of runs, looked up only where the benchmark of a run has such parts."""

from collections import defaultdict
from collections.abc import Iterable

from sqlalchemy import select
from sqlalchemy.orm import Session
from sqlalchemy.orm.attributes import set_committed_value

from seamark.server.database.tables import Run, RunPart
from seamark.sim import registry


def of_runs(session: Session, runs: Iterable[tuple[int, str]]) -> defaultdict[int, list[RunPart]]:
    """Return run -> parts in the order of their roles, given runs with their benchmarks."""
    found: defaultdict[int, list[RunPart]] = defaultdict(list)
    run_ids = [run_id for run_id, benchmark in runs if _has_parts(benchmark)]
    if run_ids:  # of most benchmarks no run has parts, and lists are shown all the time
        query = select(RunPart).where(RunPart.run_id.in_(run_ids)).order_by(RunPart.role)
        for part in session.scalars(query):
            found[part.run_id].append(part)
    return found


def load(session: Session, runs: Iterable[Run]) -> None:
    """Load the parts of rows at once, rather than for each when it is asked for."""
    rows = list(runs)
    found = of_runs(session, ((run.id, run.benchmark) for run in rows))
    for run in rows:
        set_committed_value(run, "parts", found[run.id])


def _has_parts(benchmark: str) -> bool:
    return benchmark in registry.BENCHMARKS and bool(registry.benchmark(benchmark).parts)
