"""By what the sender of a request is known, and whether it still would be: for what goes on."""

import time
from collections.abc import Collection
from dataclasses import dataclass

from sqlalchemy import or_, select
from sqlalchemy.orm import Session

from seamark.server.database.account_tables import AccountDeletion
from seamark.server.database.tables import BrowserSession, Token, User


@dataclass(frozen=True, slots=True)
class Credential:
    """A token, or the cookie of a browser that is signed in."""

    table: type[Token] | type[BrowserSession]
    hash: str  # as the table has it


def refused(session: Session, credentials: Collection[Credential]) -> set[Credential]:
    """Return which of these let nobody in any more.

    They were revoked, signed out or have expired, or the account was disabled or closed.
    """
    accepted = set[Credential]()
    for table in {credential.table for credential in credentials}:
        query = (
            select(table.hash)
            .join(User, User.id == table.user_id)
            .where(
                table.hash.in_([one.hash for one in credentials if one.table is table]),
                or_(table.expires_at.is_(None), table.expires_at > time.time()),
                User.disabled_at.is_(None),
                User.id.not_in(select(AccountDeletion.user_id)),
            )
        )
        accepted |= {Credential(table, text) for text in session.scalars(query)}
    return set(credentials) - accepted
