"""When a request is repeated, how long is waited, and which exception says why it failed."""

from collections.abc import Callable, Sequence
from datetime import UTC, datetime, timedelta
from email.utils import format_datetime
from typing import Any

import httpx
import pytest

from seamark.client import (
    Conflict,
    DataDeleted,
    NotFound,
    NotPermitted,
    NotSignedIn,
    RequestInvalid,
    ServerFailed,
    ServerRefused,
    ServerUnavailable,
    TooManyRequests,
)
from seamark.client.calls import FIRST_ANSWER_S, Calls
from seamark.client.exchange import Answer, Call, Pause, Request, advance
from seamark.server.web.problems import PROBLEM_TYPES

SERVER = "http://tester"
RUN = dict.fromkeys(("id", "benchmark", "title", "state", "progress", "position", "public"))
RUN |= dict.fromkeys(("result", "failure", "links"))
OK = httpx.Response(200, json=RUN)
CUT = httpx.RemoteProtocolError("peer closed connection without sending complete message body")
NO_SERVER = httpx.ConnectError("Connection refused")


def problem(status: int, slug: str = "x", **headers: str) -> httpx.Response:
    document = {"type": f"/problems/{slug}", "title": "T", "status": status, "detail": "Why."}
    return httpx.Response(status, json=document, headers=headers)


def drive(
    call: Call[Any], answers: Sequence[Answer], pauses: list[float] | None = None
) -> tuple[Any, list[Request], list[float]]:
    """Answer the requests of a call in turn; return its result, the requests and the pauses."""
    waiting, requests = list(answers), []
    pauses = [] if pauses is None else pauses
    answer: Answer = None
    try:
        while True:
            wanted = advance(call, answer)
            if isinstance(wanted, Pause):
                pauses.append(wanted.seconds)
                answer = None
            else:
                requests.append(wanted)
                answer = waiting.pop(0)
    except StopIteration as done:
        return done.value, requests, pauses


def calls(*, signed_in: bool = True, patience_s: float = 60.0) -> Calls:
    return Calls(SERVER, signed_in=signed_in, patience_s=patience_s)


@pytest.mark.parametrize(
    "passing", [CUT, NO_SERVER, httpx.ReadTimeout("t"), httpx.Response(502), problem(503)]
)
def test_a_read_is_repeated_after_what_may_pass(passing: Answer) -> None:
    run, requests, pauses = drive(calls().run(1), [passing, passing, OK])

    assert run == RUN
    assert len(requests) == 3
    assert 0.25 <= pauses[0] <= 0.5
    assert 0.5 <= pauses[1] <= 1.0


def test_a_submission_is_repeated_with_the_same_key() -> None:
    submit = calls().submit("currents-v1", {"controller": "pi"})

    _, requests, _ = drive(submit, [CUT, httpx.Response(504), OK])

    keys = {request.options["headers"]["Idempotency-Key"] for request in requests}
    assert len(requests) == 3
    assert len(keys) == 1


@pytest.mark.parametrize(
    "change",
    [
        lambda: calls(signed_in=False).submit("currents-v1", {"controller": "pi"}),
        lambda: calls().act(1, "publish"),
    ],
)
def test_a_change_that_the_server_may_have_made_is_not_repeated(
    change: Callable[[], Call[Any]],
) -> None:
    with pytest.raises(ServerUnavailable, match=r"The connection to http://tester broke: peer"):
        drive(change(), [CUT])
    with pytest.raises(ServerUnavailable, match="answered 504 Gateway Timeout"):
        drive(change(), [httpx.Response(504)])

    _, requests, _ = drive(change(), [NO_SERVER, problem(429), OK])
    assert len(requests) == 3  # these two cannot have changed anything


def test_retry_after_is_waited_for() -> None:
    _, _, pauses = drive(calls(patience_s=10.0).run(1), [problem(429, **{"Retry-After": "7"}), OK])

    assert pauses == [7.0]


def test_a_date_in_retry_after_that_is_too_far_away_is_told_and_not_waited_for() -> None:
    date = format_datetime(datetime.now(UTC) + timedelta(seconds=900), usegmt=True)

    with pytest.raises(TooManyRequests) as caught:
        drive(calls(patience_s=10.0).run(1), [problem(429, **{"Retry-After": date})])

    assert 600 < (caught.value.retry_after_s or 0.0) <= 900


