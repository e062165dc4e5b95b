"""WebSockets behind the web server's protocol: handshakes, and clients that behave badly."""

import asyncio
import json
import socket
import threading
from collections.abc import Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from typing import Any

import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import ClientConnection, connect

from seamark.embedded.protocols import (
    FRAGMENTS_MAX,
    MESSAGE_MAX,
    Protocol,
    WebSocketProtocol,
)
from seamark.server.web import websockets
from seamark.server.web.problems import Problem
from seamark.server.web.websockets import CONVERSATION, UPGRADE, WebSocket
from tests.services.asgi import serving

PATIENCE_S = 60.0


class Echo:
    """Sends back what it receives; `/refused` has no conversation, `/flood` sends without end."""

    def __init__(self) -> None:
        self.ended = threading.Semaphore(0)
        self.path = ""

    def __call__(self, environ: dict[str, Any], start_response: Any) -> Iterable[bytes]:
        self.path = environ["PATH_INFO"]
        if self.path == "/endless":
            start_response("200 OK", [("Content-Type", "text/plain")])
            return self._parts()
        if not environ.get(UPGRADE) or self.path == "/not-found":
            start_response("404 Not Found", [("Content-Type", "text/plain")])
            return [b"nothing ", b"here"]
        environ[CONVERSATION] = self
        start_response("101 Switching Protocols", [])
        return []

    def _parts(self) -> Iterator[bytes]:
        try:
            while True:
                yield bytes(100_000)
        finally:
            self.ended.release()

    async def begin(self) -> Mapping[str, str]:
        if self.path == "/refused":
            raise Problem("unavailable", "Not now.", headers={"Retry-After": "5"})
        return {"Location": "/somewhere"}

    async def run(self, socket: WebSocket) -> str:
        while self.path == "/flood":
            await socket.send("x" * 100_000)
        while (message := await socket.receive()) is not None:
            if message.startswith("end"):
                return message.removeprefix("end").strip()
            await socket.send(message)
        return ""

    async def end(self) -> None:
        self.ended.release()


class Hasty(Protocol):
    """A server that waits for a request for a moment."""

    head_s = 0.2


@contextmanager
def _served(echo: Echo, path: str = "/", **options: Any) -> Iterator[ClientConnection]:
    with ExitStack() as stack:
        connecting = stack.enter_context(serving(echo, Hasty))
        with connecting(b"") as probe:
            host, port = probe.getpeername()
        url = f"ws://{host}:{port}{path}"
        yield stack.enter_context(connect(url, compression=None, max_size=None, **options))


@pytest.mark.slow
def test_a_conversation_lasts_longer_than_a_request_may_take_to_arrive() -> None:
    echo = Echo()
    with _served(echo) as client:
        client.send("hello")
        first = client.recv(timeout=PATIENCE_S)
        with pytest.raises(TimeoutError):
            client.recv(timeout=4 * Hasty.head_s)
        client.send("again")
        second = client.recv(timeout=PATIENCE_S)
        client.send("end")
        with pytest.raises(ConnectionClosed) as closed:
            client.recv(timeout=PATIENCE_S)

    assert client.response is not None
    assert client.response.headers["Location"] == "/somewhere"
    assert (first, second) == ("hello", "again")
    assert closed.value.rcvd is not None
    assert closed.value.rcvd.code == 1000
    assert echo.ended.acquire(timeout=PATIENCE_S)


def test_a_conversation_that_goes_wrong_ends_with_the_reason() -> None:
    with _served(Echo()) as client:
        client.send("end The run is lost.")
        with pytest.raises(ConnectionClosed) as closed:
            client.recv(timeout=PATIENCE_S)

    assert closed.value.rcvd is not None
    assert (closed.value.rcvd.code, closed.value.rcvd.reason) == (1011, "The run is lost.")


