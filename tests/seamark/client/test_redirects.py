"""A token is for one server: real servers that point to each other."""

import asyncio
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import pytest

from seamark.client import AsyncClient, Client, ServerUnavailable

TOKEN = "smk_of_a_test"


class Server(ThreadingHTTPServer):
    """Answers everything with a status, pointing to an address; keeps the tokens it got."""

    def __init__(self, status: int, location: str) -> None:
        self.status, self.location = status, location
        self.tokens = list[str | None]()
        super().__init__(("127.0.0.1", 0), Answer)


class Answer(BaseHTTPRequestHandler):
    server: Server

    def do_GET(self) -> None:
        self.rfile.read(int(self.headers.get("Content-Length", 0)))
        self.server.tokens.append(self.headers["Authorization"])
        self.send_response(self.server.status)
        self.send_header("Location", self.server.location)
        self.send_header("Content-Length", "0")
        self.end_headers()

    do_POST = do_GET  # noqa: N815 - the name is that of http.server

    def log_message(self, *arguments: object) -> None:
        """Print nothing."""


@contextmanager
def serving(status: int, location: str = "") -> Iterator[Server]:
    with Server(status, location) as server:
        threading.Thread(target=server.serve_forever, args=(0.02,), daemon=True).start()
        yield server
        server.shutdown()


@pytest.mark.slow
@pytest.mark.parametrize("status", [301, 302, 303, 307, 308])
@pytest.mark.parametrize("host", ["127.0.0.1", "localhost"])
def test_a_token_follows_no_redirect(status: int, host: str) -> None:
    async def ask(address: str) -> None:
        async with AsyncClient(address, TOKEN) as client:
            await client.run(1)

    with serving(200) as elsewhere:
        target = f"http://{host}:{elsewhere.server_port}/api/v1/runs/1"
        with serving(status, target) as server:
            address = f"http://127.0.0.1:{server.server_port}"
            with Client(address, TOKEN) as client:
                with pytest.raises(ServerUnavailable, match=f"points to {target}"):
                    client.run(1)
                with pytest.raises(ServerUnavailable, match=f"points to {target}"):
                    client.submit("currents-v1", controller="pi")
            with pytest.raises(ServerUnavailable, match=f"points to {target}"):
                asyncio.run(ask(address))

    assert server.tokens == 3 * [f"Bearer {TOKEN}"]
    assert elsewhere.tokens == []
