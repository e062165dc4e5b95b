"""A program on this machine, and a server that has its run."""

import asyncio
import time
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import asynccontextmanager
from http import HTTPStatus
from typing import Any
from urllib.parse import parse_qs, urlsplit

import orjson
import pytest
from websockets.asyncio.client import ClientConnection, connect
from websockets.asyncio.server import ServerConnection, serve
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response

from seamark.bridge.rosbridge import forwarding
from seamark.bridge.rosbridge.forwarding import Refusal
from seamark.bridge.rosbridge.server import TcpAddress
from seamark.client import retry_after

TOKEN = "smk_of_a_test"
BUSY = "All places are taken."


class Server:
    """Answers handshakes with the statuses in `refusals`, one after the other, then echoes."""

    def __init__(
        self, *refusals: int, headers: Sequence[tuple[str, str]] = (), detail: str = BUSY
    ) -> None:
        self.refusals, self.headers, self.detail = [*refusals], headers, detail
        self.requests = list[Request]()
        self.times_s = list[float]()

    def process(self, connection: ServerConnection, request: Request) -> Response | None:
        self.requests.append(request)
        self.times_s.append(time.monotonic())
        if not self.refusals:
            return None
        text = orjson.dumps({"detail": self.detail}).decode()
        answer = connection.respond(HTTPStatus(self.refusals.pop(0)), text)
        for name, value in self.headers:
            answer.headers[name] = value
        return answer

    async def echo(self, connection: ServerConnection) -> None:
        async for message in connection:
            if message == "end":
                return
            await connection.send(f"{message!s} from the server")


Program = Callable[[str], Any]


async def _forward(server: Server, program: Program, said: list[str]) -> Any:
    """Return what a program returns whose messages go to the server and back."""
    listening: asyncio.Future[int] = asyncio.get_running_loop().create_future()
    async with serve(server.echo, "127.0.0.1", 0, process_request=server.process) as running:
        port = next(iter(running.sockets)).getsockname()[1]
        url = forwarding.address_of(f"http://127.0.0.1:{port}/", {"benchmark": "b", "seed": None})

        async def open_session() -> ClientConnection:
            return await forwarding.opened(url, TOKEN, said.append, lambda *_: 0.0)

        address = TcpAddress("127.0.0.1", 0)
        forwarded = forwarding.forward_one(address, open_session, listening=listening.set_result)
        task = asyncio.create_task(forwarded)
        found = await program(f"ws://127.0.0.1:{await listening}")
        await task
        return found


async def _talk(url: str) -> list[str]:
    async with connect(url) as socket:
        await socket.send("hello")
        first = str(await socket.recv())
        await socket.send("end")
        return [first, *[str(message) async for message in socket]]


def test_messages_go_both_ways_until_the_server_ends() -> None:
    server, said = Server(), list[str]()

    assert asyncio.run(_forward(server, _talk, said)) == ["hello from the server"]

    (request,) = server.requests
    assert request.headers["Authorization"] == f"Bearer {TOKEN}"
    assert parse_qs(urlsplit(request.path).query) == {"benchmark": ["b"]}
    assert not said


def test_a_program_waits_until_the_server_has_a_place() -> None:
    server, said = Server(503, 409, 503), list[str]()

    assert asyncio.run(_forward(server, _talk, said)) == ["hello from the server"]

    assert said == [f"{BUSY} Waiting ..."]


def test_a_program_that_leaves_ends_the_session() -> None:
    async def leave(url: str) -> None:
        async with connect(url) as socket:
            await socket.send("hello")

    asyncio.run(_forward(Server(), leave, []))


def test_a_second_program_is_sent_away() -> None:
    async def both(url: str) -> list[str]:
        async with connect(url) as first, connect(url) as second:
            with pytest.raises(ConnectionClosed) as closed:
                await second.recv()
            await first.send("hello")
            return [str(closed.value), str(await first.recv())]

    why, heard = asyncio.run(_forward(Server(), both, []))

    assert "one program at a time" in why
    assert heard == "hello from the server"


