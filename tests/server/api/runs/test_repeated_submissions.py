"""A submission that is sent again with its Idempotency-Key starts nothing new."""

import io
import json
from collections.abc import Mapping
from typing import Any

import pytest

from tests.cast import PROGRAM
from tests.server.api.conftest import Site

RUN = {"benchmark": "currents-v1", "controller": "pi", "config": {"kp": 0.5}}
SWEEP = RUN | {"sweep": [{"name": "kp", "values": [0.1, 0.2]}]}


def _post(site: Site, body: Mapping[str, Any], key: str, **options: str) -> Any:
    path = "/api/v1/sweeps" if "sweep" in body else "/api/v1/runs"
    headers = {"Idempotency-Key": key}
    return site.call(options.get("role", "owner"), "POST", path, json=body, headers=headers)


def _runs(site: Site) -> int:
    return len(site.call("owner", "GET", "/api/v1/runs").get_json()["runs"])


@pytest.mark.slow
@pytest.mark.parametrize("body", [RUN, SWEEP])
def test_a_repeated_submission_answers_as_the_first(site: Site, body: dict[str, Any]) -> None:
    first, second = _post(site, body, "a"), _post(site, body, "a")
    count = _runs(site)
    other = _post(site, body, "b")

    assert (first.status_code, second.status_code) == (202, 202)
    assert first.get_json()["id"] == second.get_json()["id"]
    assert first.headers["Location"] == second.headers["Location"]
    assert other.get_json()["id"] != first.get_json()["id"]
    assert _runs(site) == 2 * count


@pytest.mark.slow
def test_a_repeated_upload_starts_one_run(site: Site) -> None:
    def upload(source: bytes) -> Any:
        run = json.dumps({"benchmark": "currents-v1"})
        data = {"run": run, "program": (io.BytesIO(source), "mine.py")}
        headers = {"Idempotency-Key": "u"}
        return site.call("owner", "POST", "/api/v1/runs", data=data, headers=headers)

    first, second, other = upload(PROGRAM), upload(PROGRAM), upload(PROGRAM + b"\n# changed\n")

    assert first.get_json()["id"] == second.get_json()["id"]
    assert other.status_code == 422


def test_a_key_is_refused_for_another_submission_and_free_for_another_account(site: Site) -> None:
    first = _post(site, RUN, "k")

    changed = _post(site, RUN | {"seed": 4}, "k")
    sweep = _post(site, SWEEP, "k")
    of_another = _post(site, RUN, "k", role="other")

    assert (changed.status_code, sweep.status_code, of_another.status_code) == (422, 422, 202)
    assert "another submission" in changed.get_json()["detail"]
    assert of_another.get_json()["id"] != first.get_json()["id"]


def test_a_submission_that_was_refused_can_be_sent_again(site: Site) -> None:
    wrong = _post(site, RUN | {"controller": "none"}, "k")

    assert wrong.status_code == 422
    assert _post(site, RUN, "k").status_code == 202


@pytest.mark.parametrize("key", ["", "x" * 201, "ä"])
def test_a_key_that_is_no_short_text_of_ascii_is_refused(site: Site, key: str) -> None:
    answer = _post(site, RUN, key)

    assert answer.status_code == 422
    assert answer.get_json()["errors"][0]["field"] == "Idempotency-Key"
