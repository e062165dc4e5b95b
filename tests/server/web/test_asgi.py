"""The WSGI application behind the web server: what clients do slowly or wrongly."""

import asyncio
import json
import threading
from collections.abc import AsyncGenerator, Iterable, Iterator
from contextlib import ExitStack
from typing import Any

import pytest

from seamark.embedded.protocols import Protocol
from seamark.server.web.asgi import CONTINUATION, LARGE_BODIES, THREADS, Connection
from seamark.server.web.received_body import BodyTooSlow, receive_body
from tests.services.asgi import BODY_MAX, answer_of, serving

MANY = THREADS + 8
END = b"\r\nHost: localhost\r\n\r\n"
QUICK = b"GET / HTTP/1.1" + END
DEADLINE_S = 60.0


def _echo(environ: dict[str, Any], start_response: Any) -> Iterable[bytes]:
    """Answer with what arrived."""
    body = environ["wsgi.input"].read()
    told = {key: value for key, value in environ.items() if isinstance(value, str)}
    start_response("200 OK", [("Content-Type", "application/json")])
    yield json.dumps({"environ": told, "bytes": len(body), "sum": sum(body)}).encode()


def _echoed(request: bytes) -> dict[str, Any]:
    with serving(_echo) as connect:
        answer, body = answer_of(connect(request))
    assert answer.status == 200
    found: dict[str, Any] = json.loads(body)
    return found


class _Large:
    """Answers /large with parts without end; counts what has been closed."""

    def __init__(self) -> None:
        self.closed = threading.Semaphore(0)

    def __call__(self, environ: dict[str, Any], start_response: Any) -> Iterable[bytes]:
        start_response("200 OK", [("Content-Type", "text/plain")])
        return self._parts() if environ["PATH_INFO"] == "/large" else [b"quick"]

    def _parts(self) -> Iterator[bytes]:
        try:
            while True:
                yield bytes(100_000)
        finally:
            self.closed.release()


@pytest.mark.slow
def test_health_is_answered_while_all_threads_wait() -> None:
    over, waiting = threading.Event(), threading.Semaphore(0)

    def answer(environ: dict[str, Any], start_response: Any) -> Iterable[bytes]:
        if environ["PATH_INFO"] == "/":
            waiting.release()
            over.wait(DEADLINE_S)
        start_response("200 OK", [("Content-Type", "text/plain")])
        return [b"ok"]

    with serving(answer) as connect, ExitStack() as stack:
        stack.callback(over.set)
        for _ in range(MANY):
            stack.enter_context(connect(QUICK))
        for _ in range(THREADS):
            assert waiting.acquire(timeout=DEADLINE_S)
        _, body = answer_of(connect(b"GET /readyz HTTP/1.1" + END))

    assert body == b"ok"


@pytest.mark.slow
def test_clients_that_do_not_read_hold_no_thread_and_are_forgotten_when_they_go() -> None:
    large = _Large()
    with serving(large) as connect:
        with ExitStack() as stack:
            for _ in range(MANY):
                stack.enter_context(connect(b"GET /large HTTP/1.1" + END)).recv(1)

            assert answer_of(connect(QUICK))[0].status == 200

        for _ in range(MANY):
            assert large.closed.acquire(timeout=DEADLINE_S)


def test_clients_that_send_slowly_hold_no_thread() -> None:
    with serving(_echo) as connect, ExitStack() as stack:
        for _ in range(MANY):
            start = b"POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 10\r\n\r\nx"
            stack.enter_context(connect(start))

        assert answer_of(connect(QUICK))[0].status == 200