def test_without_patience_nothing_is_repeated() -> None:
    with pytest.raises(ServerUnavailable, match="does not answer: Connection refused"):
        drive(calls(patience_s=0.0).run(1), [NO_SERVER])


def test_all_pauses_together_last_as_long_as_the_patience_if_the_server_has_answered() -> None:
    known, pauses = calls(patience_s=20.0), list[float]()
    drive(known.run(1), [OK])

    with pytest.raises(ServerUnavailable):
        drive(known.run(1), [NO_SERVER] * 100, pauses)

    assert 12.0 < sum(pauses) <= 20.0


def test_an_address_that_never_answered_is_given_up_soon() -> None:
    pauses: list[float] = []

    with pytest.raises(ServerUnavailable, match="does not answer"):
        drive(calls(patience_s=20.0).run(1), [NO_SERVER] * 100, pauses)

    assert 1.0 < sum(pauses) <= FIRST_ANSWER_S


@pytest.mark.parametrize(
    ("slug", "kind"),
    [
        ("bad-request", RequestInvalid),
        ("token-invalid", NotSignedIn),
        ("scope-missing", NotPermitted),
        ("not-found", NotFound),
        ("method-not-allowed", ServerRefused),
        ("conflict", Conflict),
        ("data-deleted", DataDeleted),
        ("payload-too-large", RequestInvalid),
        ("invalid-request", RequestInvalid),
        ("quota-exceeded", TooManyRequests),
        ("internal-error", ServerFailed),
        ("unavailable", ServerFailed),
    ],
)
def test_each_problem_is_an_exception_of_its_kind(slug: str, kind: type[ServerRefused]) -> None:
    answer = problem(PROBLEM_TYPES[slug].status, slug)

    with pytest.raises(ServerRefused, match=r"^Why\.$") as caught:
        drive(calls(patience_s=0.0).act(1, "publish"), [answer])

    assert type(caught.value) is kind
    assert caught.value.problem["type"] == f"/problems/{slug}"


def test_without_a_token_the_refusal_says_how_to_pass_one() -> None:
    with pytest.raises(NotSignedIn, match=r"Why\. Pass a token: .* SEAMARK_TOKEN\.$"):
        drive(calls(signed_in=False).run(1), [problem(401, "unauthenticated")])


def test_a_refusal_names_the_fields_that_its_sentence_leaves_out() -> None:
    errors = [{"field": "seed", "detail": "Too large."}, {"field": "x", "detail": "Why."}, 7]
    answer = httpx.Response(422, json={"title": "T", "detail": "Why.", "errors": errors})

    with pytest.raises(RequestInvalid, match=r"^Why\. seed: Too large\.$"):
        drive(calls().run(1), [answer])


@pytest.mark.parametrize(
    ("answer", "says"),
    [
        (httpx.Response(200, html="<h1>Welcome</h1>"), "is not a Seamark server"),
        (httpx.Response(200, json=[1, 2]), "is not a Seamark server"),
        (httpx.Response(200, json={"id": 1}), "is not a Seamark server"),
        (httpx.Response(200, text="[" * 100_000), "is not a Seamark server"),
        (
            httpx.Response(404, html="<h1>No</h1>"),
            "answered 404 Not Found, not as a Seamark server",
        ),
        (httpx.Response(301, headers={"Location": "https://a.example/"}), "points to https://a.ex"),
        (httpx.InvalidURL("Invalid port: 'x'"), "is not the address of a server"),
        (httpx.UnsupportedProtocol("no http://"), "is not the address of a server"),
    ],
)
def test_an_answer_that_no_service_gives_is_a_sentence(answer: Answer, says: str) -> None:
    with pytest.raises(ServerUnavailable, match=says):
        drive(calls().run(1), [answer])


@pytest.mark.parametrize("columns", ["", "t,x,y"])
def test_telemetry_that_was_cut_off_is_not_taken_for_whole_rows(columns: str) -> None:
    answer = httpx.Response(200, content=bytes(8 * 4), headers={"X-Columns": columns})

    with pytest.raises(ServerUnavailable):
        drive(calls().telemetry(1), [answer])
