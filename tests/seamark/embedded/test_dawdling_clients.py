"""Every state of a connection has an end, and the client is told why where it can be."""

import asyncio
import select
import socket
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from typing import Any

import pytest

from seamark.embedded.protocols import PINGS_MAX, Protocol, WebSocketProtocol
from seamark.server.web.websockets import CONVERSATION, UPGRADE, WebSocket
from tests.services.asgi import BODY_MAX, serving

SHORT_S = 0.3
DRIBBLE_S = 0.02
PATIENCE_S = 60.0
HOST = "Host: localhost"
KEY = "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ=="  # of RFC 6455, 1.3
UNVERSIONED = (HOST, "Upgrade: websocket", "Connection: Upgrade", KEY)
HANDSHAKE = (*UNVERSIONED, "Sec-WebSocket-Version: 13")
CHUNKED = "Transfer-Encoding: chunked"


class Hasty(Protocol):
    head_s = SHORT_S


class HastyWebSocket(WebSocketProtocol):
    accept_s = 1.5  # the other handshakes must be decided within it, on a busy machine too


class _Silent:
    """A conversation in which nothing is said; on `/undecided` it never begins."""

    def __init__(self, path: str) -> None:
        self._path = path

    async def begin(self) -> Mapping[str, str]:
        while self._path == "/undecided":
            await asyncio.sleep(DRIBBLE_S)
        return {}

    async def run(self, socket: WebSocket) -> str:
        while (message := await socket.receive()) is not None:
            await socket.send(message)
        return ""

    async def end(self) -> None: ...


def _application(environ: dict[str, Any], start_response: Any) -> Iterable[bytes]:
    """Converse, or answer with the number of bytes that arrived."""
    if environ.get(UPGRADE) and environ["PATH_INFO"] != "/page":
        environ[CONVERSATION] = _Silent(environ["PATH_INFO"])
        start_response("101 Switching Protocols", [])
        return []
    body = environ["wsgi.input"].read()
    large = int(environ["CONTENT_LENGTH"]) > BODY_MAX
    text = str(len(body)).encode()
    status = "413 Content Too Large" if large else "200 OK"
    start_response(status, [("Content-Length", str(len(text)))])
    return [text]


@pytest.fixture(scope="module")
def connect() -> Iterator[Callable[[bytes], socket.socket]]:
    with serving(
        _application, Hasty, HastyWebSocket, keep_alive_s=1, patience_s=SHORT_S, ping_s=SHORT_S
    ) as connecting:
        yield connecting


@pytest.fixture(scope="module")
def connect_patient() -> Iterator[Callable[[bytes], socket.socket]]:
    with serving(_application, keep_alive_s=1) as connecting:
        yield connecting


def _head(line: str, *headers: str) -> bytes:
    return "\r\n".join((line, *headers, "", "")).encode("latin-1")


def _frame(opcode: int, data: bytes = b"") -> bytes:
    return bytes([0x80 | opcode, 0x80 | len(data), 0, 0, 0, 0]) + data  # masked with zeros


GET = _head("GET / HTTP/1.1", HOST)
UPGRADED = _head("GET / HTTP/1.1", *HANDSHAKE)
PING, CLOSE = _frame(9), _frame(8)
ECHO = _frame(1, b"echo")


@dataclass(frozen=True)
class Misbehaviour:
    """What a client sends at first and then, bit by bit, until it is sent away."""

    answers: tuple[int, ...]  # status of each, in order
    first: bytes
    then: bytes = b""


def _post(*headers: str, body: bytes = b"") -> bytes:
    return _head("POST / HTTP/1.1", HOST, *headers) + body


def _upgrade(*more: str, line: str = "GET / HTTP/1.1", body: bytes = b"") -> bytes:
    return _head(line, *HANDSHAKE, *more) + body


