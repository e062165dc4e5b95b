"""Errors of the HTTP interface: RFC 9457 problem documents with a stable `type` and a page each."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from flask import Response, request
from werkzeug.exceptions import HTTPException

from seamark.server.web.services import services

if TYPE_CHECKING:
    from pydantic import ValidationError

MEDIA_TYPE = "application/problem+json"


@dataclass(frozen=True, slots=True)
class Kind:
    """One kind of problem: its address is `/problems/<slug>` and never changes."""

    slug: str
    status: int
    title: str
    remedy: str


_KINDS = (
    Kind("bad-request", 400, "The request cannot be read", "Send what the documentation shows."),
    Kind(
        "unauthenticated",
        401,
        "Who asks is not known",
        "Sign in, or send `Authorization: Bearer <token>`. Tokens are made on the account page, "
        "by POST /api/v1/tokens or with `seamark token new`.",
    ),
    Kind(
        "token-invalid",
        401,
        "The token is not valid",
        "It is misspelt, expired or was withdrawn. Make a new one on the account page.",
    ),
    Kind(
        "csrf",
        403,
        "The form's secret is missing",
        "A browser's cookie is not enough to change something: send the value `csrf_token` of "
        "GET /api/v1/me as header X-CSRFToken, or use a token instead of the cookie.",
    ),
    Kind(
        "scope-missing",
        403,
        "The token may not do this",
        "Make a token with the scope that `detail` names.",
    ),
    Kind("forbidden", 403, "This is not yours to do", "Only the owner or an admin may do this."),
    Kind(
        "account-needed",
        403,
        "This needs an account",
        "Without an account what is built in can be tried. Sign up to upload programs, "
        "to make ranked runs and to publish.",
    ),
    Kind(
        "not-found",
        404,
        "There is no such thing",
        "It does not exist, or it is private and belongs to somebody else.",
    ),
    Kind(
        "method-not-allowed",
        405,
        "This method does not work here",
        "The header Allow names the methods that do.",
    ),
    Kind(
        "conflict",
        409,
        "The run's state does not allow this",
        "For example, only a run that has ended can be published or cancelled no more.",
    ),
    Kind(
        "payload-too-large",
        413,
        "The upload is too large",
        "The limit stands in `detail`. Data files do not belong into a program.",
    ),
    Kind(
        "unsupported-media-type",
        415,
        "This media type is not understood",
        "Send application/json, or multipart/form-data with the parts `run` and `program`.",
    ),
    Kind(
        "range-not-satisfiable",
        416,
        "The range lies outside",
        "Ask for a range inside of what there is.",
    ),
    Kind(
        "invalid-request",
        422,
        "A value is not acceptable",
        "`errors` names each field and says what it accepts.",
    ),
    Kind(
        "invalid-configuration",
        422,
        "The configuration is not acceptable",
        "`errors` names each field and its range. GET /api/v1/benchmarks/<id> has the schema.",
    ),
    Kind(
        "upload-rejected",
        422,
        "The program was not accepted",
        "`detail` says which rule it breaks and, for source code, in which line.",
    ),
    Kind(
        "quota-exceeded",
        429,
        "The quota is used up",
        "Wait until one of your runs has ended; the header Retry-After has a guess.",
    ),
    Kind("rate-limited", 429, "Too many requests", "Wait as long as Retry-After says."),
    Kind(
        "internal-error",
        500,
        "Seamark made a mistake",
        "This is our fault. Nothing was charged to your quota; try again.",
    ),
    Kind(
        "unavailable",
        503,
        "A part of the service is not there",
        "Try again after the seconds in Retry-After.",
    ),
    Kind(
        "streams-full",
        503,
        "All places for live streams are taken",
        "Try again after the seconds in Retry-After, or ask GET /api/v1/runs/<id> now and then.",
    ),
)
KINDS: Mapping[str, Kind] = {kind.slug: kind for kind in _KINDS}

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
    429: "rate-limited",
    500: "internal-error",
    503: "unavailable",
}


class Problem(Exception):
    """A request that cannot be answered as asked. Its text is written for who asked.

    Parameters
    ----------
    slug
        One of `KINDS`.
    detail
        What is wrong with this request, in one sentence.
    errors
        Field -> sentence; dotted names for nested fields.
    headers
        More headers of the answer, for example Retry-After.
    """

    def __init__(
        self,
        slug: str,
        detail: str = "",
        *,
        errors: Mapping[str, str] | None = None,
        headers: Mapping[str, str] | None = None,
    ) -> None:
        self.kind = KINDS[slug]
        self.detail = detail or self.kind.title
        self.errors = dict(errors or {})
        self.headers = dict(headers or {})
        super().__init__(self.detail)

    def document(self) -> dict[str, object]:
        """Return the members of the problem document."""
        members: dict[str, object] = {
            "type": f"/problems/{self.kind.slug}",
            "title": self.kind.title,
            "status": self.kind.status,
            "detail": self.detail,
        }
        if self.errors:
            members["errors"] = [
                {"field": field, "detail": text} for field, text in self.errors.items()
            ]
        return members

    def response(self) -> Response:
        """Return the answer with the problem document."""
        answer = Response(
            json.dumps(self.document()),
            status=self.kind.status,
            content_type=MEDIA_TYPE,
        )
        if self.kind.status == 401:
            answer.headers["WWW-Authenticate"] = 'Bearer realm="seamark"'
        answer.headers.extend(self.headers)
        answer.headers["Cache-Control"] = "no-store"
        return answer


def of_http(error: HTTPException) -> Problem:
    """Return the problem that says the same as an exception of werkzeug, with Allow kept."""
    status = error.code or 500
    slug = _BY_STATUS.get(status, "bad-request" if status < 500 else "internal-error")
    if status == 401 and "Authorization" in request.headers:
        slug = "token-invalid"
    detail = error.description or ""
    if detail == type(error).description:  # werkzeug's own words, about addresses typed by hand
        detail = _own_words(status) or detail
    kept = {
        name: value
        for name, value in error.get_headers(request.environ)
        if name in {"Allow", "Retry-After", "Content-Range"}
    }
    return Problem(slug, detail, headers=kept)


def _own_words(status: int) -> str:
    """Return what is wrong with the present request, empty where the status says it all."""
    if status == 404:
        return f"There is no address {request.path}."
    if status == 405:
        return f"{request.method} does not work at {request.path}; Allow names what does."
    if status == 413:
        limit = services().settings.upload_max_bytes
        return f"An upload may have {limit} bytes; this request is larger."
    return KINDS["unsupported-media-type"].remedy if status == 415 else ""


def of_validation(error: ValidationError, *, prefix: str = "") -> Problem:
    """Return the problem that names each field which pydantic did not accept."""
    errors = {}
    for item in error.errors(include_url=False, include_context=False, include_input=False):
        field = ".".join(str(part) for part in item["loc"]) or "body"
        errors[prefix + field] = item["msg"]
    named = "; ".join(f"{field}: {text}" for field, text in errors.items())
    return Problem("invalid-request", f"Not acceptable: {named}.", errors=errors)


def wanted() -> bool:
    """Return whether the present request asks for a problem document and not for a page."""
    if request.path.startswith("/api/") and request.path != "/api/docs":
        return True
    best = request.accept_mimetypes.best_match(["text/html", "application/json", MEDIA_TYPE])
    return best is not None and best != "text/html"
