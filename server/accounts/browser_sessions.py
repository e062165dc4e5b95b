"""Browsers that are signed in: rows, so that signing out ends them, also for copies of a cookie."""

import secrets
import time
from dataclasses import dataclass

from sqlalchemy import bindparam, delete, select
from sqlalchemy.orm import Session

from seamark.server.accounts import accounts
from seamark.server.accounts.permissions import SCOPES, Viewer
from seamark.server.database.tables import BrowserSession, User

SESSION_DAYS = 30
SESSIONS_MAX = 20  # per account; a further sign-in ends the oldest
_DAY_S = 86_400.0
_HANDLE = 16  # [character] of the hash: enough to tell 20 browsers apart


def begin(session: Session, user_id: int) -> str:
    """Sign a browser in and return the text for its cookie, which is not stored."""
    own, now = BrowserSession.user_id == user_id, time.time()
    session.execute(delete(BrowserSession).where(own, BrowserSession.expires_at <= now))
    newest = select(BrowserSession.hash).where(own).order_by(BrowserSession.created_at.desc())
    kept = newest.limit(SESSIONS_MAX - 1)
    session.execute(delete(BrowserSession).where(own, BrowserSession.hash.not_in(kept)))
    text = secrets.token_urlsafe(32)
    session.add(
        BrowserSession(
            hash=accounts.secret_hash(text),
            user_id=user_id,
            created_at=now,
            expires_at=now + SESSION_DAYS * _DAY_S,
        )
    )
    return text


def since(session: Session, text: str) -> float | None:
    """Return when a browser signed in; None if it is not signed in."""
    own = BrowserSession.hash == accounts.secret_hash(text)
    return session.scalar(select(BrowserSession.created_at).where(own))


def end(session: Session, text: str) -> None:
    """Sign a browser out."""
    session.execute(delete(BrowserSession).where(BrowserSession.hash == accounts.secret_hash(text)))


@dataclass(frozen=True, slots=True)
class SignedIn:
    """A browser that is signed in."""

    handle: str  # names it in a form; says nothing about its cookie
    since: float
    is_this: bool


def of_account(session: Session, user_id: int, text: str) -> list[SignedIn]:
    """Return the browsers of an account, the latest first; `text` is of the present one."""
    own = (BrowserSession.user_id == user_id, BrowserSession.expires_at > time.time())
    query = select(BrowserSession).where(*own).order_by(BrowserSession.created_at.desc())
    present = accounts.secret_hash(text)
    return [
        SignedIn(row.hash[:_HANDLE], row.created_at, row.hash == present)
        for row in session.scalars(query.limit(SESSIONS_MAX))
    ]


def end_by_handle(session: Session, user_id: int, handle: str) -> bool:
    """Sign out one browser of an account; False if there is none with this handle."""
    own = select(BrowserSession.hash).where(BrowserSession.user_id == user_id)
    named = [digest for digest in session.scalars(own) if digest[:_HANDLE] == handle]
    session.execute(delete(BrowserSession).where(BrowserSession.hash.in_(named)))
    return bool(named)


_BY_HASH = (
    select(User.id, User.name, User.role)
    .join(BrowserSession, BrowserSession.user_id == User.id)
    .where(
        BrowserSession.hash == bindparam("hash"),
        BrowserSession.expires_at > bindparam("now"),
        User.disabled_at.is_(None),
    )
)


def viewer_of(session: Session, text: str) -> Viewer | None:
    """Return the viewer of a browser; None if it was signed out, or its time or account ended."""
    values = {"hash": accounts.secret_hash(text), "now": time.time()}
    user = session.execute(_BY_HASH, values).one_or_none()
    return None if user is None else accounts.viewer_of_account(*user, SCOPES)
