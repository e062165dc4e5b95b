"""HTTP and WebSockets as uvicorn speaks them, with clients that dawdle sent away.

From its first byte to its last, a connection is in one of these states, and each has an end:

- it waits for a request, or for the rest of its head: `Protocol.head_s`;
- the body arrives: `server.web.received_body`;
- it is answered: the application decides, and the kernel ends a connection that takes nothing;
- it is idle between two requests: uvicorn's keep-alive;
- its request could not be read, or its body was refused: it is told, may read that, and goes;
- it wants to be a WebSocket: `WebSocketProtocol.accept_s` until it is one, or is refused;
- it is a WebSocket: pings, and the conversation's own limits.
"""

from __future__ import annotations

import asyncio
import json
import sys
from http import HTTPStatus
from typing import Any

import h11
from uvicorn.config import Config
from uvicorn.protocols.http.h11_impl import STATUS_PHRASES, H11Protocol
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol
from websockets.frames import Frame
from websockets.server import ServerProtocol

from seamark.embedded.connections import State
from seamark.server.web.asgi import ABORT

HEAD_S = 20.0  # until the head of a request is complete
ACCEPT_S = 20.0  # until a WebSocket is accepted or refused, and its client has the refusal
DISCARDED_MAX = 16 * 2**20  # [byte] of a refused body, so that its client reads the answer
LAST_REQUEST_S = 1.0  # for the request of a connection that was accepted just before the end
MESSAGE_MAX = 64 * 2**10  # [byte] of a WebSocket: no operation of rosbridge is longer
FRAGMENTS_MAX = 1000  # of a message: empty ones have no size
PINGS_MAX = 10_000  # of a client's own: more than ten a second in the longest session
PING_S = 20.0  # between two pings, and until one counts as unanswered
WEB_SOCKETS: dict[str, Any] = {
    "ws_max_size": MESSAGE_MAX,
    "ws_ping_interval": PING_S,
    "ws_ping_timeout": PING_S,
    "ws_per_message_deflate": False,  # a small message could become a large one
}


class _SmallReads(asyncio.BufferedProtocol):
    """Reads little at a time, so that no client has the event loop for long.

    asyncio reads 256 KiB at once: 40,000 chunks or frames of a byte, which took half a second.
    """

    def __init__(
        self,
        config: Config,
        server_state: State,
        app_state: dict[str, Any],
        _loop: asyncio.AbstractEventLoop | None = None,
    ) -> None:
        super().__init__(config, server_state, app_state, _loop)  # type: ignore[call-arg]
        self._state = server_state

    def get_buffer(self, _sizehint: int) -> bytearray:
        """Return where to put what arrives."""
        return self._state.read_buffer

    def buffer_updated(self, nbytes: int) -> None:
        """Take what has arrived."""
        self.data_received(bytes(self._state.read_buffer[:nbytes]))  # type: ignore[attr-defined]


