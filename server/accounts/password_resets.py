"""Links for a new password: an operator makes one for somebody who forgot theirs."""

import secrets
import time

from sqlalchemy import delete, select
from sqlalchemy.orm import Session

from seamark.server.accounts import accounts
from seamark.server.accounts.accounts import AccountRejected
from seamark.server.database.account_tables import PasswordReset
from seamark.server.database.tables import User

HOURS = 24  # until a link expires


def create(session: Session, name: str) -> str:
    """Return the secret of a new link, which replaces an earlier one; raises AccountRejected."""
    user = accounts.person(session, name)
    if user.disabled_at is not None:
        raise AccountRejected(f"The account {user.name} is disabled.")
    session.execute(delete(PasswordReset).where(PasswordReset.user_id == user.id))
    text = secrets.token_urlsafe(24)
    expires_at = time.time() + HOURS * 3600.0
    session.add(
        PasswordReset(hash=accounts.secret_hash(text), user_id=user.id, expires_at=expires_at)
    )
    return text


def use(session: Session, text: str, new: str) -> User:
    """Set the password of the link's account, sign it out everywhere and revoke its tokens.

    The link works once.

    Raises
    ------
    AccountRejected
        It is unknown, expired or has been used, or the password breaks a rule.
    """
    used = delete(PasswordReset).where(
        PasswordReset.hash == accounts.secret_hash(text.strip()),
        PasswordReset.expires_at > time.time(),
    )
    user_id = session.scalar(used.returning(PasswordReset.user_id))
    if user_id is None:
        raise AccountRejected("This link is unknown, expired or has been used. Ask for a new one.")
    name = session.scalar(select(User.name).where(User.id == user_id))
    return accounts.change_password(session, name or "", new)
