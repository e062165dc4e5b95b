"""Tells people about runs of theirs that have ended: many in one e-mail, at most every ten minutes.

Whoever starts a sweep of a hundred runs gets a few e-mails, not a hundred.
"""

import time
from collections.abc import Sequence
from dataclasses import dataclass

from sqlalchemy import delete, func, select
from sqlalchemy.orm import Session

from seamark.server.database.mail_tables import MailAddress, OutgoingMail, RunNotice
from seamark.server.database.tables import Result, Run, User
from seamark.server.mail import outbox
from seamark.server.mail.outbox import MailKind

EVERY_S = 600.0  # to one account
LISTED_MAX = 20  # runs in one e-mail
BATCH = 100  # accounts in one step


@dataclass(frozen=True, slots=True)
class EndedRun:
    """What an e-mail says of a run."""

    id: int
    title: str
    benchmark: str
    state: str
    score: float | None


@dataclass(frozen=True, slots=True)
class EndedRuns:
    """The runs that an e-mail is about; `upto` is the last of their notices."""

    shown: Sequence[EndedRun]
    count: int
    upto: int


def queue_due(session: Session) -> None:
    """Queue an e-mail for each account with notices that has had none for a while."""
    forget = select(RunNotice.user_id).join(User, User.id == RunNotice.user_id)
    unwanted = forget.outerjoin(MailAddress, MailAddress.user_id == User.id).where(
        User.notify_minutes.is_(None) | MailAddress.address.is_(None)
    )
    session.execute(delete(RunNotice).where(RunNotice.user_id.in_(unwanted)))
    since = time.time() - EVERY_S
    recent = select(OutgoingMail.id).where(
        OutgoingMail.user_id == MailAddress.user_id,
        OutgoingMail.kind == MailKind.RUNS,
        OutgoingMail.ended_at.is_(None) | (OutgoingMail.created_at > since),
    )
    due = (
        select(MailAddress.user_id, MailAddress.address_hash)
        .where(MailAddress.user_id.in_(select(RunNotice.user_id)), ~recent.exists())
        .limit(BATCH)
    )
    for user_id, address_hash in session.execute(due).all():
        outbox.add(session, MailKind.RUNS, address_hash or "", user_id=user_id)


def ended_runs(session: Session, user_id: int) -> EndedRuns | None:
    """Return what an account is to be told; None if there is nothing left to tell."""
    own = RunNotice.user_id == user_id
    count, upto = session.execute(select(func.count(), func.max(RunNotice.id)).where(own)).one()
    if not count:
        return None
    query = (
        select(Run.id, Run.title, Run.benchmark, Run.state, Result.score)
        .join(RunNotice, RunNotice.run_id == Run.id)
        .outerjoin(Result, Result.run_id == Run.id)
        .where(own, RunNotice.id <= upto, Run.deleted_at.is_(None))
        .order_by(RunNotice.id.desc())
        .limit(LISTED_MAX)
    )
    shown = [EndedRun(*row) for row in session.execute(query)]
    return EndedRuns(shown, count, upto) if shown else None


def forget_told(session: Session, user_id: int, upto: int) -> None:
    """Delete the notices that an e-mail was about."""
    told = (RunNotice.user_id == user_id, RunNotice.id <= upto)
    session.execute(delete(RunNotice).where(*told))
