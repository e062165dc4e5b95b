import re
from collections.abc import Iterator

import pytest
from flask import Flask
from werkzeug.test import TestResponse

from seamark.server.accounts import accounts
from seamark.server.app import create_app
from seamark.server.database.engine import Database
from seamark.server.settings import Settings
from tests.server.api.conftest import Site

ORDER = {"benchmark": "currents-v1", "controller": "p", "config": {}}
WRONG = {"name": "nobody", "password": "not the right one"}
SECRET = re.compile(r'name="csrf_token" value="([^"]+)"')


def test_an_accepted_run_has_its_own_retry_after(site: Site) -> None:
    answer = site.app.test_client().post("/api/v1/runs", json=ORDER)

    assert (answer.status_code, answer.headers["Retry-After"]) == (202, "2")
    assert "X-RateLimit-Retry-After" not in answer.headers


def test_a_rate_limited_request_has_retry_after(site: Site) -> None:
    client = site.app.test_client(use_cookies=False)  # counted by its address
    answers = [client.post("/api/v1/runs", json={}) for _ in range(31)]

    assert answers[-1].status_code == 429
    assert 0 <= int(answers[-1].headers["Retry-After"]) <= 60


@pytest.fixture
def behind_proxy(settings: Settings, database: Database) -> Iterator[Flask]:
    app = create_app(settings.model_copy(update={"proxies": 1}))
    yield app
    app.extensions["seamark"].close()


def _sign_in(app: Flask, address: str, who: dict[str, str] = WRONG) -> TestResponse:
    client, headers = app.test_client(), {"X-Forwarded-For": address}
    secret = SECRET.findall(client.get("/sign-in").text)[0]
    return client.post("/sign-in", data=who | {"csrf_token": secret}, headers=headers)


def test_behind_a_proxy_each_visitor_has_their_own_rate_limit(behind_proxy: Flask) -> None:
    codes = [_sign_in(behind_proxy, "192.0.2.1").status_code for _ in range(11)]

    assert codes[-1] == 429
    assert _sign_in(behind_proxy, "192.0.2.2").status_code == 422


def test_a_class_behind_one_address_can_sign_in_at_once(site: Site) -> None:
    with site.database.writing() as session:
        accounts.sign_up(session, "pupil", "a long password")
    right = {"name": "pupil", "password": "a long password"}

    codes = [_sign_in(site.app, "", right).status_code for _ in range(12)]

    assert codes == [302] * 12


def test_submissions_are_limited_per_account_and_not_per_address(site: Site) -> None:
    first = [site.call("owner", "POST", "/api/v1/runs", json={}) for _ in range(31)]
    other = site.call("admin", "POST", "/api/v1/runs", json={})

    assert (first[-1].status_code, other.status_code) == (429, 422)


def test_without_a_proxy_a_forged_address_is_ignored(site: Site) -> None:
    codes = [_sign_in(site.app, f"192.0.2.{i}").status_code for i in range(11)]

    assert codes[-1] == 429
