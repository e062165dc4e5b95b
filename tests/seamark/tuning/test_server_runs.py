"""Candidates on a server: what is done about refusals and failures of the service."""

import time
from collections.abc import Callable

import httpx
import pytest

from seamark.client import AsyncClient
from seamark.failures import PlatformFailed, UsageRefused
from seamark.tuning.candidates import Candidate, Order
from seamark.tuning.server_runs import Entry, Listener, ServerRuns

ORDERS = [Order(candidate=Candidate(number=at, values={}), config={}) for at in range(3)]
ENDED = {
    "id": 1,
    "benchmark": "currents-v1",
    "title": "",
    "state": "succeeded",
    "progress": 1.0,
    "position": None,
    "public": False,
    "result": {"score": 3.0},
    "failure": None,
    "metrics": {"score": 3.0, "trials": [{"score": 3.0}]},
    "links": {"page": "/runs/1"},
}


def _runs(
    answer: Callable[[httpx.Request], httpx.Response], notice: Callable[[str], None] = print
) -> ServerRuns:
    return ServerRuns(
        AsyncClient("http://x", patience_s=0.0, transport=httpx.MockTransport(answer)),
        Entry(benchmark="currents-v1", controller="pi"),
        seed=1,
        trials=1,
        at_a_time=2,
        listener=Listener(progress=print, notice=notice),
    )


@pytest.mark.slow
def test_a_refused_submission_is_repeated_when_the_server_says() -> None:
    asked: list[float] = []
    notices: list[str] = []

    def answer(request: httpx.Request) -> httpx.Response:
        if request.method == "GET":
            return httpx.Response(200, json=ENDED | {"id": int(request.url.path.split("/")[-1])})
        asked.append(time.monotonic())
        if len(asked) > 2:
            return httpx.Response(200, json=ENDED | {"id": len(asked)})
        problem = {"status": 429, "title": "Quota", "detail": "Nothing is left today."}
        return httpx.Response(429, json=problem, headers={"Retry-After": "1"})

    with _runs(answer, notices.append) as runs:
        ended = list(runs.evaluate(ORDERS))

    assert [evaluated.score for _, evaluated in ended] == [3.0, 3.0, 3.0]
    assert notices == ["Nothing is left today. The search goes on in 1 s."]
    assert asked[2] - asked[1] >= 0.99


@pytest.mark.parametrize(
    ("changes", "failure", "message"),
    [
        (
            {"state": "failed", "failure": {"cause": "platform_error", "sentence": "No disk."}},
            PlatformFailed,
            "Run 1 failed on the server: No disk. http://x/runs/1",
        ),
        ({"state": "cancelled"}, UsageRefused, "Run 1 was cancelled on the server"),
    ],
)
def test_a_run_that_says_nothing_about_the_candidate_ends_the_search(
    changes: dict[str, object], failure: type[Exception], message: str
) -> None:
    def answer(_: httpx.Request) -> httpx.Response:
        return httpx.Response(200, json=ENDED | changes)

    with _runs(answer) as runs, pytest.raises(failure, match=message):
        list(runs.evaluate(ORDERS[:1]))  # each answer is about run 1
