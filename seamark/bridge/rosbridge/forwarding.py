"""A program on this machine whose run is on a server: its messages are passed on, as they are."""

import asyncio
from collections.abc import Awaitable, Callable, Mapping
from typing import Any
from urllib.parse import urlencode

import orjson
from websockets.asyncio.client import ClientConnection, connect
from websockets.asyncio.server import ServerConnection, serve
from websockets.exceptions import ConnectionClosed, InvalidHandshake, InvalidStatus, InvalidURI
from websockets.http11 import Response

from seamark.bridge.rosbridge.protocol import LONGEST_MESSAGE
from seamark.bridge.rosbridge.server import (
    CLOSE_WITHIN_S,
    TRY_AGAIN_LATER,
    TcpAddress,
    allowed_origins,
)

BUSY = (409, 503)  # the account has a session already; no slot is free
PATIENCE_S = 600.0  # that a program may wait for a free slot
OPEN_S = 20.0
FAILED = 1011  # close code of RFC 6455, 7.4.1
REDIRECTIONS = range(300, 400)
REASON_BYTES = 123  # of a close frame, 5.5.1
Open = Callable[[], Awaitable[ClientConnection]]
Pause = Callable[[str, int], float]
NO_SEAMARK = "This is no Seamark server."


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


class _Connect(connect):
    """Opens a connection to the address that was given, and to no other.

    By itself `connect` follows redirects; before 16.1 it took the token along to any host.
    """

    def process_redirect(self, exc: Exception) -> Exception | str:
        """Return why there is no connection: a redirect is an answer like any other."""
        return exc


async def opened(
    url: str, token: str, say: Callable[[str], None], pause_s: Pause
) -> ClientConnection:
    """Return the connection to a server, after waiting until it has a slot.

    Parameters
    ----------
    pause_s
        Returns how long to wait [s], given the header Retry-After and how many attempts there were
        before.

    Raises
    ------
    Refusal
        The server does not answer, or has refused.
    """
    clock = asyncio.get_running_loop().time
    until, attempt = clock() + PATIENCE_S, 0
    while True:
        try:
            return await _Connect(
                url,
                additional_headers={"Authorization": f"Bearer {token}"},
                max_size=None,
                compression=None,
                open_timeout=OPEN_S,
                close_timeout=CLOSE_WITHIN_S,
            )
        except InvalidStatus as answer:
            refusal = _refusal(answer.response)
            wait_s = pause_s(_header(answer.response, "Retry-After"), attempt)
            if refusal.status not in BUSY or clock() + wait_s > until:
                raise refusal from None
        except (OSError, TimeoutError, InvalidHandshake, InvalidURI) as error:
            why = str(error) or type(error).__name__
            raise Refusal(0, {"detail": f"The server cannot be reached: {why}."}) from None
        if not attempt:
            say(f"{refusal} Waiting ...")
        attempt += 1
        await asyncio.sleep(wait_s)


def run_of(session: ClientConnection) -> int:
    """Return the run that a session has; raises Refusal if the server does not say it."""
    assert session.response is not None  # noqa: S101 - the handshake is complete
    number = _header(session.response, "Location").rpartition("/")[2]
    if not (number.isascii() and number.isdecimal()):
        raise Refusal(0, {"detail": NO_SEAMARK})
    return int(number)


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
    first: asyncio.Future[ServerConnection] = asyncio.get_running_loop().create_future()

    async def handle(program: ServerConnection) -> None:
        if first.done():
            await program.close(TRY_AGAIN_LATER, "one program at a time")
            return
        first.set_result(program)
        await program.wait_closed()

    async with serve(
        *(handle, address.host, address.port),
        origins=allowed_origins(address),
        max_size=LONGEST_MESSAGE,
        compression=None,
        close_timeout=CLOSE_WITHIN_S,
    ) as running:
        listening(next(iter(running.sockets)).getsockname()[1])
        # Not in `handle`: nothing cancels that, and it would wait for a slot after Ctrl-C.
        await _forward(await first, open_session)


async def _forward(program: ServerConnection, open_session: Open) -> None:
    try:
        async with await open_session() as session:
            await asyncio.gather(_pass_on(program, session), _pass_on(session, program))
    except Exception as error:
        await program.close(FAILED, _reason(error))
        raise


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


def _refusal(response: Response) -> Refusal:
    """Return what an answer says that is not the expected one."""
    status, target = response.status_code, _header(response, "Location")
    if status in REDIRECTIONS and target:
        return Refusal(0, {"detail": f"The server points to {target}. Use that address."})
    try:
        problem = orjson.loads(response.body or b"")
    except orjson.JSONDecodeError:
        problem = None
    return Refusal(status, problem if isinstance(problem, dict) else {"detail": NO_SEAMARK})


def _header(response: Response, name: str) -> str:
    """Return a header, the first of several; empty without one."""
    return next(iter(response.headers.get_all(name)), "")


def _reason(error: Exception) -> str:
    """Return why there is no session, as short as the end of a connection can say it."""
    return str(error).encode()[:REASON_BYTES].decode(errors="ignore")
