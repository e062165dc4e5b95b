"""Who asks: from the bearer token, or from the signed cookie of the browser."""

import secrets

from flask import Flask, g, request, session
from werkzeug.exceptions import Unauthorized

from seamark.server.accounts import accounts
from seamark.server.accounts.permissions import Viewer
from seamark.server.database.tables import User
from seamark.server.web.services import services

BEARER = "bearer"  # in any case of letters (RFC 9110, 11.1)
_USER, _KEY, _GUEST = "user", "key", "guest"


def register(app: Flask) -> None:
    """Set `g.viewer` before each request."""

    @app.before_request
    def find_viewer() -> None:
        g.viewer = Viewer()  # also for the pages of errors, should the lines below fail
        if request.endpoint != "static":
            g.viewer = _viewer()


def by_token() -> bool:
    """Return whether the request carries a token; such a request needs no CSRF secret."""
    return _scheme() == BEARER


def sign_in(user_id: int) -> int:
    """Let the browser speak for a user from the next request on.

    Returns how many runs that it made as a guest belong to the user now.
    """
    adopted = _adopt_runs(user_id)
    session.clear()  # nothing that was planted before the sign-in survives it
    session.permanent = True
    session.update(cookie_of(user_id))
    return adopted


def cookie_of(user_id: int) -> dict[str, object]:
    """Return what the cookie of a user's browser holds until the password is changed."""
    held = services()
    with held.database.reading() as database:
        user = database.get_one(User, user_id)
    return {_USER: user_id, _KEY: accounts.session_key(held.settings, user)}


def sign_out() -> None:
    """Forget who the browser speaks for."""
    session.clear()


def become_guest() -> Viewer:
    """Return the present viewer, made a guest with a cookie of its own if nobody in particular."""
    viewer: Viewer = g.viewer
    if viewer.owner is None and not by_token():
        session.permanent = True
        session[_GUEST] = secrets.token_urlsafe(24)
        g.viewer = viewer = _guest(session[_GUEST])
    return viewer


def _scheme() -> str:
    """Return how the request says who asks, such as "bearer"; proxies may use others."""
    return request.headers.get("Authorization", "").strip().partition(" ")[0].lower()


def _viewer() -> Viewer:
    """Return who asks; a wrong token is refused rather than treated as nobody."""
    if by_token():
        text = request.headers["Authorization"][len(BEARER) :].strip()
        with services().database.reading() as database:
            viewer = accounts.viewer_of_token(database, text)
        if viewer is None:
            raise Unauthorized("The token is unknown, withdrawn or expired.")
        return viewer
    user_id, guest = session.get(_USER), session.get(_GUEST)
    if user_id is not None:
        held, key = services(), str(session.get(_KEY, ""))
        with held.database.reading() as database:
            viewer = accounts.viewer_of_session(database, user_id, key, held.settings)
        if viewer is not None:
            return viewer
    return Viewer() if guest is None else _guest(guest)


def _adopt_runs(user_id: int) -> int:
    cookie = session.get(_GUEST)
    if cookie is None:
        return 0
    held = services()
    with held.database.writing() as database:
        return accounts.adopt_runs(database, user_id, accounts.guest_hash(held.settings, cookie))


def _guest(cookie: str) -> Viewer:
    return Viewer(guest=accounts.guest_hash(services().settings, cookie))
