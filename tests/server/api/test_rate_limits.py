import re
import socket
import tempfile
import time
from collections.abc import Iterator

import pytest
from flask import Flask
from werkzeug.test import TestResponse

from seamark.server.accounts import accounts
from seamark.server.app import create_app
from seamark.server.database.engine import Database
from seamark.server.settings import Settings
from seamark.server.web.rate_limits import limiter
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


@pytest.mark.slow
def test_behind_a_proxy_each_visitor_has_their_own_rate_limit(behind_proxy: Flask) -> None:
    codes = [_sign_in(behind_proxy, "192.0.2.1").status_code for _ in range(11)]

    assert codes[-1] == 429
    assert _sign_in(behind_proxy, "192.0.2.2").status_code == 422


@pytest.mark.slow
def test_a_class_behind_one_address_can_sign_in_at_once(site: Site) -> None:
    with site.database.writing() as session:
        accounts.sign_up(session, "pupil", "a long password")
    right = {"name": "pupil", "password": "a long password"}

    codes = [_sign_in(site.app, "", right).status_code for _ in range(12)]

    assert codes == [302] * 12


@pytest.mark.slow
def test_submissions_are_limited_per_account_and_not_per_address(site: Site) -> None:
    first = [site.call("owner", "POST", "/api/v1/runs", json={}) for _ in range(31)]
    other = site.call("admin", "POST", "/api/v1/runs", json={})

    assert (first[-1].status_code, other.status_code) == (429, 422)


@pytest.mark.slow
def test_repeating_a_run_is_limited_like_submitting_one(site: Site) -> None:
    path = f"/api/v1/runs/{site.succeeded('ann')}/rerun"
    answers = [site.call("owner", "POST", path) for _ in range(31)]
    reasons = [answer.get_json().get("type", "") for answer in answers]

    assert answers[0].status_code == 202
    assert reasons[29].endswith("quota-exceeded")
    assert reasons[30].endswith("rate-limited")


@pytest.mark.slow
def test_without_a_proxy_a_forged_address_is_ignored(site: Site) -> None:
    codes = [_sign_in(site.app, f"192.0.2.{i}").status_code for i in range(11)]

    assert codes[-1] == 429


@pytest.fixture
def forgetful_limiter() -> Iterator[None]:
    """Let the limiter, which a process has once, try the broker of the next test at once."""
    yield
    limiter._storage_dead = False


@pytest.fixture
def without_broker(
    settings: Settings, database: Database, forgetful_limiter: None
) -> Iterator[Flask]:
    app = create_app(settings.model_copy(update={"broker_url": "unix:///nowhere/broker.sock"}))
    yield app
    app.extensions["seamark"].close()


def test_while_the_broker_is_away_runs_are_accepted_and_pages_are_shown(
    without_broker: Flask,
) -> None:
    client = without_broker.test_client(use_cookies=False)

    posted = [client.post("/api/v1/runs", json=ORDER).status_code for _ in range(2)]
    shown = [client.get(path).status_code for path in ("/healthz", "/", "/api/v1/runs")]

    assert (posted, shown) == ([202, 202], [200, 200, 200])


@pytest.mark.slow
def test_while_the_broker_is_away_failed_sign_ins_are_still_limited(without_broker: Flask) -> None:
    codes = [_sign_in(without_broker, "").status_code for _ in range(11)]

    assert codes == [422] * 10 + [429]


@pytest.fixture
def silent_broker(forgetful_limiter: None) -> Iterator[str]:
    """Yield the URL of a socket on which nobody ever answers, like a stopped broker's."""
    with tempfile.TemporaryDirectory(prefix="vk") as folder, socket.socket(socket.AF_UNIX) as end:
        end.bind(f"{folder}/v.sock")
        end.listen(64)
        yield f"unix://{folder}/v.sock"


@pytest.mark.slow
def test_a_broker_that_does_not_answer_delays_a_sign_in_by_seconds_at_most(
    settings: Settings, database: Database, silent_broker: str
) -> None:
    app = create_app(settings.model_copy(update={"broker_url": silent_broker}))
    begin = time.monotonic()

    answer = _sign_in(app, "")

    assert answer.status_code == 422
    assert time.monotonic() - begin < 8.0
    app.extensions["seamark"].close()


@pytest.mark.slow
def test_guesses_of_one_password_are_limited_over_all_addresses(
    behind_proxy: Flask, database: Database
) -> None:
    with database.writing() as session:
        accounts.sign_up(session, "victim", "a long password")
        accounts.sign_up(session, "other", "a long password")
    wrong = {"name": "Victim", "password": "not the right one"}

    codes = [_sign_in(behind_proxy, f"192.0.2.{i}", wrong).status_code for i in range(21)]

    assert codes == [422] * 20 + [429]
    right = {"name": "other", "password": "a long password"}
    assert _sign_in(behind_proxy, "192.0.2.1", right).status_code == 302
