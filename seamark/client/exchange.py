"""One request and what may come of it, without I/O: repeated, waited for, or an exception.

A call of the API is a generator. It yields what is to be done, a `Request` or a `Pause`, is sent
the response, and returns its result. `Client` and `AsyncClient` only do what it yields.
"""

from __future__ import annotations

from collections.abc import Generator, Mapping, Sequence
from dataclasses import dataclass, field
from http import HTTPStatus
from typing import Any, BinaryIO, TypeVar

import httpx

from seamark.client import retry_after
from seamark.client.errors import ServerUnavailable, refusal

SAFE_METHODS = frozenset(
    {"GET", "HEAD", "PUT", "DELETE"}
)  # to repeat one changes nothing (RFC 9110)
NOT_SENT = (httpx.ConnectError, httpx.ConnectTimeout, httpx.PoolTimeout)
PASSING = frozenset({502, 503, 504})  # the service or a proxy before it is starting or overloaded

Result = TypeVar("Result")


@dataclass(frozen=True, slots=True)
class Request:
    """A request to the API; `options` are those of httpx.

    The body of a success goes to the file `into`, if there is one, and not into memory.
    """

    method: str
    path: str
    options: Mapping[str, Any] = field(default_factory=dict)
    repeatable: bool = False  # although the method is not: it has an Idempotency-Key
    into: BinaryIO | None = None


@dataclass(frozen=True, slots=True)
class Pause:
    """Wait this long."""

    seconds: float


Answer = httpx.Response | Exception | None  # of a request: a response or why there is none
Call = Generator[Request | Pause, httpx.Response | None, Result]


def advance(call: Call[Result], answer: Answer) -> Request | Pause:
    """Return what a call wants next, given the answer to what it wanted before (at first None).

    Raises
    ------
    StopIteration
        The call is done; `value` is its result.
    """
    return call.throw(answer) if isinstance(answer, Exception) else call.send(answer)


def exchange(
    server: str, request: Request, *, patience_s: float, reach_s: float
) -> Call[httpx.Response]:
    """Return the response to a request; repeats it while that is safe and may help.

    A request that changes something is repeated only if the server cannot have accepted it, or
    recognises the repetition. All pauses together last `patience_s` at most;
    without any connection it is given up after `reach_s` of them.

    Raises
    ------
    ServerRefused, ServerUnavailable
    """
    left_s, attempt = patience_s, 0
    while True:
        wait_s = retry_after.backoff_s(attempt)
        try:
            response = yield request
        except httpx.HTTPError as error:
            reached = not isinstance(error, httpx.ConnectError | httpx.ConnectTimeout)
            most_s = left_s if reached else min(left_s, reach_s + left_s - patience_s)
            if not _may_repeat(request, error) or wait_s > most_s:
                raise _unavailable(server, error) from None
        except httpx.InvalidURL as error:
            raise ServerUnavailable(f"{server} is not the address of a server: {error}.") from None
        else:
            assert response is not None  # noqa: S101 (only a pause is answered by None)
            if response.status_code < HTTPStatus.BAD_REQUEST:
                return _accepted(server, response)
            wait_s = retry_after.pause_s(_retry_after(response), attempt)
            if not _may_pass(request, response) or wait_s > left_s:
                raise _failure(server, response)
        yield Pause(wait_s)
        left_s -= wait_s
        attempt += 1


def document(server: str, response: httpx.Response, needs: Sequence[str] = ()) -> dict[str, Any]:
    """Return the JSON object of a response; raises ServerUnavailable if it lacks what it needs."""
    answer = _object(response)
    if answer is None or not all(key in answer for key in needs):
        raise not_seamark(server)
    return answer


def not_seamark(server: str) -> ServerUnavailable:
    """Return the exception for an answer that no Seamark server gives."""
    return ServerUnavailable(f"{server} is not a Seamark server. Check the address.")


def _object(response: httpx.Response) -> dict[str, Any] | None:
    try:
        value = response.json()
    except (ValueError, RecursionError):
        return None
    return value if isinstance(value, dict) else None


def _may_repeat(request: Request, error: httpx.HTTPError) -> bool:
    if isinstance(error, httpx.UnsupportedProtocol | httpx.DecodingError):
        return False
    return isinstance(error, NOT_SENT) or _harmless(request)


def _may_pass(request: Request, response: httpx.Response) -> bool:
    if response.status_code == HTTPStatus.TOO_MANY_REQUESTS:
        return True  # refused before anything was done
    return response.status_code in PASSING and _harmless(request)


def _harmless(request: Request) -> bool:
    return request.repeatable or request.method in SAFE_METHODS


def retry_after_s(response: httpx.Response) -> float | None:
    """Return when the server wants to be asked again [s]; None if it does not say that."""
    return retry_after.hint_s(_retry_after(response))


def _retry_after(response: httpx.Response) -> str:
    text: str = response.headers.get(retry_after.HEADER, "")
    return text


def _accepted(server: str, response: httpx.Response) -> httpx.Response:
    """Return the response unless it points elsewhere: a token follows no redirect."""
    if response.has_redirect_location:
        target = response.headers.get("Location", "")
        raise ServerUnavailable(f"{server} points to {target}. Use that address of the server.")
    return response


def _failure(server: str, response: httpx.Response) -> Exception:
    """Return the exception for a refusal, or for an error page of something in between."""
    problem = _object(response)
    if problem is None or "title" not in problem:
        answer = f"{response.status_code} {response.reason_phrase}".strip()
        return ServerUnavailable(
            f"{server} answered {answer}, not as a Seamark server. Check the address."
        )
    return refusal(problem, response.status_code, retry_after_s(response))


def _unavailable(server: str, error: httpx.HTTPError) -> ServerUnavailable:
    if isinstance(error, httpx.UnsupportedProtocol):
        return ServerUnavailable(f"{server} is not the address of a server: {error}.")
    if isinstance(error, httpx.TimeoutException):
        return ServerUnavailable(f"{server} does not answer in time.")
    if isinstance(error, httpx.ConnectError):
        return ServerUnavailable(f"{server} does not answer: {error}.")
    return ServerUnavailable(f"The connection to {server} broke: {error}.")
