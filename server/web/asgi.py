"""The WSGI application behind an asynchronous server: slow clients hold connections, not threads.

A thread is taken when the whole request has arrived, and for each part of the response when the
client has received the one before. A response may continue with what comes from the event loop,
as live events do: the application puts a `Continuation` into the WSGI environment.
"""

from __future__ import annotations

import asyncio
import io
import json
import sys
import time
from collections.abc import AsyncGenerator, Awaitable, Callable, Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import AsyncExitStack, aclosing
from dataclasses import dataclass
from typing import Any, TypeVar

from seamark.server.web import websockets
from seamark.server.web.received_body import (
    PATIENCE_S,
    BodyTooSlow,
    ClientGone,
    ReceivedBody,
    receive_body,
)

APART = {"/healthz", "/readyz"}  # answered by threads of their own, whatever the others wait for
THREADS_APART = 4
THREADS = 64  # requests that are worked on at the same time; most of them wait for the database
LARGE_BODIES = 64  # that may be on the disk at the same time; others wait to be received
PART_BYTES = 64 * 1024  # of a response, made at once
CONTINUATION = "seamark.continuation"  # key of the WSGI environment
ABORT = "seamark.abort"  # extension of the ASGI scope: closes the connection without more ado
_BODY = "http.response.body"
_LAST = (_BODY, "websocket.http.response.body", "websocket.close")
_HTTP = {"ws": "http", "wss": "https"}
_TOO_SLOW = {
    "type": "about:blank",
    "title": "Request timeout",
    "status": 408,
    "detail": "The request did not arrive in time.",
}

Scope = Mapping[str, Any]
Environ = dict[str, Any]
Receive = Callable[[], Awaitable[dict[str, Any]]]
Send = Callable[[dict[str, Any]], Awaitable[None]]
StartResponse = Callable[..., Any]
WsgiApplication = Callable[[Environ, StartResponse], Iterable[bytes]]
Result = TypeVar("Result")


@dataclass(frozen=True, slots=True)
class Connection:
    """The client of a response that goes on."""

    gone: asyncio.Future[Any]  # done when the client has closed the connection
    abort: Callable[[], None]


class Sent:
    """Sends the messages of an answer, and knows what was sent."""

    def __init__(self, send: Send) -> None:
        self._send = send
        self._began_at = time.perf_counter()
        self.status = 500  # of an application that failed before it answered
        self.bytes = 0  # of the body
        self.complete = False

    @property
    def seconds(self) -> float:
        """Time since the request had arrived."""
        return time.perf_counter() - self._began_at

    async def __call__(self, message: dict[str, Any]) -> None:
        """Send a message."""
        await self._send(message)
        accepted = 101 if message["type"] == "websocket.accept" else self.status
        self.status = message.get("status", accepted)
        self.bytes += len(message.get("body", b""))
        self.complete = message["type"] in _LAST and not message.get("more_body", False)


Continuation = Callable[[Connection], AsyncGenerator[bytes, None]]


class AsgiApplication:
    """Runs a WSGI application in threads.

    Attributes
    ----------
    patience_s
        How long a small body may take, and the first byte of a large one.

    Parameters
    ----------
    wsgi
        The application.
    body_max
        Returns the largest body [byte] of this content type that the application may accept; a
        larger one is not received, but the application is told how large it is.
    on_answer
        Is called when an answer has ended, whether its client received all of it or not.
    """

    patience_s = PATIENCE_S

    def __init__(
        self,
        wsgi: WsgiApplication,
        body_max: Callable[[str], int],
        on_answer: Callable[[Environ, Sent], None],
    ) -> None:
        self._wsgi = wsgi
        self._on_answer = on_answer
        self._body_max = body_max
        self._threads = ThreadPoolExecutor(THREADS, thread_name_prefix="request")
        self._apart = ThreadPoolExecutor(THREADS_APART, thread_name_prefix="health")
        self._large_bodies = asyncio.Semaphore(LARGE_BODIES)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request."""
        if scope["type"] == "websocket":
            await self._upgrade(scope, receive, send)
            return
        environ = _environ(scope)
        async with AsyncExitStack() as held:
            try:
                body = await self._body(environ, receive, held)
            except ClientGone:
                return
            except BodyTooSlow:
                sent = Sent(send)
                await _refuse_as_too_slow(sent)
                self._on_answer(environ, sent)
                return
            environ["wsgi.input"] = held.enter_context(body.file)
            environ["CONTENT_LENGTH"] = str(body.length)
            sent = Sent(send)
            try:
                await self._answer(_Call(self._wsgi, environ), scope, receive, sent)
            finally:
                self._on_answer(environ, sent)

    async def _upgrade(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request for a WebSocket, which has no body."""
        environ = _environ({**scope, "method": "GET", "scheme": _HTTP[scope["scheme"]]})
        environ |= {websockets.UPGRADE: True, "wsgi.input": io.BytesIO(), "CONTENT_LENGTH": "0"}
        del environ["HTTP_UPGRADE"]  # Werkzeug has other routes for these
        sent, call = Sent(send), _Call(self._wsgi, environ)
        try:
            body = await _in_thread(self._threads, call.begin)  # of a refusal it has all
            conversation = environ.get(websockets.CONVERSATION)
            if conversation is None:
                await websockets.refuse(call.head, body, sent)
            else:
                abort = scope.get("extensions", {}).get(ABORT, lambda: None)
                socket = websockets.WebSocket(receive, sent, abort)
                await websockets.converse(conversation, socket, sent)
        finally:
            await _in_thread(self._threads, call.close)
            self._on_answer(environ, sent)

    async def _body(self, environ: Environ, receive: Receive, held: AsyncExitStack) -> ReceivedBody:
        def slot() -> Awaitable[object]:
            return held.enter_async_context(self._large_bodies)

        length = environ.pop("CONTENT_LENGTH", "")
        declared = int(length) if length.isdecimal() else None
        limit = self._body_max(environ.get("CONTENT_TYPE", ""))
        return await receive_body(
            receive, slot, declared=declared, limit=limit, patience_s=self.patience_s
        )

    async def _answer(self, call: _Call, scope: Scope, receive: Receive, send: Send) -> None:
        threads = self._apart if scope["path"] in APART else self._threads
        gone = asyncio.ensure_future(_until_gone(receive))
        abort = scope.get("extensions", {}).get(ABORT, lambda: None)
        try:
            part: bytes | None = await _in_thread(threads, call.begin)
            await send(call.head)
            while part is not None and not gone.done():
                await send(_body(part))
                part = None if call.exhausted else await _in_thread(threads, call.next_part)
            if call.continuation is not None and not gone.done():
                await _continue(call.continuation(Connection(gone, abort)), send)
            await send(_body(b"", more=False))
        finally:
            gone.cancel()
            await _in_thread(threads, call.close)


