"""Without room, or without the data folder, the service says so; it does not fail."""

import io
import json
import os
import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from flask.testing import FlaskClient
from werkzeug.test import TestResponse

from seamark.server.accounts import accounts
from seamark.server.app import create_app
from seamark.server.database.tables import Worker
from seamark.server.messaging import workers
from seamark.server.runs.data.files import RunFiles
from tests.cast import PI_RUN, PROGRAM, Backend

MORE_THAN_ANY_DISK = 2**62


class Browser:
    """Someone at the site, with ann's token for the API."""

    def __init__(self, client: FlaskClient, token: str) -> None:
        self.client = client
        self.token = {"Authorization": f"Bearer {token}"}

    def submit(self) -> TestResponse:
        return self.client.post("/api/v1/runs", json=PI_RUN, headers=self.token)

    def upload(self, path: str) -> TestResponse:
        file = (io.BytesIO(PROGRAM), "mine.py")
        run = json.dumps({"benchmark": "currents-v1"})
        data = {"run": run, "program": file}
        return self.client.post(path, data=data, headers=self.token)

    def form(self) -> TestResponse:
        page = self.client.get("/sign-in").text
        found = re.search(r'name="csrf_token" value="([^"]+)"', page)
        assert found is not None
        form = {"csrf_token": found[1], "controller": "pi", "kind": "practice"}
        return self.client.post("/submit/currents-v1", data=form)


def _browser(backend: Backend, **changes: object) -> Iterator[Browser]:
    with backend.database.writing() as session:
        token = accounts.new_token(session, backend.user_id("ann"), "t", ("read", "submit"))
    app = create_app(backend.settings.model_copy(update=changes))
    yield Browser(app.test_client(), token)
    app.extensions["seamark"].close()


@pytest.fixture
def full(backend: Backend) -> Iterator[Browser]:
    yield from _browser(backend, free_min_bytes=MORE_THAN_ANY_DISK)


@pytest.fixture
def recorded(backend: Backend) -> int:
    run_id = backend.published("eva")
    RunFiles(backend.settings.data, run_id, 1).append_log(b"hello\n")
    return run_id


@pytest.fixture
def away(backend: Backend, recorded: int, tmp_path: Path) -> Iterator[Browser]:
    """The data folder is gone; the database is elsewhere, as that of a public service."""
    for browser in _browser(backend):
        os.rename(backend.settings.data, tmp_path / "away")
        backend.settings.data.mkdir()  # the empty folder below a mount
        yield browser


@pytest.mark.slow
def test_a_full_disk_refuses_runs_checks_and_uploads_with_a_problem(full: Browser) -> None:
    for answer in (full.submit(), full.upload("/api/v1/runs"), full.upload("/api/v1/checks")):
        problem = answer.get_json()
        assert (answer.status_code, problem["type"]) == (503, "/problems/storage-unavailable")
        assert "too little free disk space" in problem["detail"]
        assert int(answer.headers["Retry-After"]) > 0


@pytest.mark.slow
def test_a_full_disk_is_a_sentence_on_the_form(full: Browser) -> None:
    answer = full.form()

    assert answer.status_code == 503
    assert "too little free disk space" in answer.text
    assert "<form" in answer.text


@pytest.mark.slow
def test_a_full_disk_is_on_readyz_and_in_the_metrics_and_pages_work(
    full: Browser, recorded: int
) -> None:
    ready, metrics = full.client.get("/readyz"), full.client.get("/metrics").text

    assert (ready.status_code, "disk space" in ready.get_json()["checks"]["storage"]) == (503, True)
    assert "seamark_storage_up 0.0" in metrics
    assert re.search(r"seamark_storage_free_bytes [1-9]", metrics)
    for path in ("/", f"/runs/{recorded}", "/leaderboards/currents-v1", "/submit/currents-v1"):
        assert full.client.get(path).status_code == 200
    assert "hello" in full.client.get(f"/api/v1/runs/{recorded}/log").text


def test_the_status_page_does_not_say_that_everything_works(
    full: Browser, backend: Backend
) -> None:
    row = Worker(name="w1@host", slots=1, level="strong", languages=["python"], findings=[])
    with backend.database.writing() as session:
        workers.register(session, row)

    page = full.client.get("/status").text

    assert ("too little free disk space" in page, "Everything works" in page) == (True, False)


def test_without_the_data_folder_pages_show_what_the_database_has(
    away: Browser, recorded: int
) -> None:
    page = away.client.get(f"/runs/{recorded}")

    assert page.status_code == 200
    assert "cannot be read at the moment" in page.text
    assert away.client.get("/").status_code == 200
    assert away.client.get(f"/api/v1/runs/{recorded}").get_json()["state"] == "succeeded"


@pytest.mark.parametrize(
    "file",
    [
        *("telemetry.csv", "telemetry.f64", "telemetry.npz", "archive.zip"),
        *("series.json?columns=x", "log", "camera.jpg", "dataset.zip"),
    ],
)
def test_without_the_data_folder_its_files_are_unavailable_not_empty(
    away: Browser, recorded: int, file: str
) -> None:
    answer = away.client.get(f"/api/v1/runs/{recorded}/{file}")

    assert answer.status_code == 503
    assert answer.get_json()["type"] == "/problems/storage-unavailable"


@pytest.mark.slow
def test_without_the_data_folder_nothing_is_accepted_and_nothing_written(
    away: Browser, backend: Backend
) -> None:
    answers = [away.submit(), away.upload("/api/v1/runs"), away.upload("/api/v1/checks")]

    assert [answer.status_code for answer in answers] == [503] * 3
    assert away.client.get("/readyz").get_json()["checks"]["storage"] != "ok"
    assert "seamark_storage_free_bytes 0.0" in away.client.get("/metrics").text
    assert list(backend.settings.data.iterdir()) == []


def test_when_the_data_folder_is_back_everything_works_again(
    away: Browser, backend: Backend, recorded: int, tmp_path: Path
) -> None:
    backend.settings.data.rmdir()
    os.rename(tmp_path / "away", backend.settings.data)

    assert away.submit().status_code == 202
    assert "hello" in away.client.get(f"/api/v1/runs/{recorded}/log").text


@pytest.mark.slow
def test_a_file_that_cannot_be_read_is_a_503_of_its_own_run(
    full: Browser, backend: Backend
) -> None:
    run_id = backend.published("eva")
    files = RunFiles(backend.settings.data, run_id, 1)
    files.append_log(b"hello\n")
    (files.folder / "log.txt").unlink()
    (files.folder / "log.txt").symlink_to("/proc/self/mem")  # reading it gives EIO

    answer = full.client.get(f"/api/v1/runs/{run_id}/log")

    assert answer.status_code == 503
    assert full.client.get("/").status_code == 200
