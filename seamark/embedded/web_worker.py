"""The worker process of gunicorn that serves HTTP: uvicorn, with clients that dawdle sent away."""

from __future__ import annotations

import asyncio
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, ClassVar

import h11
from gunicorn.arbiter import Arbiter  # type: ignore[import-untyped]
from uvicorn.protocols.http.h11_impl import H11Protocol
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol
from uvicorn.server import Server
from uvicorn_worker import UvicornWorker  # type: ignore[import-untyped]
from websockets.frames import Frame

from seamark.server.web.asgi import ABORT
from seamark.worker.ipc.process_control import die_with_parent

HEAD_S = 20.0  # until the head of a request is complete
CONNECTIONS = 4000  # of one process; beyond, those without a request give way
DISCARDED_MAX = 16 * 2**20  # [byte] of a refused body, so that its client reads the answer
LAST_REQUEST_S = 1.0  # for the request of a connection that was accepted just before the end
MESSAGE_MAX = 64 * 2**10  # [byte] of a WebSocket: no operation of rosbridge is longer
FRAGMENTS_MAX = 1000  # of a message: empty ones have no size
PING_S = 20.0  # between two pings, and until one counts as unanswered
WEB_SOCKETS: dict[str, Any] = {
    "ws_max_size": MESSAGE_MAX,
    "ws_ping_interval": PING_S,
    "ws_ping_timeout": PING_S,
    "ws_per_message_deflate": False,  # a small message could become a large one
}


class Protocol(H11Protocol):
    """HTTP/1.1 with a deadline for the head of a request, which uvicorn has not."""

    head_s = HEAD_S
    _deadline: asyncio.TimerHandle | None = None
    _discarded = 0
    _last = False
    _handed_over = False  # to the protocol of WebSockets

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Await the first request."""
        super().connection_made(transport)
        self._await_head()
        if len(self.connections) > CONNECTIONS:
            waiting = (c for c in self.connections if isinstance(c, Protocol) and c.idle)
            next(waiting, self).transport.abort()

    def handle_websocket_upgrade(self, event: h11.Request) -> None:
        """Hand the connection over, whose request has come."""
        self._stop_waiting()
        self._handed_over = True
        super().handle_websocket_upgrade(event)

    @property
    def idle(self) -> bool:
        """Whether there is no request that is being answered."""
        return self.cycle is None or self.cycle.response_complete

    def data_received(self, data: bytes) -> None:
        """Discard some of a body that nobody waits for any more, then close."""
        if self.cycle is not None and self.idle and self.conn.their_state is h11.SEND_BODY:
            self._discarded += len(data)
            if self._discarded > DISCARDED_MAX:
                self.transport.abort()
                return
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
        if not self.idle:
            self._stop_waiting()
        elif self._deadline is None and self.timeout_keep_alive_task is None:
            self._await_head()

    def connection_lost(self, exc: Exception | None) -> None:
        """Forget the deadline."""
        self._stop_waiting()
        super().connection_lost(exc)

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


class WebSocketProtocol(WebSocketsSansIOProtocol):
    """A WebSocket whose connection the application can close, and whose client is held back.

    uvicorn answers pings and collects the pieces of a message whatever its client does.
    """

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

    async def run_asgi(self) -> None:
        """Let the application close the connection."""
        extensions: dict[str, Any] = self.scope["extensions"]
        extensions[ABORT] = self.transport.abort
        await super().run_asgi()


class WebServer(Server):
    """Ends the streams when it stops, so that their clients connect to another process."""

    async def shutdown(self, sockets: list[Any] | None = None) -> None:
        """End streams, then finish the other requests."""
        application: Any = self.config.app
        application.end_streams()
        await super().shutdown(sockets)

    @contextmanager
    def capture_signals(self) -> Iterator[None]:
        """Stop at signals; not raise them again, since what is registered with atexit must run."""
        loop = asyncio.get_running_loop()
        for number in (signal.SIGTERM, signal.SIGINT):
            loop.add_signal_handler(number, self.handle_exit, number, None)
        yield


class WebWorker(UvicornWorker):  # type: ignore[misc]
    """One web process."""

    CONFIG_KWARGS: ClassVar[dict[str, Any]] = {
        "loop": "asyncio",
        "http": Protocol,
        "ws": WebSocketProtocol,
        **WEB_SOCKETS,
        "lifespan": "off",
        "interface": "asgi3",
        # The application itself decides which proxies it trusts (`SEAMARK_PROXIES`).
        "proxy_headers": False,
        "server_header": False,
    }

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        # A second less than gunicorn allows, which kills.
        self.config.timeout_graceful_shutdown = max(self.cfg.graceful_timeout - 1, 1)

    def init_process(self) -> None:
        """End with the server: uvicorn does not look after it, and would keep the port."""
        die_with_parent(self.ppid, signal.SIGTERM)
        super().init_process()

    async def _serve(self) -> None:
        self.config.app = self.wsgi
        server = WebServer(self.config)
        self._install_sigquit_handler()
        await server.serve(sockets=self.sockets)
        if not server.started:
            sys.exit(Arbiter.WORKER_BOOT_ERROR)
