"""E-mails to be sent: rows that a sender claims, so that no request waits for a mail server."""

import hashlib
import time
from dataclasses import dataclass
from enum import StrEnum

from sqlalchemy import delete, func, select, update
from sqlalchemy.orm import Session

from seamark.server.database.mail_tables import OutgoingMail

WAITING_MAX = 10_000  # rows, also those that have ended and are still counted
PER_HOUR = 5  # to one address, apart from notices about its own runs
KEPT_S = 3600.0  # after the end, to be counted
GIVEN_UP_S = 86_400.0  # after the first try
RETRY_S, RETRY_MAX_S = 60.0, 3600.0  # doubles from one to the other


class MailKind(StrEnum):
    """What an e-mail is about."""

    CONFIRMATION = "confirmation"  # of an address
    RESET = "reset"  # of a password
    RUNS = "runs"  # that have ended


@dataclass(frozen=True, slots=True)
class ClaimedMail:
    """An e-mail that this process is to send."""

    id: int
    kind: MailKind
    user_id: int | None
    address_hash: str
    created_at: float
    tries: int


def hashed(address: str) -> str:
    """Return what stands for an address in the outbox, the same in whatever case."""
    return hashlib.sha256(address.casefold().encode()).hexdigest()


def add(session: Session, kind: MailKind, address_hash: str, *, user_id: int | None = None) -> bool:
    """Add an e-mail; False, with nothing written, if there are too many, in all or to the address.

    An earlier one of the same kind to the same address that has not been tried is enough.
    """
    now = time.time()
    same = OutgoingMail.address_hash == address_hash
    recent = select(OutgoingMail.kind, OutgoingMail.user_id, OutgoingMail.tries).where(
        same, OutgoingMail.created_at > now - KEPT_S, OutgoingMail.kind != MailKind.RUNS
    )
    if kind is not MailKind.RUNS:
        rows = session.execute(recent.limit(PER_HOUR)).all()
        if (kind, user_id, 0) in {tuple(row) for row in rows}:
            return True
        if len(rows) >= PER_HOUR:
            return False
    if (session.scalar(select(func.count()).select_from(OutgoingMail)) or 0) >= WAITING_MAX:
        return False
    mail = OutgoingMail(kind=kind, user_id=user_id, address_hash=address_hash, tries=0)
    mail.created_at = mail.next_try_at = now
    session.add(mail)
    return True


def claim(session: Session) -> ClaimedMail | None:
    """Claim the e-mail that is due first; None if there is none.

    It is due again later, so that one whose sender died is repeated.
    """
    due = (OutgoingMail.ended_at.is_(None), OutgoingMail.next_try_at <= time.time())
    query = select(OutgoingMail).where(*due).order_by(OutgoingMail.next_try_at).limit(1)
    mail = session.scalar(query)
    if mail is None:
        return None
    pause_s = min(RETRY_S * 2.0 ** min(mail.tries, 10), RETRY_MAX_S)
    mine = update(OutgoingMail).where(  # of two senders only one succeeds
        OutgoingMail.id == mail.id, OutgoingMail.tries == mail.tries, *due
    )
    claimed = mine.values(tries=OutgoingMail.tries + 1, next_try_at=time.time() + pause_s)
    columns = (mail.id, MailKind(mail.kind), mail.user_id, mail.address_hash, mail.created_at)
    tries = session.scalar(claimed.returning(OutgoingMail.tries))
    return None if tries is None else ClaimedMail(*columns, tries)


def cancel(session: Session, user_id: int) -> None:
    """Send nothing more of what an account caused; what was sent to its address still counts."""
    own = update(OutgoingMail).where(OutgoingMail.user_id == user_id)
    now = time.time()
    session.execute(own.values(user_id=None, ended_at=func.coalesce(OutgoingMail.ended_at, now)))


def end(session: Session, mail_id: int) -> None:
    """Mark an e-mail as sent, or as given up."""
    ended = update(OutgoingMail).where(OutgoingMail.id == mail_id)
    session.execute(ended.values(ended_at=time.time()))


def is_too_old(mail: ClaimedMail) -> bool:
    """Return whether an e-mail is given up rather than tried once more."""
    return mail.created_at < time.time() - GIVEN_UP_S


def forget(session: Session) -> None:
    """Delete the rows of e-mails that ended long enough ago."""
    session.execute(delete(OutgoingMail).where(OutgoingMail.ended_at < time.time() - KEPT_S))
