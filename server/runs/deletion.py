"""Deleting runs: nobody sees them again, their files go, and an empty row stays.

It is the only way in which a run is deleted, also that of a closed account (account_deletion.py).
The row keeps when and by whom it was submitted and how it ended. Quotas, the number of ranked
submissions and the rule that the first run of a submission counts need no more, and must not be
evaded by deleting runs; nor is a number ever given to a second run.
"""

import time
from collections.abc import Collection
from pathlib import Path

from sqlalchemy import delete as delete_rows
from sqlalchemy import func, update
from sqlalchemy.orm import Session

from seamark.server.database.class_tables import AssignedRun
from seamark.server.database.engine import Database
from seamark.server.database.tables import Result, Run
from seamark.server.runs import retention
from seamark.server.runs.states import FINAL

WHY_NOT = "Only private runs that have ended can be deleted: cancel a run or make it private first."


def delete(database: Database, data: Path, run_ids: Collection[int]) -> list[int]:
    """Delete those of these runs that have ended and are private; return which."""
    with database.writing() as session:
        deleted = empty(session, run_ids)
    remove_files(data, deleted)
    return deleted


def remove_files(data: Path, run_ids: Collection[int]) -> None:
    """Remove the files of deleted runs, after the transaction that emptied their rows."""
    for run_id in run_ids:
        retention.remove_files(data, run_id)


def empty(session: Session, run_ids: Collection[int]) -> list[int]:
    """Empty the rows, where that is allowed, and return which; no assignment counts them then."""
    now = time.time()
    deletable = (Run.state.in_(FINAL), Run.public.is_(False), Run.deleted_at.is_(None))
    change = update(Run).where(Run.id.in_(run_ids), *deletable)
    change = change.values(
        deleted_at=now,
        data_deleted_at=func.coalesce(Run.data_deleted_at, now),
        data_bytes=0,
        data_measured=True,
        **{"title": "", "notes": "", "program_name": None, "config": {}, "detail": {}},
    )
    deleted = session.scalars(change.returning(Run.id)).all()
    numbers = ("score", "score_low", "score_high", "level_held", "reference_scores")
    nothing = dict.fromkeys((*numbers, "not_ranked", "metrics", "manifest", "error_curve"))
    results = update(Result).where(Result.run_id.in_(deleted))
    session.execute(results.values(rankable=False, **nothing))  # the digest stays
    session.execute(delete_rows(AssignedRun).where(AssignedRun.run_id.in_(deleted)))
    return sorted(deleted)
