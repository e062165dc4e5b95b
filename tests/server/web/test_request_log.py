"""Each request has an id, which follows its run."""

from collections.abc import Iterator

import pytest
from flask.testing import FlaskClient

from seamark.server.app import create_app
from seamark.server.monitoring.log import request_id
from tests.cast import Backend


@pytest.fixture
def client(backend: Backend) -> Iterator[FlaskClient]:
    app = create_app(backend.settings)
    yield app.test_client()
    app.extensions["seamark"].close()


@pytest.mark.parametrize("given", ["0123456789abcdef", "trace-42.b_7", "a" * 64])
def test_a_valid_id_of_a_request_is_kept(client: FlaskClient, given: str) -> None:
    answer = client.get("/healthz", headers={"X-Request-ID": given})

    assert answer.headers["X-Request-ID"] == given


@pytest.mark.parametrize("given", ["", "short", "a" * 65, "12345678\x1b[2J", "1234 5678", "é" * 8])
def test_any_other_is_replaced(client: FlaskClient, given: str) -> None:
    headers = {"X-Request-ID": given}
    made = [client.get("/healthz", headers=headers).headers["X-Request-ID"] for _ in range(2)]

    assert given not in made
    assert len(set(made)) == 2


def test_the_claim_of_a_run_has_the_id_of_its_request(
    client: FlaskClient, backend: Backend
) -> None:
    run = {"benchmark": "currents-v1", "controller": "p"}
    client.get("/submit/")
    client.post("/api/v1/runs", json=run, headers={"X-Request-ID": "followed-1234"})

    assert backend.claim_next().request_id == "followed-1234"


def test_nothing_of_a_request_stays_in_its_thread(client: FlaskClient) -> None:
    client.get("/status", headers={"X-Request-ID": "followed-1234"})

    assert request_id() is None
