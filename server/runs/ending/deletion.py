"""Deleting runs: nobody sees them again, their files go, and an empty row stays.

It is the only way in which a run is deleted, also that of a closed account (account_deletion.py).
The row keeps when and by whom it was submitted and how it ended. Quotas, the number of ranked
submissions and the rule that the first run of a submission counts need no more, and must not be
evaded by deleting runs; nor is a number ever given to a second run.
"""

import time
from collections.abc import Collection, Sequence

from sqlalchemy import ColumnElement, func, select, update
from sqlalchemy import delete as delete_rows
from sqlalchemy.orm import Session

from seamark.server.database.class_tables import AssignedRun
from seamark.server.database.engine import Database
from seamark.server.database.tables import IS_LISTED, Result, Run, RunPart
from seamark.server.runs.data import retention
from seamark.server.runs.ending import results
from seamark.server.runs.recomputation import rejudged
from seamark.server.runs.record.states import FINAL
from seamark.server.settings import Settings

WHY_NOT = "Only private runs that have ended can be deleted: cancel a run or make it private first."


def delete(database: Database, settings: Settings, run_ids: Collection[int]) -> list[int]:
    """Delete those of these runs that have ended and are private; return which."""
    with database.writing() as session:
        deleted = empty(session, run_ids)
    remove_files(settings, deleted)
    return deleted


def remove_files(settings: Settings, run_ids: Collection[int]) -> None:
    """Remove the files of deleted runs, after the transaction that emptied their rows."""
    for run_id in run_ids:
        retention.remove_files(settings, run_id)


def empty(session: Session, run_ids: Collection[int]) -> list[int]:
    """Empty the rows, where that is allowed, and return which; no assignment counts them then."""
    deletable = (Run.state.in_(FINAL), Run.public.is_(False), Run.deleted_at.is_(None), IS_LISTED)
    deleted = _empty(session, run_ids, *deletable)
    again = session.scalars(select(Run.id).where(Run.rejudges.in_(deleted))).all()
    for run_id in again:
        results.cancel(session, run_id)
    _empty(session, again)
    rejudged.forget(session, deleted)
    session.execute(delete_rows(AssignedRun).where(AssignedRun.run_id.in_(deleted)))
    return sorted(deleted)


def _empty(
    session: Session, run_ids: Collection[int], *deletable: ColumnElement[bool]
) -> Sequence[int]:
    """Empty rows of runs and their results, those that are deletable, and return which."""
    now = time.time()
    change = update(Run).where(Run.id.in_(run_ids), *deletable)
    change = change.values(
        deleted_at=now,
        data_deleted_at=func.coalesce(Run.data_deleted_at, now),
        data_bytes=0,
        data_measured=True,
        **{
            "title": "",
            "notes": "",
            "method": "",
            "program_name": None,
            "config": {},
            "detail": {},
        },
    )
    deleted = session.scalars(change.returning(Run.id)).all()
    numbers = ("score", "score_low", "score_high", "level_held", "reference_scores")
    nothing = dict.fromkeys((*numbers, "not_ranked", "metrics", "manifest", "error_curve"))
    emptied = update(Result).where(Result.run_id.in_(deleted))
    session.execute(emptied.values(rankable=False, **nothing))  # the digest stays
    parts = update(RunPart).where(RunPart.run_id.in_(deleted))
    session.execute(parts.values(program_name=None, program_parameters=None))
    return deleted
