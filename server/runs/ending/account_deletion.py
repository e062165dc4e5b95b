"""Deleting an account: at once what identifies a person, then its private runs in batches.

1. `close` removes name, password, tokens, browsers, classes and memberships, cancels what is live
   and, if asked, withdraws what is published. Teams keep their entries, and competitions go on. It
   takes a bounded time, however many runs there are.
2. `step` deletes private runs as their owner would (deletion.py), a batch at a time.
3. When none is left, the account and the empty rows go too, unless it still has published runs:
   they stay with the name `Deleted user <number>`.
"""

import time
from dataclasses import asdict

from sqlalchemy import ColumnElement, delete, func, select, update
from sqlalchemy.orm import Session

from seamark.server.accounts.permissions import Role, Viewer
from seamark.server.accounts.profiles import Profile
from seamark.server.competitions import teams
from seamark.server.database.account_tables import AccountDeletion, LinkedIdentity, PasswordReset
from seamark.server.database.class_tables import Classroom, Membership
from seamark.server.database.engine import Database
from seamark.server.database.mail_tables import MailAddress, OutgoingMail, RunNotice
from seamark.server.database.submission_tables import KeyOfSubmission
from seamark.server.database.tables import (
    BrowserSession,
    Check,
    Invitation,
    Run,
    RunFile,
    RunPart,
    Token,
    User,
)
from seamark.server.runs.ending import deletion, results
from seamark.server.runs.publication import publications
from seamark.server.runs.record.states import LIVE
from seamark.server.settings import Settings

BATCH = 50  # runs that one transaction deletes, with their files
ROWS = 500  # empty rows that one transaction deletes


def close(session: Session, user_id: int, *, keep_published: bool) -> None:
    """Close an account for good; nobody can sign in to it any more."""
    live = select(Run.id).where(_own(user_id), Run.state.in_(LIVE))
    for run_id in session.scalars(live).all():
        results.cancel(session, run_id)
    if not keep_published:
        publications.withdraw_all(session, _own(user_id))
    secrets = (Token, BrowserSession, Invitation, PasswordReset, KeyOfSubmission)
    for table in (*secrets, LinkedIdentity, MailAddress, RunNotice, Check, Membership):
        session.execute(delete(table).where(table.user_id == user_id))
    teams.leave_all(session, user_id)
    session.execute(delete(Classroom).where(Classroom.teacher_id == user_id))
    unsent = (OutgoingMail.user_id == user_id, OutgoingMail.ended_at.is_(None))
    session.execute(update(OutgoingMail).where(*unsent).values(ended_at=time.time()))
    # No name that a person may choose has a space, so nobody can have this one.
    name = f"Deleted user {user_id}"
    anonymous = {"name": name, "name_key": name.casefold(), "password_hash": None}
    profile = asdict(Profile())
    change = update(User).where(User.id == user_id)
    session.execute(
        change.values(**anonymous, **profile, role=Role.USER.label, notify_minutes=None)
    )
    session.add(AccountDeletion(user_id=user_id, requested_at=time.time()))


def step(database: Database, settings: Settings) -> bool:
    """Delete the next batch of runs of a closed account; False if there was nothing to do."""
    with database.writing() as session:
        user_id = session.scalar(
            select(AccountDeletion.user_id).order_by(AccountDeletion.requested_at).limit(1)
        )
        if user_id is None:
            return False
        private = (_own(user_id), Run.public.is_(False), Run.deleted_at.is_(None))
        ended = select(Run.id).where(*private, Run.state.not_in(LIVE)).order_by(Run.id)
        emptied = deletion.empty(session, session.scalars(ended.limit(BATCH)).all())
        done = session.scalar(select(Run.id).where(*private).limit(1)) is None
        if done:
            _complete(session, user_id)
    deletion.remove_files(settings, emptied)
    return done or bool(emptied)


def _own(user_id: int) -> ColumnElement[bool]:
    return Run.owner == (Viewer(user_id=user_id).owner or "")


def _complete(session: Session, user_id: int) -> None:
    """End a deletion; unless published runs need their owner, the account and all rows go too.

    Of an account that stays, empty rows stay as well: the leaderboard tells how many ranked runs
    were made for its entry.
    """
    if session.scalar(select(Run.id).where(_own(user_id), Run.public).limit(1)) is None:
        _delete_rows(session, user_id)
        if session.scalar(select(Run.id).where(_own(user_id)).limit(1)) is not None:
            return  # the next step goes on
        session.execute(delete(User).where(User.id == user_id))
    session.execute(delete(AccountDeletion).where(AccountDeletion.user_id == user_id))


def _delete_rows(session: Session, user_id: int) -> None:
    """Delete the next of the empty rows of an account."""
    newest = session.scalar(select(func.max(Run.id)))
    empty = select(Run.id).where(_own(user_id), Run.id != newest).limit(ROWS)
    session.execute(delete(Run).where(Run.id.in_(session.scalars(empty).all())))
    # SQLite would give its number to the next run, so the newest stays, as nobody's.
    own_newest = select(Run.id).where(_own(user_id), Run.id == newest)
    for uploads in (RunPart, RunFile):
        session.execute(delete(uploads).where(uploads.run_id.in_(own_newest)))
    kept = update(Run).where(_own(user_id), Run.id == newest)
    session.execute(
        kept.values(owner="deleted", user_id=None, program_sha256=None, vehicle_sha256=None)
    )
