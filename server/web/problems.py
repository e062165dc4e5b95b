"""Errors of the HTTP API: RFC 9457 problem documents, each `type` stable and with its own page."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from flask import Response, request
from werkzeug.exceptions import HTTPException

if TYPE_CHECKING:
    from pydantic import ValidationError

MEDIA_TYPE = "application/problem+json"


@dataclass(frozen=True, slots=True)
class ProblemType:
    """A type of problem; its address `/problems/<slug>` never changes."""

    slug: str
    status: int
    title: str
    remedy: str


PROBLEM_TYPES: Mapping[str, ProblemType] = {
    slug: ProblemType(slug, status, title, remedy)
    for slug, status, title, remedy in (
        (
            "bad-request",
            400,
            "The request could not be parsed",
            "The API documentation shows what to send.",
        ),
        (
            "unauthenticated",
            401,
            "Authentication is required",
            "Sign in, or send `Authorization: Bearer <token>`. Create tokens on the account page, "
            "by POST /api/v1/tokens or with `seamark token new`.",
        ),
        (
            "token-invalid",
            401,
            "The token is not valid",
            "It is misspelled, expired or revoked. Create a new one on the account page.",
        ),
        (
            "csrf",
            403,
            "The CSRF token is missing or invalid",
            "With cookie authentication, send the value `csrf_token` of GET /api/v1/me in the "
            "header X-CSRFToken, or authenticate with a token instead.",
        ),
        (
            "scope-missing",
            403,
            "The token lacks a scope",
            "Create a token with the scope named in `detail`.",
        ),
        (
            "forbidden",
            403,
            "You do not have permission",
            "Only the owner or an admin may do this.",
        ),
        (
            "account-needed",
            403,
            "This requires an account",
            "Without an account you can try the built-in programs. Create an account to upload "
            "programs, start ranked runs and publish.",
        ),
        (
            "not-found",
            404,
            "Not found",
            "It does not exist, or it is private and belongs to someone else.",
        ),
        (
            "method-not-allowed",
            405,
            "Method not allowed",
            "The Allow header lists the permitted methods.",
        ),
        (
            "conflict",
            409,
            "The current state does not allow this",
            "For example, a run can only be published once it has finished.",
        ),
        (
            "data-deleted",
            410,
            "The data of this run has been deleted",
            "Its result, metrics and configuration are kept. Run it again to record new data.",
        ),
        (
            "withdrawn",
            410,
            "This publication has been withdrawn",
            "The run was public and is private again. Ask its author for the data.",
        ),
        (
            "payload-too-large",
            413,
            "The upload is too large",
            "`detail` states the limit. Leave data files out of the program.",
        ),
        (
            "unsupported-media-type",
            415,
            "Unsupported media type",
            "Send application/json, or multipart/form-data with the parts `run` and `program`.",
        ),
        (
            "range-not-satisfiable",
            416,
            "Range not satisfiable",
            "Request a range within the size of the file.",
        ),
        (
            "invalid-request",
            422,
            "Invalid request",
            "`errors` lists each invalid field and what it accepts.",
        ),
        (
            "invalid-configuration",
            422,
            "Invalid configuration",
            "`errors` lists each invalid field and its range. GET /api/v1/benchmarks/<id> returns "
            "the schema.",
        ),
        (
            "upload-rejected",
            422,
            "The program was rejected",
            "`detail` names the rule it breaks and, for source code, the line.",
        ),
        (
            "log-refused",
            422,
            "The log was refused",
            "`detail` says what is wrong, and at which line or message.",
        ),
        (
            "upgrade-required",
            426,
            "This is a WebSocket",
            "Connect with a WebSocket client, such as roslibpy, or with `seamark bridge rosbridge "
            "--server`.",
        ),
        (
            "quota-exceeded",
            429,
            "Quota exceeded",
            "Wait until one of your runs has finished; Retry-After gives an estimate.",
        ),
        (
            "rate-limited",
            429,
            "Too many requests",
            "Wait for the number of seconds given in Retry-After.",
        ),
        (
            "internal-error",
            500,
            "Internal server error",
            "This is an error in the service. It did not count against your quota; try again.",
        ),
        (
            "unavailable",
            503,
            "Temporarily unavailable",
            "Try again after the number of seconds in Retry-After.",
        ),
        (
            "storage-unavailable",
            503,
            "The service cannot store anything new",
            "Its disk is nearly full or cannot be reached. Try again later; stored data is safe.",
        ),
        (
            "streams-full",
            503,
            "Too many live streams",
            "Try again after the number of seconds in Retry-After, or poll "
            "GET /api/v1/runs/<id> instead.",
        ),
    )
}

_ERRORS_MAX = 20  # fields that one problem document names
_BY_STATUS = {
    400: "bad-request",
    401: "unauthenticated",
    403: "forbidden",
    404: "not-found",
    405: "method-not-allowed",
    409: "conflict",
    413: "payload-too-large",
    415: "unsupported-media-type",
    416: "range-not-satisfiable",
    422: "invalid-request",
    426: "upgrade-required",
    429: "rate-limited",
    500: "internal-error",
    503: "unavailable",
}


class Problem(Exception):
    """A request that is refused. The text is for the client.

    Parameters
    ----------
    slug
        A key of `PROBLEM_TYPES`.
    detail
        What is wrong with this request, in one sentence; the title if empty.
    errors
        Field -> sentence; dotted names for nested fields.
    headers
        Additional response headers, for example Retry-After.
    """

    def __init__(
        self,
        slug: str,
        detail: str = "",
        *,
        errors: Mapping[str, str] | None = None,
        headers: Mapping[str, str] | None = None,
    ) -> None:
        self.type = PROBLEM_TYPES[slug]
        self.detail = detail or self.type.title
        self.errors = dict(errors or {})
        self.headers = dict(headers or {})
        super().__init__(self.detail)

    def document(self) -> dict[str, object]:
        """Return the members of the problem document."""
        members: dict[str, object] = {
            "type": f"/problems/{self.type.slug}",
            "title": self.type.title,
            "status": self.type.status,
            "detail": self.detail,
        }
        if self.errors:
            members["errors"] = [
                {"field": field, "detail": text} for field, text in self.errors.items()
            ]
        return members

    def response(self) -> Response:
        """Return the response with the problem document."""
        response = Response(
            json.dumps(self.document()),
            status=self.type.status,
            content_type=MEDIA_TYPE,
        )
        if self.type.status == 401:
            response.headers["WWW-Authenticate"] = 'Bearer realm="seamark"'
        response.headers.extend(self.headers)
        response.headers["Cache-Control"] = "no-store"
        return response


def from_http_exception(error: HTTPException) -> Problem:
    """Return the problem for an exception of werkzeug; keeps the headers that matter."""
    status = error.code or 500
    slug = _BY_STATUS.get(status, "bad-request" if status < 500 else "internal-error")
    if status == 401 and "Authorization" in request.headers:
        slug = "token-invalid"
    detail = error.description or ""
    if detail == type(error).description:  # werkzeug's default text is written for browsers
        detail = _default_detail(status) or detail
    kept = {
        name: value
        for name, value in error.get_headers(request.environ)
        if name in {"Allow", "Retry-After", "Content-Range"}
    }
    return Problem(slug, detail, headers=kept)


def _default_detail(status: int) -> str:
    """Return what is wrong with the current request, empty where the title says it all."""
    if status == 404:
        return f"There is nothing at {request.path}."
    if status == 405:
        return f"{request.path} does not support {request.method}."
    if status == 413:
        return f"The body of this request is limited to {request.max_content_length} bytes."
    return PROBLEM_TYPES["unsupported-media-type"].remedy if status == 415 else ""


def from_validation_error(error: ValidationError) -> Problem:
    """Return the problem that names each field rejected by pydantic."""
    errors = {}
    rejected = error.errors(include_url=False, include_context=False, include_input=False)
    for item in rejected[:_ERRORS_MAX]:
        field = ".".join(str(part) for part in item["loc"]) or "body"
        errors[field] = item["msg"]
    details = "; ".join(f"{field}: {text}" for field, text in errors.items())
    return Problem("invalid-request", f"Invalid: {details}.", errors=errors)


def prefers_json() -> bool:
    """Return whether the client expects a problem document rather than a page."""
    if request.path.startswith("/api/") and request.path != "/api/docs":
        return True
    best = request.accept_mimetypes.best_match(["text/html", "application/json", MEDIA_TYPE])
    return best is not None and best != "text/html"
