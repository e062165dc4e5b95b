"""The worker process of gunicorn that serves HTTP, with uvicorn."""

from __future__ import annotations

import asyncio
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, ClassVar

from gunicorn.arbiter import Arbiter  # type: ignore[import-untyped]
from uvicorn.config import Config
from uvicorn.server import Server
from uvicorn_worker import UvicornWorker  # type: ignore[import-untyped]

from seamark.embedded.connections import Connections, State, most_connections
from seamark.embedded.protocols import WEB_SOCKETS, Protocol, WebSocketProtocol
from seamark.worker.ipc.process_control import die_with_parent

BACKLOG = 2048  # connections that the kernel completes before they are accepted
ACCEPTED_AT_ONCE = 8  # a request takes several turns of the loop, and waits for these in each


class WebServer(Server):
    """Bounds its connections; ends the streams at its end: their clients find another process."""

    def __init__(self, config: Config) -> None:
        super().__init__(config)
        application: Any = config.app
        crowd = Connections(most_connections())
        self.server_state = State(crowd, proxies=application.proxies)

    async def startup(self, sockets: list[Any] | None = None) -> None:
        """Accept connections, a few at a time, and let more of them wait for that.

        asyncio accepts as many at once as may wait, and, when no file can be opened, fails and
        logs as often.
        """
        await super().startup(sockets)
        for listener in sockets or []:
            listener.listen(BACKLOG)

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
        "backlog": ACCEPTED_AT_ONCE,
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
