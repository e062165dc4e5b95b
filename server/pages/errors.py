"""Error pages; API clients get a problem document instead."""

import errno

import structlog
from flask import Flask, g, redirect, render_template, request, url_for
from flask.typing import ResponseReturnValue
from flask_wtf.csrf import CSRFError
from werkzeug.exceptions import HTTPException

from seamark.server.accounts.permissions import Viewer
from seamark.server.database.engine import DATABASE_AWAY
from seamark.server.programs.fair_semaphore import SlotsBusy
from seamark.server.runs.data.run_size import size
from seamark.server.storage import storage
from seamark.server.storage.storage import StorageUnavailable
from seamark.server.web import authentication, problems
from seamark.server.web.problems import Problem
from seamark.server.web.services import services

_DRAIN_MAX = 32 * 2**20  # [B] of a rejected upload that are read and discarded
_RETRY_S = 5
_DISK_ERRORS = frozenset(
    {
        *(errno.EACCES, errno.EPERM, errno.EIO, errno.EROFS, errno.ENOSPC, errno.EDQUOT),
        *(errno.EFBIG, errno.ESTALE, errno.ENOTCONN),
    }
)
_log = structlog.get_logger()

# status -> title, sentence, remedy
_MESSAGES = {
    400: (
        "Bad request",
        "The request could not be processed.",
        "Go back, reload the page and try again.",
    ),
    401: ("Sign-in required", "This token is not valid.", "Sign in, or create a new token."),
    403: ("Permission denied", "Only the owner may do this.", "Sign in as the owner."),
    404: (
        "Page not found",
        "This page does not exist, or it is private and belongs to someone else.",
        "",
    ),
    405: ("Method not allowed", "This address only accepts submitted forms.", ""),
    409: ("Conflict", "The state of the run has changed.", "Go back and reload the page."),
    413: (
        "The upload is too large",
        "Programs may be up to {limit} large, other fields a few pages. What you sent{given} was "
        "not stored.",
        "Leave data and recordings out of the file.",
    ),
    429: (
        "Too many requests",
        "You have sent too many requests in a short time.",
        "Wait a minute and try again.",
    ),
    500: (
        "Internal error",
        "Something went wrong on the server. Your runs and data are safe.",
        "Try again. If the error persists, contact the operator of this service.",
    ),
    503: (
        "Service unavailable",
        "A part of the service is temporarily unavailable.",
        "Try again in a minute.",
    ),
}


def register(app: Flask) -> None:
    """Add handlers that respond to every error with a page or a problem document."""
    app.register_error_handler(HTTPException, _show_http)
    app.register_error_handler(CSRFError, _show_csrf)
    app.register_error_handler(Problem, _show_problem)
    app.register_error_handler(StorageUnavailable, _show_storage)
    app.register_error_handler(OSError, _show_unreadable)
    app.register_error_handler(SlotsBusy, _show_busy)
    for part_is_away in DATABASE_AWAY:
        app.register_error_handler(part_is_away, _show_unavailable)


def _show_http(error: HTTPException) -> ResponseReturnValue:
    if error.code == 413:
        _drain()
    if problems.prefers_json():
        return problems.from_http_exception(error).response()
    return _page(error)


def _show_problem(problem: Problem) -> ResponseReturnValue:
    if problems.prefers_json():
        return problem.response()
    status = problem.type.status
    if status == 401 and request.method == "GET" and not authentication.by_token():
        return redirect(url_for("account.sign_in", next=_here()))
    if status == 404:  # the same for what is private and for what does not exist
        return _render(404, *_MESSAGES[404])
    return _render(status, problem.type.title, problem.detail, problem.type.remedy)


def _show_csrf(error: CSRFError) -> ResponseReturnValue:
    if problems.prefers_json():
        return Problem("csrf").response()
    return _render(
        403,
        "This form has expired",
        "It was opened before you signed in or out, or it was sent by another site.",
        "Go back, reload the page and submit the form again. No changes were made.",
    )


def _show_unavailable(error: Exception) -> ResponseReturnValue:
    """Respond while the database is away."""
    services().outage.failed(error)
    headers = {"Retry-After": str(_RETRY_S)}
    if problems.prefers_json():
        return Problem("unavailable", headers=headers).response()
    return *_render(503, *_MESSAGES[503]), headers


def _show_busy(busy: SlotsBusy) -> ResponseReturnValue:
    """Say what is busy, and when there will be a slot."""
    slug = "rate-limited" if busy.own else "unavailable"
    problem = Problem(slug, str(busy), headers={"Retry-After": str(busy.retry_after_s)})
    if problems.prefers_json():
        return problem.response()
    return *_render(problem.type.status, problem.type.title, str(busy), ""), problem.headers


def _show_unreadable(error: OSError) -> ResponseReturnValue:
    """Respond when a disk fails during a read or write; any other error is one of the service."""
    if error.errno not in _DISK_ERRORS:
        raise error
    _log.error("disk_failed", path=request.path, error=str(error))
    return _show_storage(StorageUnavailable("The service cannot read or write its data now."))


def _show_storage(error: StorageUnavailable) -> ResponseReturnValue:
    headers = {"Retry-After": str(storage.RETRY_S)}
    problem = Problem("storage-unavailable", str(error), headers=headers)
    if problems.prefers_json():
        return problem.response()
    return *_render(503, problem.type.title, str(error), ""), headers


def _page(error: HTTPException) -> ResponseReturnValue:
    code = error.code or 500
    title, sentence, remedy = _MESSAGES.get(code, (error.name, error.description or "", ""))
    if code == 413:
        given = f" ({size(request.content_length)})" if request.content_length else ""
        limit = size(services().settings.upload_max_bytes)
        sentence = sentence.format(limit=limit, given=given)
    return _render(code, title, sentence, remedy)


def _here() -> str:
    """Return the address of this page on this site."""
    return request.full_path if request.query_string else request.path


def _render(code: int, title: str, sentence: str, remedy: str) -> tuple[str, int]:
    if "viewer" not in g:
        g.viewer = Viewer()
    if code == 404:
        signed_in = g.viewer.user_id is not None
        remedy = "Check the address." if signed_in else "Check the address, or sign in."
    on_form = request.path.startswith("/submit")
    back = None if not on_form else url_for("submit.first") if code == 404 else request.path
    page = render_template(
        "error/error.html", code=code, title=title, sentence=sentence, remedy=remedy, back=back
    )
    return page, code


def _drain() -> None:
    """Read the rest of a rejected upload; a browser that is cut off shows no response at all."""
    stream = request.environ["wsgi.input"]
    left = min(request.content_length or 0, _DRAIN_MAX)
    while left > 0:
        part = stream.read(min(left, 64 * 1024))
        if not part:
            return
        left -= len(part)
