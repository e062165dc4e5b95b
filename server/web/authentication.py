"""Authentication by bearer token or by the signed cookie of the browser."""

import secrets

from flask import Flask, g, request, session
from werkzeug.exceptions import Unauthorized

from seamark.server.accounts import accounts
from seamark.server.accounts.permissions import Viewer
from seamark.server.database.tables import User
from seamark.server.web.services import services

BEARER = "bearer"  # case-insensitive (RFC 9110, 11.1)
_USER, _KEY, _GUEST = "user", "key", "guest"


def register(app: Flask) -> None:
    """Set `g.viewer` before each request."""

    @app.before_request
    def find_viewer() -> None:
        g.viewer = Viewer()  # for the error page, in case authentication fails
        if request.endpoint != "static":
            g.viewer = _viewer()


def by_token() -> bool:
    """Return whether the request has a bearer token; then it needs no CSRF token."""
    return _scheme() == BEARER


def sign_in(user_id: int) -> int:
    """Sign the browser in from the next request on.

    Returns how many runs of the guest were transferred to the user.
    """
    adopted = _adopt_runs(user_id)
    session.clear()  # prevents session fixation
    session.permanent = True
    session.update(cookie_of(user_id))
    return adopted


def cookie_of(user_id: int) -> dict[str, object]:
    """Return the content of the session cookie, valid until the password changes."""
    current = services()
    with current.database.reading() as database:
        user = database.get_one(User, user_id)
    return {_USER: user_id, _KEY: accounts.session_key(current.settings, user)}


def sign_out() -> None:
    """Sign the browser out."""
    session.clear()


def become_guest() -> Viewer:
    """Return the current viewer; an anonymous one becomes a guest with a cookie."""
    viewer: Viewer = g.viewer
    if viewer.owner is None and not by_token():
        session.permanent = True
        session[_GUEST] = secrets.token_urlsafe(24)
        g.viewer = viewer = _guest(session[_GUEST])
    return viewer


def _scheme() -> str:
    """Return the authentication scheme of the request; proxies may use others than "bearer"."""
    return request.headers.get("Authorization", "").strip().partition(" ")[0].lower()


def _viewer() -> Viewer:
    """Return who sent the request; an invalid token is refused, not treated as anonymous."""
    if by_token():
        text = request.headers["Authorization"][len(BEARER) :].strip()
        with services().database.reading() as database:
            viewer = accounts.viewer_of_token(database, text)
        if viewer is None:
            raise Unauthorized("The token is unknown, revoked or expired.")
        return viewer
    user_id, guest = session.get(_USER), session.get(_GUEST)
    if user_id is not None:
        current, key = services(), str(session.get(_KEY, ""))
        with current.database.reading() as database:
            viewer = accounts.viewer_of_session(database, user_id, key, current.settings)
        if viewer is not None:
            return viewer
    return Viewer() if guest is None else _guest(guest)


def _adopt_runs(user_id: int) -> int:
    cookie = session.get(_GUEST)
    if cookie is None:
        return 0
    current = services()
    with current.database.writing() as database:
        return accounts.adopt_runs(database, user_id, accounts.guest_hash(current.settings, cookie))


def _guest(cookie: str) -> Viewer:
    return Viewer(guest=accounts.guest_hash(services().settings, cookie))
