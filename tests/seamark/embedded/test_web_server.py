"""The web server for real: slow clients and large bodies make nobody else wait."""

import pytest

from tests.cast import Backend
from tests.services import web

SLOW = 300  # more than there ever were threads
HEAD = b"POST /api/v1/runs HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
STARTS = {"head": HEAD, "body": HEAD + b"Content-Length: 1000\r\n\r\n{"}

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def _unused() -> None: ...


@pytest.mark.parametrize("part", STARTS)
def test_pages_answer_while_hundreds_of_clients_send_slowly(backend: Backend, part: str) -> None:
    with (
        web.serving(backend.settings) as server,
        web.slow_connections(server, SLOW, STARTS[part]),
    ):
        assert server.get("/healthz", timeout=20)
        assert b"<h1" in server.get("/", timeout=20)