MISBEHAVIOURS = {
    # A head that does not come, or does not end.
    "silence": Misbehaviour((), b""),
    "an endless head": Misbehaviour((), b"GET / HTTP/1.1\r\nX-Slow: ", b"x"),
    "an endless HEAD": Misbehaviour((), b"HEAD ", b"/"),
    "an endless head of an upgrade": Misbehaviour((), _upgrade()[:-2] + b"X-Slow: ", b"x"),
    "lines before a head": Misbehaviour((400,), b"\r\n", b"\r\n"),
    # Between requests.
    "silence after an answer": Misbehaviour((200,), GET),
    "an endless second head": Misbehaviour((200,), GET, b"G"),
    "a pipelined head that does not end": Misbehaviour((200, 200), GET + GET + b"GET /", b"x"),
    # A body that does not come, or does not end.
    "half a body": Misbehaviour((408,), _post("Content-Length: 10", body=b"half")),
    "an endless body": Misbehaviour((408,), _post("Content-Length: 99999"), b"x"),
    "a body that waits for leave": Misbehaviour(
        (100, 408), _post("Content-Length: 10", "Expect: 100-continue")
    ),
    "an endless size of a chunk": Misbehaviour((408,), _post(CHUNKED), b"1"),
    "a long size of a chunk": Misbehaviour((400,), _post(CHUNKED, body=b"1" * 30 + b"\r\n")),
    "an endless extension of a chunk": Misbehaviour((408,), _post(CHUNKED, body=b"1;"), b"x"),
    "endless chunks of a byte": Misbehaviour((408,), _post(CHUNKED), b"1\r\nx\r\n"),
    "endless trailers": Misbehaviour((408,), _post(CHUNKED, body=b"0\r\n"), b"X: y\r\n"),
    "a refused body that goes on": Misbehaviour((413,), _post("Content-Length: 9999999"), b"x"),
    "a refused body that stops": Misbehaviour((413,), _post("Content-Length: 9999999", body=b"x")),
    # What is no HTTP.
    "garbage": Misbehaviour((400,), b"\x16\x03\x01\r\n\r\n", b"x"),
    "an unknown coding": Misbehaviour((501,), _post("Transfer-Encoding: gzip"), b"x"),
    "a long head": Misbehaviour((431,), b"GET /" + b"x" * 20_000, b"x"),
    "a long extension of a chunk": Misbehaviour(
        (431,), _post(CHUNKED, body=b"1;" + b"x" * 20_000), b"x"
    ),
    "long trailers": Misbehaviour((431,), _post(CHUNKED, body=b"0\r\nX: " + b"x" * 20_000), b"x"),
    "a body that is no chunk": Misbehaviour((400,), _post(CHUNKED, body=b"xyz\r\n"), b"x"),
    # What cannot become a WebSocket.
    "an upgrade with a long line": Misbehaviour(
        (414,), _upgrade(line=f"GET /{'a' * 9000} HTTP/1.1"), b"x"
    ),
    "an upgrade with a long header": Misbehaviour((431,), _upgrade(f"X-Long: {'a' * 9000}"), b"x"),
    "an upgrade with 130 headers": Misbehaviour(
        (431,), _upgrade(*(f"X-{i}: a" for i in range(130))), b"x"
    ),
    "an upgrade with a body": Misbehaviour((400,), _upgrade("Content-Length: 3", body=b"abc")),
    "an upgrade without its body": Misbehaviour((400,), _upgrade("Content-Length: 3")),
    "an upgrade with an endless body": Misbehaviour((400,), _upgrade("Content-Length: 999"), b"x"),
    "an upgrade with chunks": Misbehaviour((400,), _upgrade(CHUNKED), b"0\r\n\r\n"),
    "an upgrade by POST": Misbehaviour((405,), _upgrade(line="POST / HTTP/1.1"), b"x"),
    "an upgrade with a control character": Misbehaviour((400,), _upgrade("X-Odd: a\x01b"), b"x"),
    "an upgrade with a frame": Misbehaviour((400,), UPGRADED + PING, PING),
    "an upgrade after a request": Misbehaviour((200, 405), GET + _upgrade(line="PUT / HTTP/1.1")),
    "an upgrade to HTTP/2": Misbehaviour(
        (200,), _head("GET / HTTP/1.1", HOST, "Connection: Upgrade", "Upgrade: h2c")
    ),
    # Handshakes that are refused, undecided or given up.
    "an upgrade without a version": Misbehaviour((400,), _head("GET / HTTP/1.1", *UNVERSIONED)),
    "an upgrade of a page": Misbehaviour((404,), _upgrade(line="GET /page HTTP/1.1")),
    "an upgrade that nobody decides": Misbehaviour((), _upgrade(line="GET /undecided HTTP/1.1")),
    "frames before the decision": Misbehaviour((), _upgrade(line="GET /undecided HTTP/1.1"), PING),
    # WebSockets.
    "silence after an upgrade": Misbehaviour((101,), UPGRADED),
    "half a frame": Misbehaviour((101,), UPGRADED, b"\x81"),
    "too many pings": Misbehaviour((101,), UPGRADED, PING * PINGS_MAX),
    "a frame without a mask": Misbehaviour((101,), UPGRADED, b"\x81\x01x"),
}


