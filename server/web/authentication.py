"""Authentication by bearer token or by the signed cookie of the browser."""

import secrets

import structlog
from flask import Flask, g, request, session
from werkzeug.exceptions import Unauthorized

from seamark.server.accounts import accounts, browser_sessions
from seamark.server.accounts.credentials import Credential
from seamark.server.accounts.permissions import Viewer
from seamark.server.database.tables import BrowserSession, Token
from seamark.server.runs.submission import adoption
from seamark.server.web import client_network
from seamark.server.web.services import services

BEARER = "bearer"  # case-insensitive (RFC 9110, 11.1)
_SESSION, _GUEST = "session", "guest"


_ANYBODYS = frozenset(("static", "health.alive", "health.ready"))  # the same for everybody


def register(app: Flask) -> None:
    """Set `g.viewer` before each request."""

    @app.before_request
    def find_viewer() -> None:
        g.viewer = Viewer()  # for the error page, in case authentication fails
        if request.endpoint not in _ANYBODYS and not _has_other_token():
            g.viewer = _viewer()
            structlog.contextvars.bind_contextvars(user=g.viewer.user_id)


def by_token() -> bool:
    """Return whether the request has a bearer token; then it needs no CSRF token."""
    return _scheme() == BEARER


def credential() -> Credential | None:
    """Return by what the sender of the request is known; None for a guest or nobody."""
    viewer: Viewer = g.viewer
    if viewer.user_id is None:
        return None
    if by_token():
        return Credential(Token, accounts.secret_hash(_token()))
    return Credential(BrowserSession, accounts.secret_hash(session_text()))


def sign_in(user_id: int) -> int:
    """Sign the browser in from the next request on.

    Returns how many runs of the guest were transferred to the user.
    """
    adopted = _adopt_runs(user_id)
    sign_out()  # prevents session fixation
    session.permanent = True
    session.update(cookie_of(user_id))
    return adopted


def cookie_of(user_id: int) -> dict[str, object]:
    """Sign a browser in and return the content of its cookie."""
    with services().database.writing() as database:
        return {_SESSION: browser_sessions.begin(database, user_id)}


def session_text() -> str:
    """Return what the cookie of this browser holds; empty if it is not signed in."""
    return str(session.get(_SESSION, ""))


def sign_out() -> None:
    """Sign the browser out; its cookie is worth nothing afterwards, wherever it was copied to."""
    text = session.get(_SESSION)
    session.clear()
    if text is not None:
        with services().database.writing() as database:
            browser_sessions.end(database, str(text))


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


def _token() -> str:
    return request.headers["Authorization"].strip()[len(BEARER) :].strip()


def _has_other_token() -> bool:
    """Return whether the token of the request is none of an account: that of `/metrics`."""
    return request.endpoint == "metrics.metrics" and bool(services().settings.metrics_token)


def _viewer() -> Viewer:
    """Return who sent the request; an invalid token is refused, not treated as anonymous."""
    if by_token():
        viewer = accounts.use_token(services().database, _token())
        if viewer is None:
            raise Unauthorized("The token is unknown, revoked or expired.")
        return viewer
    signed_in, guest = session.get(_SESSION), session.get(_GUEST)
    if signed_in is not None:
        with services().database.reading() as database:
            viewer = browser_sessions.viewer_of(database, str(signed_in))
        if viewer is not None:
            return viewer
    return Viewer(network=client_network.network()) if guest is None else _guest(guest)


def _adopt_runs(user_id: int) -> int:
    cookie = session.get(_GUEST)
    if cookie is None:
        return 0
    current = services()
    with current.database.writing() as database:
        return adoption.adopt_runs(database, user_id, accounts.guest_hash(current.settings, cookie))


def _guest(cookie: str) -> Viewer:
    guest = accounts.guest_hash(services().settings, cookie)
    return Viewer(guest=guest, network=client_network.network())
