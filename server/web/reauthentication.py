"""Changes of an account that whoever finds a signed-in browser must not make."""

import time

from flask import g
from sqlalchemy.orm import Session

from seamark.server.accounts import accounts, browser_sessions
from seamark.server.web import authentication

RECENT_S = 600.0  # after a sign-in


def refusal(database: Session, password: str) -> str:
    """Return why a change is refused; empty if it is the account's own person who asks for it.

    That takes the current password or, where there is none, that this browser has just signed in.
    """
    if accounts.person(database, g.viewer.name).password_hash is not None:
        wrong = accounts.authenticate(database, g.viewer.name, password) is None
        return "The current password is incorrect." if wrong else ""
    since = browser_sessions.since(database, authentication.session_text())
    if since is not None and since > time.time() - RECENT_S:
        return ""
    return "Sign out and in again, then repeat this within ten minutes."
