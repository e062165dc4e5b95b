"""Whose programs may be connected, and to what; the worker's tests connect them."""

from typing import Any

import pytest

from seamark.server.web import authentication
from tests.server.api.conftest import Site

PATH = "/api/v1/rosbridge"


def test_a_request_that_is_no_websocket_is_told_so(site: Site) -> None:
    answer = site.call("owner", "GET", f"{PATH}?benchmark=currents-v1")

    assert answer.status_code == 426
    assert answer.headers["Upgrade"] == "websocket"


@pytest.mark.parametrize(
    ("query", "field", "reason"),
    [
        ("benchmark=visibility-v1", "benchmark", "a bridge connects a controller"),
        ("benchmark=nothing", "benchmark", "no benchmark nothing"),
        ("benchmark=currents-v1&trials=99", "trials", "1 to 10 trials"),
        ("benchmark=currents-v1&seed=-1", "seed", "whole number"),
        ('benchmark=currents-v1&config={"levls":[1]}', "levls", "levls"),
        ("benchmark=currents-v1&config=[1]", "config", "dictionary"),
        ("benchmark=currents-v1&config={", "config", "JSON"),
        ("benchmark=currents-v1&kind=ranked", "kind", "not permitted"),
    ],
)
def test_what_cannot_be_run_is_refused_before_anything_is_connected(
    site: Site, query: str, field: str, reason: str
) -> None:
    answer = site.call("owner", "GET", f"{PATH}?{query}")

    assert answer.status_code == 422
    problem: Any = answer.get_json()
    assert field in [error["field"] for error in problem["errors"]]
    assert reason in answer.text


@pytest.mark.slow
def test_a_cookie_connects_no_program(site: Site) -> None:
    browser = site.client()
    with site.app.app_context(), browser.session_transaction() as session:
        session.update(authentication.cookie_of(site.user_id("ann")))

    answer = browser.get(f"{PATH}?benchmark=currents-v1")

    assert answer.status_code == 401


def test_a_run_of_a_connected_program_cannot_be_submitted_otherwise(site: Site) -> None:
    order = {"benchmark": "currents-v1", "controller": "rosbridge"}

    answer = site.call("owner", "POST", "/api/v1/runs", json=order)

    assert answer.status_code == 422
    assert "no built-in controller rosbridge" in answer.text
