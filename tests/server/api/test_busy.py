"""Uploads that find no place: why, when to come again, and that the client does."""

import io
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import httpx
import pytest

from seamark.client import Client
from seamark.server.programs.reader import SLOTS, ProgramReader
from tests.cast import PROGRAM
from tests.server.api.conftest import Site

RUN = '{"benchmark": "currents-v1", "config": {}}'


@contextmanager
def _reading_with(site: Site, reader: ProgramReader) -> Iterator[ProgramReader]:
    """Let the application read uploads with another reader."""
    used = site.services
    site.app.extensions["seamark"] = replace(used, reader=reader)
    try:
        yield reader
    finally:
        reader.close()
        site.app.extensions["seamark"] = used


@pytest.fixture
def hasty(site: Site) -> Iterator[ProgramReader]:
    """A reader in which no upload waits for long for a place."""
    with _reading_with(site, ProgramReader(wait_s=0.01)) as reader:
        yield reader


def _fill(reader: ProgramReader) -> ExitStack:
    """Take all slots, until what is returned is closed."""
    held = ExitStack()
    for number in range(SLOTS):
        held.enter_context(reader.slots.taken(f"other {number}"))
    return held


def _upload() -> dict[str, Any]:
    return {"data": {"run": RUN, "program": (io.BytesIO(PROGRAM), "mine.py")}}


def test_an_upload_without_a_place_is_told_what_is_busy_and_when_to_come_again(
    site: Site, hasty: ProgramReader
) -> None:
    with _fill(hasty):
        answer = site.call("owner", "POST", "/api/v1/runs", **_upload())

    assert answer.status_code == 503
    after_s = int(answer.headers["Retry-After"])
    sentence = "Other uploads had all slots for 0.01 s."
    assert answer.get_json()["detail"] == f"{sentence} Try again in {after_s} s."
    assert 1 <= after_s <= 60


def test_the_form_says_what_is_busy_too(site: Site, hasty: ProgramReader) -> None:
    with _fill(hasty):
        form = {"controller": "upload", "program": (io.BytesIO(PROGRAM), "mine.py")}
        headers = {"Accept": "text/html"}
        answer = site.call("owner", "POST", "/submit/currents-v1", data=form, headers=headers)

    assert answer.status_code == 503
    assert "Other uploads had all slots" in answer.text
    assert answer.headers["Retry-After"].isdecimal()


def test_an_account_that_waits_with_as_many_uploads_as_it_may_is_told_that_they_are_its_own(
    site: Site,
) -> None:
    with _reading_with(site, ProgramReader(waiting_max=0)):
        answer = site.call("owner", "POST", "/api/v1/runs", **_upload())

    assert (answer.status_code, answer.get_json()["type"]) == (429, "/problems/rate-limited")
    assert "uploads of yours wait already" in answer.get_json()["detail"]
    assert int(answer.headers["Retry-After"]) >= 1


@pytest.mark.slow
def test_the_client_comes_again_and_starts_one_run(
    site: Site, hasty: ProgramReader, tmp_path: Path
) -> None:
    program = tmp_path / "mine.py"
    program.write_bytes(PROGRAM)
    token = site.headers["owner"]["Authorization"].removeprefix("Bearer ")
    asked = list[int]()
    held = _fill(hasty)

    class Transport(httpx.WSGITransport):
        def handle_request(self, request: httpx.Request) -> httpx.Response:
            answer = super().handle_request(request)
            if request.method == "POST":
                asked.append(answer.status_code)
                held.close()
            return answer

    with Client("http://service", token, transport=Transport(app=site.app)) as client:
        run = client.submit("currents-v1", program=program)
        listed = site.call("owner", "GET", "/api/v1/runs?owner=me").get_json()["runs"]

    assert asked == [503, 202]
    assert [one["id"] for one in listed] == [run.id]
