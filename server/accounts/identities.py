"""Identities: by which account somebody signs in whom an identity provider has recognised.

One is its issuer and its subject, as OpenID Connect guarantees; never a name or an e-mail address,
which others may get later.
"""

import time
from dataclasses import dataclass

from sqlalchemy import delete, select
from sqlalchemy.orm import Session

from seamark.sandbox.printable_text import visible_text
from seamark.server.accounts.accounts import AccountRejected
from seamark.server.database.account_tables import LinkedIdentity
from seamark.server.database.tables import User

LABEL_MAX = 120  # [character]
SUBJECT_MAX = 255  # [character] OpenID Connect Core 1.0, section 2


@dataclass(frozen=True, slots=True, kw_only=True)
class Identity:
    """Whom an identity provider has recognised; `label` is what it calls them."""

    issuer: str
    subject: str
    label: str = ""


def find(session: Session, identity: Identity) -> User | None:
    """Return the account to which an identity is linked; None if there is none."""
    linked = select(User).join(LinkedIdentity, LinkedIdentity.user_id == User.id)
    key = (LinkedIdentity.issuer == identity.issuer, LinkedIdentity.subject == identity.subject)
    return session.scalar(linked.where(*key))


def link(session: Session, user_id: int, identity: Identity) -> None:
    """Let an identity sign in to an account.

    Raises
    ------
    AccountRejected
        It is linked to another account, or the account to another identity of the provider.
    """
    holder = find(session, identity)
    if holder is not None and holder.id != user_id:
        raise AccountRejected("This identity is linked to another account.")
    if holder is None:
        if of_account(session, user_id, identity.issuer) is not None:
            raise AccountRejected("Another identity is linked to this account. Unlink it first.")
        label = visible_text(identity.label).strip()[:LABEL_MAX]
        row = LinkedIdentity(issuer=identity.issuer, subject=identity.subject, label=label)
        row.user_id, row.linked_at = user_id, time.time()
        session.add(row)
        session.flush()


def of_account(session: Session, user_id: int, issuer: str) -> LinkedIdentity | None:
    """Return the identity of a provider that is linked to an account; None if there is none."""
    own = (LinkedIdentity.user_id == user_id, LinkedIdentity.issuer == issuer)
    return session.scalar(select(LinkedIdentity).where(*own))


def all_of(session: Session, user_id: int) -> list[LinkedIdentity]:
    """Return the identities of an account, also of earlier providers."""
    query = select(LinkedIdentity).where(LinkedIdentity.user_id == user_id)
    return list(session.scalars(query.order_by(LinkedIdentity.id)))


def unlink(session: Session, user_id: int, issuer: str) -> bool:
    """Unlink the identity of a provider; False if there is none.

    Raises
    ------
    AccountRejected
        The account has no password, so nobody could sign in to it any more.
    """
    if session.get_one(User, user_id).password_hash is None:
        raise AccountRejected("Set a password first: you could no longer sign in without one.")
    own = (LinkedIdentity.user_id == user_id, LinkedIdentity.issuer == issuer)
    deletion = delete(LinkedIdentity).where(*own).returning(LinkedIdentity.id)
    return session.scalar(deletion) is not None