class _Call:
    """One call of the WSGI application; its methods run in any thread, but one at a time."""

    def __init__(self, wsgi: WsgiApplication, environ: Environ) -> None:
        self.exhausted = False
        self._wsgi, self._environ = wsgi, environ
        self._pieces: Iterable[bytes] = ()
        self.head: dict[str, Any] = {}  # the message that starts the response

    @property
    def continuation(self) -> Continuation | None:
        """What follows the response's own parts."""
        continuation: Continuation | None = self._environ.get(CONTINUATION)
        return continuation

    def begin(self) -> bytes:
        """Call the application; return the first part of its response."""
        self._pieces = self._wsgi(self._environ, self._start_response)
        self._iterator = iter(self._pieces)
        return self.next_part()

    def next_part(self) -> bytes:
        """Return the next bytes of the response, at least `PART_BYTES` unless it is exhausted."""
        part = bytearray()
        while len(part) < PART_BYTES:
            piece = next(self._iterator, None)
            if piece is None:
                self.exhausted = True
                break
            part += piece
        return bytes(part)

    def close(self) -> None:
        """Release what the response holds."""
        close = getattr(self._pieces, "close", None)
        if close is not None:
            close()

    def _start_response(
        self, status: str, headers: list[tuple[str, str]], exc_info: object = None
    ) -> Callable[[bytes], None]:
        encoded = [(name.lower().encode("latin-1"), v.encode("latin-1")) for name, v in headers]
        code = int(status.split(" ", 1)[0])
        self.head = {"type": "http.response.start", "status": code, "headers": encoded}
        return _no_write


async def _in_thread(threads: ThreadPoolExecutor, function: Callable[[], Result]) -> Result:
    return await asyncio.get_running_loop().run_in_executor(threads, function)


def _no_write(_: bytes) -> None:
    raise NotImplementedError("applications of today return their response")


async def _until_gone(receive: Receive) -> None:
    """Return when the client has gone; what it sends of a body that is too large is discarded."""
    while (await receive())["type"] != "http.disconnect":
        pass


async def _continue(parts: AsyncGenerator[bytes, None], send: Send) -> None:
    async with aclosing(parts):
        async for part in parts:
            await send(_body(part))


def _body(part: bytes, *, more: bool = True) -> dict[str, Any]:
    return {"type": _BODY, "body": part, "more_body": more}


async def _refuse_as_too_slow(send: Send) -> None:
    headers = [(b"content-type", b"application/problem+json"), (b"connection", b"close")]
    await send({"type": "http.response.start", "status": 408, "headers": headers})
    await send(_body(json.dumps(_TOO_SLOW).encode(), more=False))


def _environ(scope: Scope) -> Environ:
    """Return the WSGI environment without the body (PEP 3333)."""
    server, client = scope.get("server") or ("localhost", 80), scope.get("client")
    environ: Environ = {
        "REQUEST_METHOD": scope["method"],
        "SCRIPT_NAME": "",
        "PATH_INFO": scope["path"].encode().decode("latin-1"),
        "QUERY_STRING": scope["query_string"].decode("latin-1"),
        "SERVER_PROTOCOL": f"HTTP/{scope['http_version']}",
        "SERVER_NAME": server[0],
        "SERVER_PORT": str(server[1] or 0),
        "REMOTE_ADDR": client[0] if client else "",
        "wsgi.version": (1, 0),
        "wsgi.url_scheme": scope["scheme"],
        "wsgi.errors": sys.stderr,
        "wsgi.multithread": True,
        "wsgi.multiprocess": True,
        "wsgi.run_once": False,
    }
    for name, value in scope["headers"]:
        _add_header(environ, name.decode("latin-1"), value.decode("latin-1"))
    return environ


def _add_header(environ: Environ, name: str, value: str) -> None:
    # X_Forwarded_For would become the same variable as X-Forwarded-For, which proxies vouch for.
    if "_" in name:
        return
    key = name.upper().replace("-", "_")
    if key not in ("CONTENT_TYPE", "CONTENT_LENGTH"):
        key = f"HTTP_{key}"
    if key == "HTTP_TRANSFER_ENCODING":
        return  # the body arrives decoded
    joint = "; " if key == "HTTP_COOKIE" else ","
    environ[key] = f"{environ[key]}{joint}{value}" if key in environ else value
