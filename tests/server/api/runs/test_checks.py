"""POST /checks without a worker: what reading shows, what waits, what is refused."""

import io
import json

import pytest
from werkzeug.test import TestResponse

from tests.cast import PROGRAM
from tests.hostile.uploads.archives import Entry, beside_main
from tests.server.api.conftest import Site

CHECKS = "/api/v1/checks"


def sent(
    site: Site, program: bytes, name: str = "mine.py", role: str = "owner", **order: object
) -> TestResponse:
    run = json.dumps({"benchmark": "currents-v1"} | order)
    form = {"run": run, "program": (io.BytesIO(program), name)}
    return site.call(role, "POST", CHECKS, data=form)


def test_errors_of_the_source_are_reported_at_once_with_their_lines(site: Site) -> None:
    program = b"class Controller:\n    def __init__(self): ...\n    def step(self): ...\n"

    answer = sent(site, program)

    document = answer.get_json()
    assert (answer.status_code, document["state"], document["ok"]) == (200, "done", False)
    assert document["id"] is None
    assert [(p["line"], p["stage"]) for p in document["problems"]] == [(2, "read"), (3, "read")]
    assert "write step(self, observation)" in document["problems"][1]["sentence"]


def test_a_problem_in_an_archive_names_its_file(site: Site) -> None:
    answer = sent(site, beside_main(Entry(b"law/pid.py", b"def f(:\n")), "mine.zip")

    [problem] = answer.get_json()["problems"]
    assert (problem["file"], problem["line"]) == ("law/pid.py", 1)


def test_without_a_worker_a_check_is_queued_and_can_be_polled(site: Site) -> None:
    answer = sent(site, PROGRAM)

    assert (answer.status_code, answer.get_json()["state"]) == (202, "queued")
    later = site.call("owner", "GET", answer.headers["Location"])
    assert (later.status_code, later.get_json()["ok"]) == (200, None)
    assert later.headers["Retry-After"] == "1"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("changes", "status", "kind"),
    [
        ({"role": "guest"}, 403, "account-needed"),
        ({"role": "reader"}, 403, "scope-missing"),
        ({"config": {"kp": 99}}, 422, "invalid-configuration"),
        ({"benchmark": "nothing"}, 422, "invalid-request"),
        ({"name": "mine.exe"}, 422, "upload-rejected"),
        ({"program": b""}, 422, "upload-rejected"),
    ],
)
def test_an_invalid_check_is_refused_as_a_problem(
    site: Site, changes: dict[str, object], status: int, kind: str
) -> None:
    answer = sent(site, **({"program": PROGRAM} | changes))  # type: ignore[arg-type]

    assert (answer.status_code, answer.get_json()["type"]) == (status, f"/problems/{kind}")


def test_a_check_is_not_in_the_list_of_runs(site: Site) -> None:
    sent(site, PROGRAM)

    assert site.call("owner", "GET", "/api/v1/runs").get_json()["runs"] == []