@pytest.mark.slow
def test_what_refuses_a_handshake_is_an_answer_as_to_any_request() -> None:
    echo = Echo()
    with pytest.raises(InvalidStatus) as not_found, _served(echo, "/not-found"):
        pass
    with pytest.raises(InvalidStatus) as refused, _served(echo, "/refused"):
        pass

    assert not_found.value.response.status_code == 404
    assert not_found.value.response.body == b"nothing here"
    answer = refused.value.response
    assert (answer.status_code, answer.headers["Retry-After"]) == (503, "5")
    assert json.loads(bytes(answer.body or b""))["detail"] == "Not now."
    assert echo.ended.acquire(timeout=PATIENCE_S)  # what it had prepared is released


def test_a_download_is_no_websocket_and_is_not_read_for_one() -> None:
    echo = Echo()
    with pytest.raises(InvalidStatus) as refused, _served(echo, "/endless"):
        pass

    assert refused.value.response.status_code == 404
    assert echo.ended.acquire(timeout=PATIENCE_S)


@pytest.mark.slow
def test_a_client_that_reads_no_answers_to_its_pings_is_not_listened_to() -> None:
    ping = bytes([0x89, 0xFD, 0, 0, 0, 0]) + bytes(125)  # masked with zeros

    with _raw(Echo(), Patient) as connection:
        connection.settimeout(2.0)
        with pytest.raises(TimeoutError):
            connection.sendall(ping * 500_000)  # 65 MB; the kernel takes some of it


def test_a_message_in_pieces_without_end_closes_the_connection() -> None:
    first, more = bytes([0x01, 0x80, 0, 0, 0, 0]), bytes([0x00, 0x80, 0, 0, 0, 0])

    with _raw(Echo()) as connection:
        connection.settimeout(PATIENCE_S)
        connection.sendall(first + more * 2 * FRAGMENTS_MAX)
        with suppress(ConnectionResetError):
            assert connection.recv(1) == b""


class Patient(WebSocketProtocol):
    """A server that minds no number of pings."""

    pings_max = 10**9


@contextmanager
def _raw(
    echo: Echo, protocol: type[WebSocketProtocol] = WebSocketProtocol
) -> Iterator[socket.socket]:
    """Give a connection after its handshake."""
    key = "dGhlIHNhbXBsZSBub25jZQ=="  # of RFC 6455, 1.3
    lines = ("GET / HTTP/1.1", "Host: localhost", "Upgrade: websocket", "Connection: Upgrade")
    more = (f"Sec-WebSocket-Key: {key}", "Sec-WebSocket-Version: 13", "", "")
    with serving(echo, web_socket=protocol) as connect_raw:
        with connect_raw("\r\n".join((*lines, *more)).encode()) as connection:
            head = b""
            while not head.endswith(b"\r\n\r\n"):
                head += connection.recv(1)
            assert head.startswith(b"HTTP/1.1 101")
            yield connection


@pytest.mark.parametrize("message", ["x" * (MESSAGE_MAX + 1), b"not text"])
def test_a_message_that_is_too_long_or_no_text_ends_the_conversation(message: str | bytes) -> None:
    echo = Echo()
    with _served(echo) as client:
        client.send(message)
        with pytest.raises(ConnectionClosed):
            client.recv(timeout=PATIENCE_S)

        assert echo.ended.acquire(timeout=PATIENCE_S)


@pytest.mark.slow
def test_a_client_that_does_not_read_is_disconnected(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(websockets, "SEND_S", 0.3)
    echo = Echo()
    with _served(echo, "/flood", max_queue=1, close_timeout=0.1):
        assert echo.ended.acquire(timeout=PATIENCE_S)


def test_a_client_that_leaves_ends_the_conversation() -> None:
    echo = Echo()
    with _served(echo) as client:
        client.send("hello")

    assert echo.ended.acquire(timeout=PATIENCE_S)


def test_a_message_that_cannot_be_sent_is_an_error_of_the_connection(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(websockets, "SEND_S", 0.01)
    aborted = list[bool]()

    async def receive() -> dict[str, Any]:
        return {}

    async def stuck(_message: dict[str, Any]) -> None:
        await asyncio.sleep(PATIENCE_S)

    async def send() -> None:
        await WebSocket(receive, stuck, lambda: aborted.append(True)).send("hello")

    with pytest.raises(ConnectionError):
        asyncio.run(send())

    assert aborted == [True]
