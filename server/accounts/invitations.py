"""Invitations to sign up: each makes one account. Only their hashes are stored."""

import secrets
import time

from sqlalchemy import delete
from sqlalchemy.orm import Session

from seamark.server.accounts import accounts
from seamark.server.accounts.accounts import AccountRejected
from seamark.server.database.tables import Invitation

_DAY_S = 86_400.0


def create(session: Session, *, days: float) -> str:
    """Return the text of a new invitation, which is not stored and cannot be shown again."""
    now = time.time()
    session.execute(delete(Invitation).where(Invitation.expires_at <= now))
    text = secrets.token_urlsafe(18)
    session.add(
        Invitation(hash=accounts.secret_hash(text), created_at=now, expires_at=now + days * _DAY_S)
    )
    return text


def accept(session: Session, text: str) -> None:
    """Use an invitation up, in the transaction that creates the account.

    Raises
    ------
    AccountRejected
        It is unknown, expired or has been used.
    """
    deletion = delete(Invitation).where(
        Invitation.hash == accounts.secret_hash(text.strip()), Invitation.expires_at > time.time()
    )
    if session.scalar(deletion.returning(Invitation.hash)) is None:
        raise AccountRejected("This invitation is unknown, expired or used.")
