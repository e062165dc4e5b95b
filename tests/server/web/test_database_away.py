"""Without its database the service says so; it does not fail."""

from collections.abc import Iterator

import pytest
from flask.testing import FlaskClient

from seamark.server.app import create_app
from seamark.server.settings import Settings
from tests.services.ports import free_port


@pytest.fixture
def client(settings: Settings) -> Iterator[FlaskClient]:
    url = f"postgresql+psycopg://nobody@127.0.0.1:{free_port()}/none"
    app = create_app(settings.model_copy(update={"database_url": url}))
    yield app.test_client(use_cookies=False)
    app.extensions["seamark"].close()


@pytest.mark.parametrize("path", ["/", "/runs/", "/leaderboards/currents-v1"])
def test_a_page_is_unavailable_for_now(client: FlaskClient, path: str) -> None:
    answer = client.get(path, headers={"Accept": "text/html"})

    assert (answer.status_code, answer.headers["Retry-After"]) == (503, "5")
    assert "temporarily unavailable" in answer.text


@pytest.mark.parametrize("path", ["/api/v1/runs", "/api/v1/runs/1", "/api/v1/runs/1/events"])
def test_the_api_answers_with_the_problem_unavailable(client: FlaskClient, path: str) -> None:
    answer = client.get(path, headers={"Authorization": "Bearer smk_x"})

    assert (answer.status_code, answer.headers["Retry-After"]) == (503, "5")
    assert answer.get_json()["type"] == "/problems/unavailable"


def test_the_metrics_say_so(client: FlaskClient) -> None:
    assert "seamark_database_up 0.0" in client.get("/metrics").text


@pytest.mark.slow
def test_the_process_is_alive_but_not_ready(client: FlaskClient) -> None:
    assert client.get("/healthz").status_code == 200
    assert client.get("/readyz").get_json()["checks"]["database"] != "ok"
