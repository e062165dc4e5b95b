"""Requests in the log: an id that follows a run to its worker, and a line for each answer.

Neither query strings nor cookies, tokens or bodies are logged, and of addresses only the network,
as it is counted for guests.
"""

import re
import secrets
from dataclasses import dataclass
from typing import Any

import structlog
from flask import Flask, Response, g, request

from seamark.server.monitoring import log
from seamark.server.web import client_network
from seamark.server.web.asgi import Sent

HEADER = "X-Request-ID"
_VALID = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{7,63}")
_QUIET = frozenset({"static", "health.alive", "health.ready", "metrics.metrics"})
_ID, _NOTE = "seamark.request_id", "seamark.access"  # keys of the WSGI environment
_log = structlog.get_logger()
Environ = dict[str, Any]


@dataclass(frozen=True, slots=True)
class Note:
    """What the application knows of a request."""

    route: str
    user: int | None
    network: str
    quiet: bool


def id_of(environ: Environ) -> str:
    """Return the id of a request: that which it came with if it is valid, or a new one."""
    request_id: str | None = environ.get(_ID)
    if request_id is None:
        given = environ.get("HTTP_X_REQUEST_ID", "")
        request_id = environ[_ID] = given if _VALID.fullmatch(given) else secrets.token_hex(8)
    return request_id


def register(app: Flask) -> None:
    """Give each request its id, before anything else is done; return it with the answer."""

    @app.before_request
    def begin() -> None:
        structlog.contextvars.clear_contextvars()
        structlog.contextvars.bind_contextvars(**{log.REQUEST: id_of(request.environ)})

    @app.after_request
    def note(response: Response) -> Response:
        route = request.url_rule.rule if request.url_rule else "none"
        viewer = g.get("viewer")
        user = None if viewer is None else viewer.user_id
        quiet = request.endpoint in _QUIET
        request.environ[_NOTE] = Note(route, user, client_network.shown(), quiet)
        response.headers[HEADER] = id_of(request.environ)
        return response

    @app.teardown_request
    def end(_error: BaseException | None) -> None:
        structlog.contextvars.clear_contextvars()


def write(environ: Environ, sent: Sent) -> None:
    """Log an answer; those to health checks and for files of the pages only when debugging."""
    note: Note | None = environ.get(_NOTE)
    say = _log.debug if note is not None and note.quiet else _log.info
    known = {} if note is None else {"user": note.user, "network": note.network}
    say(
        "request",
        **{log.REQUEST: id_of(environ)},
        method=environ["REQUEST_METHOD"] if note is not None else "any",
        route="none" if note is None else note.route,
        status=sent.status,
        bytes=sent.bytes,
        ms=round(sent.seconds * 1000.0, 1),
        complete=sent.complete,
        **known,
    )
