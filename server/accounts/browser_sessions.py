"""Browsers that are signed in: rows, so that signing out ends them, also for copies of a cookie."""

import secrets
import time

from sqlalchemy import delete, select
from sqlalchemy.orm import Session

from seamark.server.accounts import accounts
from seamark.server.accounts.permissions import SCOPES, Viewer
from seamark.server.database.tables import BrowserSession, User

SESSION_DAYS = 30
SESSIONS_MAX = 20  # per account; a further sign-in ends the oldest
_DAY_S = 86_400.0


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


def end(session: Session, text: str) -> None:
    """Sign a browser out."""
    session.execute(delete(BrowserSession).where(BrowserSession.hash == accounts.secret_hash(text)))


def viewer_of(session: Session, text: str) -> Viewer | None:
    """Return the viewer of a browser; None if it has been signed out or its time is over."""
    query = (
        select(User)
        .join(BrowserSession, BrowserSession.user_id == User.id)
        .where(
            BrowserSession.hash == accounts.secret_hash(text),
            BrowserSession.expires_at > time.time(),
        )
    )
    user = session.scalar(query)
    return None if user is None else accounts.viewer_of_user(user, SCOPES)
