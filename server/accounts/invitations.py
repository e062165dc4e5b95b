"""Invitations to sign up: each makes one account. Only their hashes are stored."""

import secrets
import time

from sqlalchemy import delete, func, select
from sqlalchemy.orm import Session

from seamark.server.accounts import accounts
from seamark.server.accounts.accounts import AccountRejected
from seamark.server.database.tables import Invitation

DAYS, DAYS_MAX = 14, 365  # until an invitation expires: default and maximum
BATCH_MAX = 100  # invitations made by one request
OPEN_MAX = 1000  # unused invitations of one account: as many students as a school may have
_DAY_S = 86_400.0


def create(
    session: Session, *, days: float, count: int = 1, user_id: int | None = None
) -> list[str]:
    """Return the texts of new invitations, which are not stored and cannot be shown again.

    `user_id` is the account that invites; None for the operator of the service.

    Raises
    ------
    AccountRejected
        The account would have more than `OPEN_MAX` unused invitations.
    """
    now = time.time()
    session.execute(delete(Invitation).where(Invitation.expires_at <= now))
    if user_id is not None and open_count(session, user_id) + count > OPEN_MAX:
        raise AccountRejected(f"You may have at most {OPEN_MAX} unused invitations.")
    texts = [secrets.token_urlsafe(18) for _ in range(count)]
    session.add_all(
        Invitation(
            hash=accounts.secret_hash(text),
            user_id=user_id,
            created_at=now,
            expires_at=now + days * _DAY_S,
        )
        for text in texts
    )
    return texts


def open_count(session: Session, user_id: int) -> int:
    """Return how many invitations of an account can still be used."""
    unused = (Invitation.user_id == user_id) & (Invitation.expires_at > time.time())
    return session.scalar(select(func.count()).where(unused)) or 0


def accept(session: Session, text: str) -> None:
    """Use up an invitation, in the transaction that creates the account.

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
