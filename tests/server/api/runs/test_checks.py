"""POST /checks without a worker: what reading shows, what waits, what is refused."""

import io
import json

import cv2
import numpy as np
import pytest
from werkzeug.test import TestResponse

from seamark.programs.check_report import from_diagnostics
from seamark.server.programs import check_queue
from seamark.sim.recording.telemetry import INDEX
from tests.cast import PROGRAM
from tests.hostile.uploads.archives import Entry, beside_main
from tests.server.api.conftest import Site
from tests.sim.metrics.detector_rows import Answered, Image, rectangle, rows_of

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


@pytest.mark.slow
def test_the_first_images_of_a_detector_are_shown_to_its_owner_alone(site: Site) -> None:
    program = (
        b"class Detector:\n    def __init__(self, config): ...\n    def detect(self, image): ...\n"
    )
    check_id = sent(site, program, benchmark="patterns-v1").get_json()["id"]
    row = rows_of([Image({}, [Answered("box", rectangle(10, 10, 80, 40))])])[0]
    row[INDEX["z"]], row[INDEX["t"]] = 3.0, 0.5
    values = [None if np.isnan(value) else value for value in row.tolist()]
    with site.database.writing() as session:
        claim = check_queue.claim(session, "w1", languages=("python",), lease_s=60.0)
        assert claim is not None
        seen = {check_queue.SEEN: {"seed": 1, "rows": [values]}}
        assert check_queue.finish(session, claim, from_diagnostics([]) | seen)

    document = site.call("owner", "GET", f"{CHECKS}/{check_id}").get_json()
    first = site.call("owner", "GET", document["images"][0])
    answers = {
        (role, image): site.call(role, "GET", f"{CHECKS}/{check_id}/camera.jpg?image={image}")
        for role, image in (("other", 0), ("owner", 1))
    }

    assert len(document["images"]) == 1
    assert check_queue.SEEN not in document
    assert first.content_type == "image/jpeg"
    image = np.asarray(cv2.imdecode(np.frombuffer(first.data, np.uint8), 1)).astype(int)
    assert ((image[:, :, 2] > 200) & (image[:, :, 0] < 120)).sum() > 100  # a red false alarm
    assert {answer.status_code for answer in answers.values()} == {404}
