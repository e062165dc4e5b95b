"""Pages for what cannot be shown; who asks for JSON gets a problem document."""

import structlog
from flask import Flask, g, render_template, request, url_for
from flask.typing import ResponseReturnValue
from flask_wtf.csrf import CSRFError
from werkzeug.exceptions import HTTPException

from seamark.server.accounts.permissions import Viewer
from seamark.server.web import problems
from seamark.server.web.services import services
from seamark.server.web.template_filters import size

_DRAIN_MAX = 32 * 2**20  # [byte] of a refused upload that are read and thrown away
_log = structlog.get_logger()

# status -> title, sentence, remedy
_WORDS = {
    400: (
        "This request could not be read",
        "The browser sent something unexpected.",
        "Go back, reload the page and try again.",
    ),
    401: ("Who are you?", "This token is not valid.", "Sign in, or make a new token."),
    403: ("This is not yours to do", "Only the owner may do this.", "Sign in as its owner."),
    404: (
        "Nothing here",
        "This page does not exist, or it is private and belongs to somebody else.",
        "Check the address, or sign in.",
    ),
    405: ("That does not work here", "This address is for a button, not for a visit.", ""),
    409: ("Too late for that", "The run's state has changed.", "Go back and reload the page."),
    413: (
        "The upload is too large",
        "A program may have up to {limit}. Yours was larger{given}, so it was not kept.",
        "A controller is source code; leave data and recordings out of the file.",
    ),
    429: ("Too many tries", "That was too often in a short time.", "Wait a minute and try again."),
    500: (
        "We made a mistake",
        "Something broke on our side. Your runs and data are safe.",
        "Try again; if it happens again, tell the operator what you did.",
    ),
    503: ("A part of the service is away", "It will be back soon.", "Try again in a minute."),
}


def register(app: Flask) -> None:
    """Answer every error with a page or a problem document."""

    @app.errorhandler(HTTPException)
    def show_http(error: HTTPException) -> ResponseReturnValue:
        if error.code == 413:
            _drain()
        if problems.prefers_json():
            return problems.from_http_exception(error).response()
        return _page(error)

    @app.errorhandler(CSRFError)
    def show_csrf(error: CSRFError) -> ResponseReturnValue:
        if problems.prefers_json():
            return problems.Problem("csrf").response()
        return _render(
            403,
            "This form is out of date",
            "It was opened before you signed in or out, or it came from another site.",
            "Go back, reload the page and send the form again. Nothing was changed.",
        )


def _page(error: HTTPException) -> ResponseReturnValue:
    code = error.code or 500
    title, sentence, remedy = _WORDS.get(code, (error.name, error.description or "", ""))
    if code == 413:
        given = f" ({size(request.content_length)})" if request.content_length else ""
        limit = size(services().settings.upload_max_bytes)
        sentence = sentence.format(limit=limit, given=given)
    return _render(code, title, sentence, remedy)


def _render(code: int, title: str, sentence: str, remedy: str) -> tuple[str, int]:
    if "viewer" not in g:
        g.viewer = Viewer()
    on_form = request.path.startswith("/submit")
    back = None if not on_form else url_for("submit.first") if code == 404 else request.path
    page = render_template(
        "error/error.html", code=code, title=title, sentence=sentence, remedy=remedy, back=back
    )
    return page, code


def _drain() -> None:
    """Read what is left of a refused upload; a browser that is cut off shows no answer at all."""
    stream, left = request.environ["wsgi.input"], min(request.content_length or 0, _DRAIN_MAX)
    while left > 0:
        part = stream.read(min(left, 64 * 1024))
        if not part:
            return
        left -= len(part)