@pytest.mark.parametrize("length", [0, 5, 300_000, BODY_MAX])
def test_a_body_arrives_whole(length: int) -> None:
    body = bytes(range(250)) * (length // 250 + 1)
    head = f"POST / HTTP/1.1\r\nContent-Length: {length}".encode() + END

    echoed = _echoed(head + body[:length])

    assert (echoed["bytes"], echoed["sum"]) == (length, sum(body[:length]))
    assert echoed["environ"]["CONTENT_LENGTH"] == str(length)


def test_a_body_of_unknown_length_arrives_with_its_length() -> None:
    head = b"POST / HTTP/1.1\r\nTransfer-Encoding: chunked" + END

    echoed = _echoed(head + b"3\r\nabc\r\n4\r\ndefg\r\n0\r\n\r\n")

    assert echoed["bytes"] == 7
    assert echoed["environ"]["CONTENT_LENGTH"] == "7"
    assert "HTTP_TRANSFER_ENCODING" not in echoed["environ"]


@pytest.mark.parametrize(
    "request_start",
    [
        b"POST / HTTP/1.1\r\nContent-Length: 1000000000" + END,
        b"POST / HTTP/1.1\r\nTransfer-Encoding: chunked" + END + b"1e8480\r\n" + bytes(2_000_000),
    ],
    ids=["declared", "chunked"],
)
def test_a_body_beyond_the_limit_is_not_received_but_its_length_is_told(
    request_start: bytes,
) -> None:
    echoed = _echoed(request_start)

    assert echoed["bytes"] == 0
    assert int(echoed["environ"]["CONTENT_LENGTH"]) > BODY_MAX


def test_a_header_with_an_underscore_is_not_taken_for_one_with_a_hyphen() -> None:
    lines = (
        b"\r\nX_Forwarded_For: 6.6.6.6\r\nX-Twice: a\r\nX-Twice: b\r\nCookie: a=1\r\nCookie: b=2"
    )

    environ = _echoed(b"GET /a%20b?q=%C3%A9 HTTP/1.1" + lines + END)["environ"]

    assert "HTTP_X_FORWARDED_FOR" not in environ
    assert (environ["HTTP_X_TWICE"], environ["HTTP_COOKIE"]) == ("a,b", "a=1; b=2")
    assert (environ["PATH_INFO"], environ["QUERY_STRING"]) == ("/a b", "q=%C3%A9")
    assert environ["REMOTE_ADDR"] == "127.0.0.1"


def test_the_answer_to_head_has_no_body() -> None:
    def application(_: dict[str, Any], start_response: Any) -> Iterable[bytes]:
        start_response("200 OK", [("Content-Length", "5")])
        return [b"hello"]

    with serving(application) as connect:
        answer, body = answer_of(connect(b"HEAD / HTTP/1.1" + END), "HEAD")

    assert (answer.status, answer.headers["Content-Length"], body) == (200, "5", b"")


def test_an_application_that_fails_is_a_server_error() -> None:
    def application(_: dict[str, Any], start_response: Any) -> Iterable[bytes]:
        raise OSError("no")

    with serving(application) as connect:
        assert answer_of(connect(QUICK))[0].status == 500


def test_a_continuation_follows_the_response_and_learns_when_the_client_goes() -> None:
    gone = threading.Event()

    async def follow(connection: Connection) -> AsyncGenerator[bytes, None]:
        yield b"second"
        await connection.gone
        gone.set()

    def application(environ: dict[str, Any], start_response: Any) -> Iterable[bytes]:
        environ[CONTINUATION] = follow
        start_response("200 OK", [("Content-Type", "text/plain")])
        return [b"first"]

    with serving(application) as connect:
        with connect(QUICK) as connection:
            data = b""
            while b"second" not in data:
                data += connection.recv(1000)

        assert gone.wait(DEADLINE_S)
    assert data.index(b"first") < data.index(b"second")


def test_a_continuation_can_close_the_connection_of_a_client_that_does_not_read() -> None:
    gone = threading.Event()

    async def follow(connection: Connection) -> AsyncGenerator[bytes, None]:
        connection.gone.add_done_callback(lambda _: gone.set())
        asyncio.get_running_loop().call_later(0.1, connection.abort)
        while not connection.gone.done():
            yield bytes(2**24)  # more than the kernel takes

    def application(environ: dict[str, Any], start_response: Any) -> Iterable[bytes]:
        environ[CONTINUATION] = follow
        start_response("200 OK", [("Content-Type", "text/plain")])
        return iter([b"first"])

    with serving(application) as connect, connect(QUICK):
        assert gone.wait(DEADLINE_S)


def test_large_bodies_beyond_those_that_may_be_on_the_disk_have_their_turn_too() -> None:
    head = b"POST / HTTP/1.1\r\nContent-Length: 200000" + END
    with serving(_echo) as connect, ExitStack() as stack:
        waiting = [stack.enter_context(connect(head)) for _ in range(LARGE_BODIES + 10)]
        for connection in waiting:
            connection.sendall(bytes(200_000))

        assert [answer_of(connection)[0].status for connection in waiting] == [200] * len(waiting)


@pytest.mark.slow
def test_a_head_that_does_not_end_is_given_up() -> None:
    class Impatient(Protocol):
        head_s = 0.2

    with serving(_echo, Impatient) as connect:
        with connect(b"GET / HTTP/1.1\r\nX-Slow: ") as connection:
            assert connection.recv(1) == b""
        assert answer_of(connect(QUICK))[0].status == 200


def test_a_body_that_does_not_arrive_is_given_up() -> None:
    async def receive() -> dict[str, Any]:
        await asyncio.Event().wait()
        raise AssertionError

    async def place() -> None: ...

    with pytest.raises(BodyTooSlow):
        asyncio.run(receive_body(receive, place, declared=5, limit=10, patience_s=0.05))


def test_a_client_that_goes_on_sending_a_refused_body_is_sent_away() -> None:
    start = f"POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: {2**30}\r\n\r\n".encode()

    with serving(_echo) as connect, connect(start) as connection:
        assert connection.recv(12) == b"HTTP/1.1 200"
        with pytest.raises(ConnectionError):
            connection.sendall(bytes(2**30))
