"""A program on this machine whose run is on a server: its messages are passed on, as they are."""

import asyncio
from collections.abc import Awaitable, Callable, Mapping
from typing import Any
from urllib.parse import urlencode

import orjson
from websockets.asyncio.client import ClientConnection, connect
from websockets.asyncio.server import ServerConnection, serve
from websockets.exceptions import ConnectionClosed, InvalidHandshake, InvalidStatus, InvalidURI

from seamark.bridge.rosbridge.protocol import LONGEST_MESSAGE
from seamark.bridge.rosbridge.server import (
    CLOSE_WITHIN_S,
    TRY_AGAIN_LATER,
    TcpAddress,
    allowed_origins,
)

BUSY = (409, 503)  # the account has a session already; no place is free
RETRY_S = 2.0  # unless the server says when to try again
PATIENCE_S = 600.0  # that a program may wait for a free place
OPEN_S = 20.0
FAILED = 1011  # close code of RFC 6455, 7.4.1
Open = Callable[[], Awaitable[ClientConnection]]


class Refusal(Exception):
    """The server refused the connection.

    Attributes
    ----------
    status : int
        The status of the answer; 0 if there was none.
    problem : dict
        The problem document of the answer (RFC 9457), or `detail` alone.
    """

    def __init__(self, status: int, problem: Mapping[str, Any]) -> None:
        self.status, self.problem = status, dict(problem)
        super().__init__(str(problem.get("detail", "The server refused.")))


def address_of(server: str, run: Mapping[str, Any]) -> str:
    """Return the address of the WebSocket for a run: `benchmark`, `config`, `seed`, ..."""
    texts = {
        name: orjson.dumps(value).decode() if isinstance(value, dict) else value
        for name, value in run.items()
        if value is not None
    }
    scheme, _, rest = server.rstrip("/").partition("://")
    web_socket = {"http": "ws", "https": "wss"}.get(scheme, scheme)
    return f"{web_socket}://{rest}/api/v1/rosbridge?{urlencode(texts)}"


async def opened(url: str, token: str, say: Callable[[str], None]) -> ClientConnection:
    """Return the connection to a server, after waiting until it has a place.

    Raises
    ------
    Refusal
        The server does not answer, or has refused.
    """
    clock = asyncio.get_running_loop().time
    until, waits = clock() + PATIENCE_S, False
    while True:
        try:
            return await connect(
                url,
                additional_headers={"Authorization": f"Bearer {token}"},
                max_size=None,
                compression=None,
                open_timeout=OPEN_S,
                close_timeout=CLOSE_WITHIN_S,
            )
        except InvalidStatus as answer:
            status, headers = answer.response.status_code, answer.response.headers
            problem = _problem(bytes(answer.response.body or b""))
            if status not in BUSY or clock() > until:
                raise Refusal(status, problem) from None
            if not waits:
                waits = True
                say(f"{problem.get('detail', 'The server is busy.')} Waiting ...")
            await asyncio.sleep(float(headers.get("Retry-After", RETRY_S)))
        except (OSError, TimeoutError, InvalidHandshake, InvalidURI) as error:
            why = str(error) or type(error).__name__
            raise Refusal(0, {"detail": f"The server cannot be reached: {why}."}) from None


async def forward_one(
    address: TcpAddress, open_session: Open, *, listening: Callable[[int], None]
) -> None:
    """Serve one program, whose messages go to a session and back, until either side ends.

    Parameters
    ----------
    open_session
        Is awaited when the program has connected.
    listening
        Gets the port.

    Raises
    ------
    OSError
        The address cannot be used.
    Refusal
        There is no session.
    """
    over: asyncio.Future[None] = asyncio.get_running_loop().create_future()
    taken = False

    async def handle(program: ServerConnection) -> None:
        nonlocal taken
        if taken:
            await program.close(TRY_AGAIN_LATER, "one program at a time")
            return
        taken = True
        try:
            async with await open_session() as session:
                await _forward(program, session)
            over.set_result(None)
        except Exception as error:
            await program.close(FAILED, str(error)[:100])
            over.set_exception(error)

    async with serve(
        *(handle, address.host, address.port),
        origins=allowed_origins(address),
        max_size=LONGEST_MESSAGE,
        compression=None,
        close_timeout=CLOSE_WITHIN_S,
    ) as running:
        listening(next(iter(running.sockets)).getsockname()[1])
        await over


async def _forward(program: ServerConnection, session: ClientConnection) -> None:
    await asyncio.gather(_pass_on(program, session), _pass_on(session, program))


async def _pass_on(
    source: ServerConnection | ClientConnection, sink: ServerConnection | ClientConnection
) -> None:
    """Pass on all messages of one side; when it has ended, so does the other."""
    try:
        async for message in source:
            await sink.send(message)
    except ConnectionClosed:
        pass  # so the other direction has ended, too
    finally:
        await sink.close()


def _problem(body: bytes) -> dict[str, Any]:
    try:
        problem = orjson.loads(body)
    except orjson.JSONDecodeError:
        problem = None
    return problem if isinstance(problem, dict) else {"detail": "This is no Seamark server."}
