"""A rule has one sentence, whether it is broken by the form, by the API or by a check."""

import io
import json

import pytest

from tests import cast
from tests.server.api.conftest import Site

PROGRAM = b"class Controller:\n    def step(self, observation): ...\n"


def _multipart(benchmark: str = "currents-v1", **wanted: object) -> dict[str, object]:
    file = (io.BytesIO(PROGRAM), "mine.py")
    return {"run": json.dumps({"benchmark": benchmark} | wanted), "program": file}


@pytest.mark.parametrize("path", ["/api/v1/runs", "/api/v1/checks"])
def test_runs_and_checks_refuse_an_unknown_benchmark_alike(site: Site, path: str) -> None:
    answer = site.call("owner", "POST", path, data=_multipart("none-v1"))

    assert answer.status_code == 422
    assert answer.get_json()["detail"] == "There is no benchmark none-v1."
    assert [error["field"] for error in answer.get_json()["errors"]] == ["benchmark"]


@pytest.mark.parametrize("path", ["/api/v1/runs", "/api/v1/checks"])
def test_runs_and_checks_refuse_the_program_of_a_guest_alike(site: Site, path: str) -> None:
    answer = site.client().post(path, data=_multipart())

    assert answer.status_code == 403
    assert answer.get_json()["detail"] == "Uploading a program needs an account."


@pytest.mark.parametrize(
    ("wanted", "field"),
    [
        ({"trials": 99}, "trials"),
        ({"controller": "none"}, "controller"),
        ({}, "controller"),
    ],
)
def test_form_and_api_give_the_same_sentence(
    site: Site, wanted: dict[str, object], field: str
) -> None:
    submitted = {"benchmark": "currents-v1", "controller": "pi"} if "trials" in wanted else {}
    body = {"benchmark": "currents-v1"} | submitted | wanted

    problem = site.call("owner", "POST", "/api/v1/runs", json=body).get_json()
    form = {name: str(value) for name, value in body.items() if name != "benchmark"}
    client = site.client()
    secret = client.get("/sign-in").text.partition('name="csrf_token" value="')[2].partition('"')[0]
    page = client.post("/submit/currents-v1", data=form | {"csrf_token": secret})

    assert page.status_code == 422
    assert [error["field"] for error in problem["errors"]] == [field]
    assert problem["detail"] in page.text


def test_an_upload_beyond_the_quota_is_not_stored(site: Site) -> None:
    for _ in range(site.settings.quota_live):
        site.queue("ann")

    upload = _multipart() | {"program": (io.BytesIO(cast.PROGRAM), "mine.py")}
    answer = site.call("owner", "POST", "/api/v1/runs", data=upload)

    assert (answer.status_code, answer.get_json()["type"]) == (429, "/problems/quota-exceeded")
    assert not (site.settings.data / "programs").exists()
