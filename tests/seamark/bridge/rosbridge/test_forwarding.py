"""A program on this machine, and a server that has its run."""

import asyncio
from collections.abc import Callable
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

TOKEN = "smk_of_a_test"
BUSY = {"detail": "All places are taken."}


class Server:
    """Answers handshakes with the statuses in `refusals`, one after the other, then echoes."""

    def __init__(self, *refusals: int) -> None:
        self.refusals = [*refusals]
        self.requests = list[Request]()

    def process(self, connection: ServerConnection, request: Request) -> Response | None:
        self.requests.append(request)
        if not self.refusals:
            return None
        text = orjson.dumps(BUSY).decode()
        answer = connection.respond(HTTPStatus(self.refusals.pop(0)), text)
        answer.headers["Retry-After"] = "0"
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
            return await forwarding.opened(url, TOKEN, said.append)

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

    assert said == ["All places are taken. Waiting ..."]


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
    assert refusal.value.problem == BUSY
    assert "All places are taken." in seen[0]


def test_a_server_that_is_not_there_is_a_refusal_without_a_status() -> None:
    with pytest.raises(Refusal, match="cannot be reached") as refusal:
        asyncio.run(forwarding.opened("ws://127.0.0.1:1/", TOKEN, print))

    assert refusal.value.status == 0


@pytest.mark.parametrize(
    ("server", "expected"),
    [
        ("http://127.0.0.1:8000", "ws://127.0.0.1:8000/api/v1/rosbridge?benchmark=b&config=%7B%7D"),
        ("https://a.example/", "wss://a.example/api/v1/rosbridge?benchmark=b&config=%7B%7D"),
    ],
)
def test_the_address_is_that_of_the_server(server: str, expected: str) -> None:
    assert forwarding.address_of(server, {"benchmark": "b", "config": {}}) == expected
