"""Deleting an account: at once what identifies a person, then its private runs in batches.

1. `close` removes name, password, tokens, browsers, classes and memberships, cancels what is live
   and, if asked, withdraws what is published. It takes a bounded time, however many runs there are.
2. `step` deletes private runs, a batch at a time: rows, files and, with the next sweep, programs.
3. When none is left, the account goes too, unless it still has published runs: they stay with the
   name `Deleted user <number>`.
"""

import shutil
import time
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from sqlalchemy import ColumnElement, delete, func, select, update
from sqlalchemy.orm import Session

from seamark.server.accounts.permissions import Role, Viewer
from seamark.server.accounts.profiles import Profile
from seamark.server.database.account_tables import AccountDeletion, PasswordReset
from seamark.server.database.class_tables import Classroom, Membership
from seamark.server.database.engine import Database
from seamark.server.database.tables import (
    Best,
    BrowserSession,
    Check,
    Invitation,
    Run,
    Token,
    User,
)
from seamark.server.runs import leaderboard, results
from seamark.server.runs.files import RunFiles
from seamark.server.runs.states import LIVE

BATCH = 50  # runs that one transaction deletes


def close(session: Session, user_id: int, *, keep_published: bool) -> None:
    """Close an account for good; nobody can sign in to it any more."""
    live = select(Run.id).where(_own(user_id), Run.state.in_(LIVE))
    for run_id in session.scalars(live).all():
        results.cancel(session, run_id)
    if not keep_published:
        _withdraw_all(session, user_id)
    for table in (Token, BrowserSession, Invitation, Check, Membership, PasswordReset):
        session.execute(delete(table).where(table.user_id == user_id))
    session.execute(delete(Classroom).where(Classroom.teacher_id == user_id))
    # No name that a person may choose has a space, so nobody can have this one.
    name = f"Deleted user {user_id}"
    anonymous = {"name": name, "name_key": name.casefold(), "password_hash": None}
    profile = asdict(Profile())
    change = update(User).where(User.id == user_id)
    session.execute(change.values(**anonymous, **profile, role=Role.USER.label))
    session.add(AccountDeletion(user_id=user_id, requested_at=time.time()))


def step(database: Database, data: Path) -> bool:
    """Delete the next batch of runs of a closed account; False if there was nothing to do."""
    with database.writing() as session:
        user_id = session.scalar(
            select(AccountDeletion.user_id).order_by(AccountDeletion.requested_at).limit(1)
        )
        if user_id is None:
            return False
        private = select(Run.id).where(_own(user_id), Run.public.is_(False))
        ended = private.where(Run.state.not_in(LIVE)).order_by(Run.id).limit(BATCH)
        run_ids = list(session.scalars(ended))
        _delete_rows(session, run_ids)
        done = session.scalar(private.limit(1)) is None
        if done:
            _complete(session, user_id)
    for run_id in run_ids:
        shutil.rmtree(RunFiles(data, run_id).root, ignore_errors=True)
    return done or bool(run_ids)


def _own(user_id: int) -> ColumnElement[bool]:
    return Run.owner == (Viewer(user_id=user_id).owner or "")


def _withdraw_all(session: Session, user_id: int) -> None:
    """Make all runs private in one statement, then take the account off each leaderboard."""
    boards = session.scalars(select(Best.benchmark).where(Best.user_id == user_id)).all()
    public = update(Run).where(_own(user_id), Run.public)
    session.execute(public.values(public=False, published_at=None))
    for benchmark in boards:
        leaderboard.refresh(session, benchmark, user_id)


def _delete_rows(session: Session, run_ids: Sequence[int]) -> None:
    newest = session.scalar(select(func.max(Run.id)))
    session.execute(delete(Run).where(Run.id.in_(run_ids), Run.id != newest))
    # SQLite would give its number to the next run, so the newest stays as an empty row.
    kept = update(Run).where(Run.id.in_(run_ids))
    session.execute(
        kept.values(
            owner="deleted",
            user_id=None,
            title="",
            notes="",
            program_name=None,
            program_sha256=None,
            data_bytes=0,
            data_measured=True,
            data_deleted_at=time.time(),
        )
    )


def _complete(session: Session, user_id: int) -> None:
    """End a deletion; the account goes with it unless published runs need their owner."""
    session.execute(delete(AccountDeletion).where(AccountDeletion.user_id == user_id))
    if session.scalar(select(Run.id).where(_own(user_id)).limit(1)) is None:
        session.execute(delete(User).where(User.id == user_id))
