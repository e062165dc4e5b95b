"""Why a request failed: the server refused it, or there is no such server or answer."""

from __future__ import annotations

from collections.abc import Mapping
from http import HTTPStatus
from typing import Any

TOKEN_HINT = "Pass a token: Client(token=...), --token or SEAMARK_TOKEN."  # noqa: S105 (a sentence)


class ServerRefused(Exception):
    """The server refused a request; the text says why.

    Attributes
    ----------
    problem : dict
        The problem document of the answer (RFC 9457); `problem["type"]` is stable.
    status : int
        The status of the answer.
    retry_after_s : float or None
        When the server asks to try again [s], if it says so.
    """

    def __init__(self, problem: Mapping[str, Any], *, retry_after_s: float | None = None) -> None:
        self.problem = dict(problem)
        status = problem.get("status")
        self.status = status if isinstance(status, int) else 0
        self.retry_after_s = retry_after_s
        super().__init__(_sentences(problem))


class NotSignedIn(ServerRefused):
    """401: a token is needed, or the token is not valid."""

    def __str__(self) -> str:
        """Return what is wrong, and how to pass a token if there was none."""
        text = super().__str__()
        known = self.problem.get("type") == "/problems/unauthenticated"
        return f"{text.rstrip('.')}. {TOKEN_HINT}" if known else text


class NotPermitted(ServerRefused):
    """403: the account or the token may not do this."""


class NotFound(ServerRefused):
    """404: there is no such thing, or it is private and belongs to someone else."""


class Conflict(ServerRefused):
    """409: the present state does not allow this, such as publishing a run that is under way."""


class DataDeleted(ServerRefused):
    """410: the data of the run have been deleted."""


class RequestInvalid(ServerRefused):
    """400, 413, 415 or 422: the request is wrong; `problem["errors"]` names the fields."""


class TooManyRequests(ServerRefused):
    """429: a quota or a rate limit is used up; `retry_after_s` says when to try again."""


class ServerFailed(ServerRefused):
    """5xx: the service failed; the quota is not charged."""


class ServerUnavailable(Exception):
    """The server does not answer, the connection broke, or it is not a Seamark server."""


class StillRunning(Exception):
    """A run or sweep has not ended within the time that `wait` was given. It goes on."""


class PackageMissing(ImportError):
    """A package that this needs is not installed; the text says how to install it."""


_BY_STATUS: Mapping[int, type[ServerRefused]] = {
    HTTPStatus.BAD_REQUEST: RequestInvalid,
    HTTPStatus.UNAUTHORIZED: NotSignedIn,
    HTTPStatus.FORBIDDEN: NotPermitted,
    HTTPStatus.NOT_FOUND: NotFound,
    HTTPStatus.CONFLICT: Conflict,
    HTTPStatus.GONE: DataDeleted,
    HTTPStatus.REQUEST_ENTITY_TOO_LARGE: RequestInvalid,
    HTTPStatus.UNSUPPORTED_MEDIA_TYPE: RequestInvalid,
    HTTPStatus.UNPROCESSABLE_ENTITY: RequestInvalid,
    HTTPStatus.TOO_MANY_REQUESTS: TooManyRequests,
}


def refusal(problem: Mapping[str, Any], status: int, retry_after_s: float | None) -> ServerRefused:
    """Return the exception for a problem document."""
    kind = _BY_STATUS.get(status, ServerFailed if status >= 500 else ServerRefused)
    return kind({"status": status} | dict(problem), retry_after_s=retry_after_s)


def _sentences(problem: Mapping[str, Any]) -> str:
    detail = str(problem.get("detail") or problem.get("title") or "The server refused.")
    if problem.get("type") == "/problems/invalid-configuration":
        return detail  # it has the messages of all fields
    errors = problem.get("errors")
    fields = [
        f"{error.get('field')}: {error.get('detail')}"
        for error in (errors if isinstance(errors, list) else [])
        if isinstance(error, dict)
    ]
    return " ".join(
        [detail, *(text for text in fields if str(text).split(": ", 1)[1] not in detail)]
    )