@pytest.mark.parametrize("status", [401, 403, 422, 429])
def test_a_refusal_reaches_the_program_and_whoever_started_the_bridge(status: int) -> None:
    async def refused(url: str) -> str:
        async with connect(url) as socket:
            with pytest.raises(ConnectionClosed) as closed:
                await socket.recv()
            return str(closed.value)

    seen = list[str]()

    async def both(url: str) -> None:
        seen.append(await refused(url))

    with pytest.raises(Refusal) as refusal:
        asyncio.run(_forward(Server(status), both, []))

    assert refusal.value.status == status
    assert refusal.value.problem == {"detail": BUSY}
    assert BUSY in seen[0]


def test_a_server_that_is_not_there_is_a_refusal_without_a_status() -> None:
    with pytest.raises(Refusal, match="cannot be reached") as refusal:
        asyncio.run(_opened("ws://127.0.0.1:1/"))

    assert refusal.value.status == 0


async def _opened(url: str) -> ClientConnection:
    return await forwarding.opened(url, TOKEN, print, retry_after.pause_s)


@asynccontextmanager
async def _serving(server: Server, host: str = "127.0.0.1") -> AsyncIterator[str]:
    async with serve(server.echo, host, 0, process_request=server.process) as running:
        port = next(iter(running.sockets)).getsockname()[1]
        yield f"ws://{host}:{port}/api/v1/rosbridge"


@pytest.mark.parametrize("status", [301, 302, 303, 307, 308])
@pytest.mark.parametrize("host", ["127.0.0.1", "localhost"])
def test_a_token_follows_no_redirect(status: int, host: str) -> None:
    elsewhere = Server()

    async def redirected() -> tuple[Server, str]:
        async with _serving(elsewhere, host) as target:
            server = Server(status, headers=[("Location", target)])
            async with _serving(server) as url:
                with pytest.raises(Refusal, match=f"points to {target}") as refusal:
                    await _opened(url)
                async with await _opened(url):
                    pass
            return server, str(refusal.value)

    server, said = asyncio.run(redirected())

    assert not elsewhere.requests
    tokens = [request.headers.get("Authorization") for request in server.requests]
    assert tokens == 2 * [f"Bearer {TOKEN}"]
    assert TOKEN not in said


@pytest.mark.slow
@pytest.mark.parametrize(
    "waits", [["-1"], ["soon"], ["0"], [""], ["Wed, 21 Oct 2015 07:28:00 GMT"], ["0", "-5"], []]
)
def test_a_server_that_asks_for_no_pause_gets_one(waits: Sequence[str]) -> None:
    server = Server(503, 409, headers=[("Retry-After", wait) for wait in waits])

    async def waited() -> None:
        async with _serving(server) as url, await _opened(url):
            pass

    asyncio.run(waited())

    first, second, third = server.times_s
    assert second - first >= retry_after.FIRST_PAUSE_S / 2
    assert third - second >= retry_after.FIRST_PAUSE_S


@pytest.mark.parametrize("wait", ["86400", "9" * 400, "Fri, 31 Dec 9999 23:59:59 GMT"])
def test_a_program_does_not_wait_for_a_place_that_is_free_tomorrow(wait: str) -> None:
    server = Server(503, headers=[("Retry-After", wait)])

    async def refused() -> None:
        async with _serving(server) as url:
            await _opened(url)

    with pytest.raises(Refusal, match=r"All places are taken\.") as refusal:
        asyncio.run(refused())

    assert refusal.value.status == 503


def test_a_server_that_does_not_say_which_run_is_no_seamark_server() -> None:
    async def opened() -> int:
        async with _serving(Server()) as url, await _opened(url) as session:
            return forwarding.run_of(session)

    with pytest.raises(Refusal, match="no Seamark server"):
        asyncio.run(opened())


def test_a_refusal_in_another_script_reaches_whoever_started_the_bridge() -> None:
    async def refused(url: str) -> None:
        async with connect(url) as socket:
            with pytest.raises(ConnectionClosed):
                await socket.recv()

    with pytest.raises(Refusal, match="没有空位"):
        asyncio.run(_forward(Server(401, detail="没有空位" * 40), refused, []))


@pytest.mark.parametrize(
    ("server", "expected"),
    [
        ("http://127.0.0.1:8000", "ws://127.0.0.1:8000/api/v1/rosbridge?benchmark=b&config=%7B%7D"),
        ("https://a.example/", "wss://a.example/api/v1/rosbridge?benchmark=b&config=%7B%7D"),
    ],
)
def test_the_address_is_that_of_the_server(server: str, expected: str) -> None:
    assert forwarding.address_of(server, {"benchmark": "b", "config": {}}) == expected