class Protocol(_SmallReads, H11Protocol):  # type: ignore[misc]
    """HTTP/1.1 with a deadline for the head of a request, which uvicorn has not."""

    head_s = HEAD_S
    _deadline: asyncio.TimerHandle | None = None
    _discarded = 0
    _last = False
    _refused = False  # what the client sends cannot be read; it may read why
    _handed_over = False  # to the protocol of WebSockets

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Await the first request."""
        super().connection_made(transport)
        self._await_head()
        self._state.crowd.wait(transport, self._state.address_of(self.client))

    def connection_lost(self, exc: Exception | None) -> None:
        """Forget the connection."""
        self._stop_waiting()
        self._state.crowd.leave(self.transport)
        super().connection_lost(exc)

    @property
    def idle(self) -> bool:
        """Whether there is no request that is being answered."""
        return self._refused or self.cycle is None or self.cycle.response_complete

    def data_received(self, data: bytes) -> None:
        """Discard some of what nobody waits for any more, then close."""
        ignored = self._refused or (
            self.cycle is not None and self.idle and self.conn.their_state is h11.SEND_BODY
        )
        self._discarded += len(data) if ignored else 0
        if self._discarded > DISCARDED_MAX:
            self.transport.abort()
        elif not self._refused:
            super().data_received(data)

    def handle_events(self) -> None:
        """Let the application close the connection; await the head of the next request."""
        before = self.cycle
        super().handle_events()
        if self._handed_over:
            return
        if self.cycle is not before:
            self._discarded = 0
            scope: dict[str, Any] = self.scope  # type: ignore[assignment]
            scope["extensions"] = {ABORT: self.transport.abort}
            self.cycle.keep_alive = self.cycle.keep_alive and not self._last
            address = self._state.address_of(self.client, self.headers)
            self._state.crowd.answer(self.transport, address)
        if not self.idle:
            self._stop_waiting()
        elif self._deadline is None and self.timeout_keep_alive_task is None:
            self._await_head()

    def on_response_complete(self) -> None:
        """Await the next request."""
        self._state.crowd.wait(self.transport, self._state.address_of(self.client))
        super().on_response_complete()

    def send_400_response(self, msg: str) -> None:
        """Refuse a request that cannot be read."""
        if not self.idle:
            if self.cycle.response_started:
                self.transport.abort()
                return
            self.cycle.disconnected = True  # nobody answers a request whose body is broken
            self.cycle.message_event.set()
            self._state.crowd.wait(self.transport, self._state.address_of(self.client))
        error = sys.exc_info()[1]
        self._refuse(
            error.error_status_hint if isinstance(error, h11.RemoteProtocolError) else 400, msg
        )

    def handle_websocket_upgrade(self, event: h11.Request) -> None:
        """Hand the connection over, if the protocol of WebSockets can read its request."""
        status = 400 if self.conn.trailing_data[0] else _refusal(event, self.headers)
        if status is not None:
            self._refuse(status, "This is no handshake of a WebSocket.")
            return
        self._stop_waiting()
        self._handed_over = True
        super().handle_websocket_upgrade(event)

    def _unsupported_upgrade_warning(self) -> None:
        """Say nothing: clients offer HTTP/2, and may (RFC 9110, 7.8)."""

    def _refuse(self, status: int, detail: str) -> None:
        """Tell what is wrong, let the client read it, and read nothing more from it."""
        self._refused = True
        title = HTTPStatus(status).phrase.capitalize()
        document = {"type": "about:blank", "title": title, "status": status, "detail": detail}
        headers = [(b"content-type", b"application/problem+json"), (b"connection", b"close")]
        headers += [(b"allow", b"GET")] if status == HTTPStatus.METHOD_NOT_ALLOWED else []
        answer = h11.Response(status_code=status, headers=headers, reason=STATUS_PHRASES[status])
        parts = (answer, h11.Data(data=json.dumps(document).encode()), h11.EndOfMessage())
        self.transport.write(b"".join(self.conn.send(part) or b"" for part in parts))
        self.transport.write_eof()

    def shutdown(self) -> None:
        """Finish the request under way; wait a moment for that of a new connection."""
        if self.cycle is None:
            self._last = True
            self.loop.call_later(LAST_REQUEST_S, self._close_if_idle)
        else:
            super().shutdown()

    def _close_if_idle(self) -> None:
        if self.idle and not self.transport.is_closing():
            self.transport.close()

    def _await_head(self) -> None:
        self._deadline = self.loop.call_later(self.head_s, self.transport.abort)

    def _stop_waiting(self) -> None:
        if self._deadline is not None:
            self._deadline.cancel()
            self._deadline = None


def _refusal(event: h11.Request, headers: list[tuple[bytes, bytes]]) -> int | None:
    """Return with which status a handshake is refused that the library of WebSockets cannot read.

    It has other limits than HTTP, and uvicorn looks only at the requests that it could read.
    """
    if event.method != b"GET":
        return HTTPStatus.METHOD_NOT_ALLOWED
    parser = ServerProtocol()
    lines = (b"GET " + event.target + b" HTTP/1.1", *(name + b": " + v for name, v in headers))
    parser.receive_data(b"\r\n".join((*lines, b"", b"")))
    if parser.events_received():
        return None
    answer = b"".join(parser.data_to_send())  # empty, or with a status after HTTP/1.1
    return int(answer.split()[1]) if answer else HTTPStatus.BAD_REQUEST


class WebSocketProtocol(_SmallReads, WebSocketsSansIOProtocol):  # type: ignore[misc]
    """A WebSocket whose connection the application can close, and whose client is held back.

    uvicorn waits for the application without end, and answers pings and collects the pieces of a
    message whatever its client does.
    """

    accept_s = ACCEPT_S
    pings_max = PINGS_MAX
    _pings = 0

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Take over a connection whose request has come."""
        super().connection_made(transport)
        self._deadline = self.loop.call_later(self.accept_s, self.transport.abort)

    def connection_lost(self, exc: Exception | None) -> None:
        """Forget the connection."""
        self._deadline.cancel()
        self._state.crowd.leave(self.transport)
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        """Send away who speaks before the answer to its handshake (RFC 6455, 4.1)."""
        if self.handshake_initiated and not self.handshake_complete:
            self.transport.abort()
        else:
            super().data_received(data)

    def shutdown(self) -> None:
        """Close the connection; a handshake that is not decided yet may be by another process."""
        if self.handshake_complete or self.initial_response is not None:
            super().shutdown()
            return
        refusal = self.conn.reject(HTTPStatus.SERVICE_UNAVAILABLE, "Try again.\n")
        refusal.headers["Retry-After"] = "1"
        self.conn.send_response(refusal)
        self.transport.write(b"".join(self.conn.data_to_send()))
        self.transport.close()

    def handle_ping(self) -> None:
        """Answer a ping, unless it is one of too many."""
        self._pings += 1
        if self._pings > self.pings_max:
            self.transport.abort()
        else:
            super().handle_ping()

    def handle_cont(self, event: Frame) -> None:
        """Add a piece to a message."""
        if len(self.frames) >= FRAGMENTS_MAX:
            self.transport.abort()
        else:
            super().handle_cont(event)

    def pause_writing(self) -> None:
        """Read no more from a client that reads nothing itself."""
        super().pause_writing()
        self.transport.pause_reading()

    def resume_writing(self) -> None:
        """Read again, unless the application has a message to read first."""
        super().resume_writing()
        if not self.read_paused:
            self.transport.resume_reading()

    async def receive(self) -> Any:
        """Return the next event."""
        event = await super().receive()
        if not self.writable.is_set():
            self.transport.pause_reading()
        return event

    async def send(self, message: Any) -> None:
        """Send a message; an accepted client may stay."""
        await super().send(message)
        if message["type"] == "websocket.accept" and not self.disconnected:
            self._deadline.cancel()
            address = self._state.address_of(self.client, self.scope["headers"])
            self._state.crowd.answer(self.transport, address)

    async def run_asgi(self) -> None:
        """Let the application close the connection; see its client off."""
        extensions: dict[str, Any] = self.scope["extensions"]
        extensions[ABORT] = self.transport.abort
        await super().run_asgi()
        if not self.disconnected:
            self._state.crowd.wait(self.transport, self._state.address_of(self.client))
            self._deadline.cancel()
            self._deadline = self.loop.call_later(self.accept_s, self.transport.abort)
