"""The runs of a class for an assignment as CSV: for each student the best one with its metrics."""

from collections.abc import Iterator, Sequence
from typing import Any

from seamark.server.classes import progress
from seamark.server.classes.assignments import AssignmentView
from seamark.server.classes.classrooms import PAGE
from seamark.server.classes.progress import PupilProgress
from seamark.server.database.engine import Database
from seamark.server.web import csv_export
from seamark.server.web.template_filters import iso
from seamark.sim import registry

COLUMNS = (
    *("pupil", "runs", "best_run", "program", "is_starter", "seed", "submitted_at"),
    *("score", "score_low", "score_high", "level_held"),
)


def lines(database: Database, assignment: AssignmentView) -> Iterator[str]:
    """Yield the CSV page by page: no transaction stays open while a slow client reads."""
    benchmark = registry.benchmark(assignment.benchmark)
    metrics = [metric.name for metric in benchmark.overall if metric.name not in COLUMNS]
    columns = (*COLUMNS, *metrics)
    yield csv_export.lines(columns, ())
    after = ""
    while True:
        with database.reading() as session:
            listed = progress.page(session, assignment.class_id, assignment.id, after=after)
        rows = (_row(each, columns) for each in listed)
        yield csv_export.lines(columns, rows, header=False)
        if len(listed) < PAGE:
            return
        after = listed[-1].pupil.name


def _row(pupil: PupilProgress, columns: Sequence[str]) -> dict[str, Any]:
    row: dict[str, Any] = dict.fromkeys(columns)
    row |= {"pupil": pupil.pupil.name, "runs": pupil.runs}
    best = pupil.best
    if best is None:
        return row
    row |= {name: best.overall.get(name) for name in columns[len(COLUMNS) :]}
    same = ("program", "is_starter", "seed", "score", "score_low", "score_high", "level_held")
    row |= {name: getattr(best, name) for name in same}
    return row | {"best_run": best.run_id, "submitted_at": iso(best.queued_at)}