def _statuses(answer: bytes) -> tuple[int, ...]:
    """Return the status of each answer."""
    lines = answer.split(b"HTTP/1.1 ")[1:]
    return tuple(int(line[:3]) for line in lines)


def _until_closed(connection: socket.socket, then: bytes) -> bytes:
    """Return what arrives until the other side ends the connection, or resets it."""
    received = b""
    until = time.monotonic() + PATIENCE_S
    while time.monotonic() < until:
        readable, _, _ = select.select([connection], [], [], DRIBBLE_S)
        if readable:
            try:
                data = connection.recv(65536)
            except ConnectionError:
                return received
            if not data:
                return received
            received += data
        # Not before the answer to a handshake: what comes too early is another misbehaviour.
        if then and (b"Upgrade" not in received or b"\r\n\r\n" in received):
            with suppress(ConnectionError):
                connection.sendall(then)
    raise AssertionError(f"the connection stays; received {received!r}")


@pytest.mark.slow
@pytest.mark.parametrize("misbehaviour", MISBEHAVIOURS.values(), ids=MISBEHAVIOURS)
def test_who_misbehaves_is_told_and_sent_away(
    connect: Callable[[bytes], socket.socket], misbehaviour: Misbehaviour
) -> None:
    with connect(misbehaviour.first) as connection:
        received = _until_closed(connection, misbehaviour.then)

    assert _statuses(received) == misbehaviour.answers


WELL_BEHAVED = {
    "a head in pieces": ((200,), (b"GET / HTTP/1.1\r\n", b"Host: local", b"host\r\n\r\n")),
    "HEAD in pieces": ((200,), (b"HE", b"AD / HTTP/1.1\r\nHost: localhost\r\n", b"\r\n")),
    "two requests": ((200, 200), (GET, GET)),
    "two requests at once": ((200, 200), (GET + GET,)),
    "a body in pieces": ((200,), (_post("Content-Length: 9"), b"half", b", all")),
    "a body that waits for leave": (
        (100, 200),
        (_post("Content-Length: 4", "Expect: 100-continue"), b"body"),
    ),
    "chunks": ((200,), (_post(CHUNKED), b"4;a=b\r\nbo", b"dy\r\n0\r\nX: y", b"\r\n\r\n")),
    "a refused body that is sent": (
        (413, 200),
        (_post("Content-Length: 1000001"), b"x" * 1_000_001, GET),
    ),
    "an upgrade in pieces": ((101,), (UPGRADED[:50], UPGRADED[50:], ECHO, CLOSE)),
    "an upgrade with a long cookie": ((101,), (_upgrade(f"Cookie: a={'b' * 4000}"), ECHO, CLOSE)),
    "a frame in pieces": ((101,), (UPGRADED, ECHO[:3], ECHO[3:], PING, CLOSE)),
}


@pytest.mark.slow
@pytest.mark.parametrize(("answers", "pieces"), WELL_BEHAVED.values(), ids=WELL_BEHAVED)
def test_who_behaves_is_answered_beside_all_who_misbehave(
    connect_patient: Callable[[bytes], socket.socket],
    answers: tuple[int, ...],
    pieces: tuple[bytes, ...],
) -> None:
    received = b""
    with ExitStack() as others, connect_patient(b"") as connection:
        for misbehaviour in MISBEHAVIOURS.values():
            others.enter_context(connect_patient(misbehaviour.first))

        for piece in pieces:
            connection.sendall(piece)
            # Who speaks before the answer to its handshake, or leaves before its echo, has none.
            due = answers == (101,) and piece.endswith((b"\r\n\r\n", b"echo"))
            readable, _, _ = select.select([connection], [], [], PATIENCE_S if due else DRIBBLE_S)
            received += connection.recv(65536) if readable else b""
        received += _until_closed(connection, b"")

    assert _statuses(received) == answers
    assert (b"echo" in received) == (answers == (101,))
