"""The files that settings of runs name, looked up only where a setting does so."""

from collections import defaultdict
from collections.abc import Iterable, Mapping
from typing import Any

from sqlalchemy import select
from sqlalchemy.orm import Session
from sqlalchemy.orm.attributes import set_committed_value

from seamark.server.database.tables import Run, RunFile
from seamark.server.programs import own_files


def of_runs(
    session: Session, runs: Iterable[tuple[int, Mapping[str, Any]]]
) -> defaultdict[int, list[RunFile]]:
    """Return run -> files in the order of their settings, given runs with their configurations."""
    found: defaultdict[int, list[RunFile]] = defaultdict(list)
    run_ids = [run_id for run_id, config in runs if own_files.are_named(config)]
    if run_ids:  # by next to none, and lists are shown all the time
        query = select(RunFile).where(RunFile.run_id.in_(run_ids)).order_by(RunFile.setting)
        for file in session.scalars(query):
            found[file.run_id].append(file)
    return found


def load(session: Session, runs: Iterable[Run]) -> None:
    """Load the files of rows at once, rather than for each when it is asked for."""
    rows = list(runs)
    found = of_runs(session, ((run.id, run.config) for run in rows))
    for run in rows:
        set_committed_value(run, "files", found[run.id])
