"""What the students of a class made of an assignment: their best runs, counts, ranking."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import Select, distinct, func, select
from sqlalchemy.orm import Session

from seamark.server.classes import classrooms
from seamark.server.classes.classrooms import Pupil
from seamark.server.database.class_tables import AssignedRun, Membership
from seamark.server.database.tables import Result, Run
from seamark.server.programs import starter_programs

RANKING_MAX = 100  # places that the anonymous ranking shows
OWN_RUNS_MAX = 100  # of one student on the page of an assignment


@dataclass(frozen=True, slots=True, kw_only=True)
class AssignedRunView:
    """A run that was submitted for an assignment, with its result if it has one."""

    run_id: int
    user_id: int
    state: str
    program: str
    is_starter: bool  # the starter program, unchanged
    seed: int | None  # None: ranked
    queued_at: float
    score: float | None
    score_low: float | None
    score_high: float | None
    level_held: float | None
    overall: dict[str, Any]  # metrics over all levels


@dataclass(frozen=True, slots=True)
class PupilProgress:
    """A student's runs for an assignment. `best` is None until one has succeeded."""

    pupil: Pupil
    runs: int
    best: AssignedRunView | None


@dataclass(frozen=True, slots=True)
class Totals:
    """Of a class: students, those who have submitted a run, those who have a score, and runs."""

    pupils: int
    started: int
    scored: int
    runs: int


@dataclass(frozen=True, slots=True)
class Place:
    """A line of the anonymous ranking; equal scores share a place."""

    place: int
    score: float
    is_own: bool


def page(
    session: Session, class_id: int, assignment_id: int, *, after: str = ""
) -> list[PupilProgress]:
    """Return the next students in the order of their names, as many as fit a page.

    Three queries, whatever the numbers of students and runs.
    """
    listed = classrooms.pupils(session, class_id, after=after)
    ids = [pupil.user_id for pupil in listed]
    of_page = (AssignedRun.assignment_id == assignment_id, AssignedRun.user_id.in_(ids))
    counts = select(AssignedRun.user_id, func.count()).where(*of_page).group_by(AssignedRun.user_id)
    runs = {user_id: count for user_id, count in session.execute(counts)}
    best = _best_runs(session, assignment_id, ids)
    return [
        PupilProgress(pupil, runs.get(pupil.user_id, 0), best.get(pupil.user_id))
        for pupil in listed
    ]


def totals(session: Session, class_id: int, assignment_id: int) -> Totals:
    """Count over the present students of a class."""
    pupils = select(func.count()).where(Membership.class_id == class_id)
    counts = (
        select(
            func.count(distinct(AssignedRun.user_id)),
            func.count(distinct(AssignedRun.user_id)).filter(AssignedRun.score.is_not(None)),
            func.count(),
        )
        .join(Membership, Membership.user_id == AssignedRun.user_id)
        .where(AssignedRun.assignment_id == assignment_id, Membership.class_id == class_id)
    )
    started, scored, runs = session.execute(counts).one()
    return Totals(session.scalar(pupils) or 0, started, scored, runs)


def own_runs(session: Session, assignment_id: int, user_id: int) -> list[AssignedRunView]:
    """Return an account's runs for an assignment, newest first."""
    own = (AssignedRun.assignment_id == assignment_id, AssignedRun.user_id == user_id)
    return _runs(session, _with_result().where(*own).order_by(Run.id.desc()).limit(OWN_RUNS_MAX))


def ranking(
    session: Session, class_id: int, assignment_id: int, user_id: int | None
) -> list[Place]:
    """Return the best scores of the students, best first, without names; one's own is marked."""
    best = (
        select(AssignedRun.user_id, func.max(AssignedRun.score).label("score"))
        .join(Membership, Membership.user_id == AssignedRun.user_id)
        .where(AssignedRun.assignment_id == assignment_id, Membership.class_id == class_id)
        .where(AssignedRun.score.is_not(None))
        .group_by(AssignedRun.user_id)
        .subquery()
    )
    place = func.rank().over(order_by=best.c.score.desc()).label("place")
    places = select(place, best.c.score, best.c.user_id).subquery()
    shown = select(places).where(
        (places.c.place <= RANKING_MAX) | (places.c.user_id == (user_id or 0))
    )
    order = (places.c.place, places.c.user_id != (user_id or 0))
    rows = session.execute(shown.order_by(*order).limit(RANKING_MAX + 1))
    return [Place(row.place, row.score, row.user_id == user_id) for row in rows]


def _best_runs(
    session: Session, assignment_id: int, user_ids: Sequence[int]
) -> dict[int, AssignedRunView]:
    """Return the best run of each of these accounts; of equal scores the first."""
    order = (AssignedRun.score.desc(), AssignedRun.run_id)
    number = func.row_number().over(partition_by=AssignedRun.user_id, order_by=order)
    scored = (
        select(AssignedRun.run_id, number.label("number"))
        .where(AssignedRun.assignment_id == assignment_id, AssignedRun.user_id.in_(user_ids))
        .where(AssignedRun.score.is_not(None))
        .subquery()
    )
    first = select(scored.c.run_id).where(scored.c.number == 1)
    runs = _runs(session, _with_result().where(AssignedRun.run_id.in_(first)))
    return {run.user_id: run for run in runs}


def _with_result() -> Select[Run, Result | None]:
    return (
        select(Run, Result)
        .join(AssignedRun, AssignedRun.run_id == Run.id)
        .outerjoin(Result, Result.run_id == Run.id)
    )


def _runs(session: Session, query: Select[Run, Result | None]) -> list[AssignedRunView]:
    return [_view(run, result) for run, result in session.execute(query)]


def _view(run: Run, result: Result | None) -> AssignedRunView:
    metrics = (result.metrics if result is not None else None) or {}
    return AssignedRunView(
        run_id=run.id,
        user_id=run.user_id or 0,
        state=run.state,
        program=run.program_name or run.controller,
        is_starter=starter_programs.is_untouched(run.program_sha256),
        seed=run.seed,
        queued_at=run.queued_at,
        score=result.score if result is not None else None,
        score_low=result.score_low if result is not None else None,
        score_high=result.score_high if result is not None else None,
        level_held=result.level_held if result is not None else None,
        overall=metrics.get("overall") or {},
    )
