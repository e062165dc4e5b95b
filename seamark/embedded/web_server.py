"""Gunicorn with our settings and nothing read from files."""

from __future__ import annotations

import gc
import logging
import resource
import socket
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from typing import TYPE_CHECKING, Any

from gunicorn.app.base import BaseApplication  # type: ignore[import-untyped]
from gunicorn.glogging import Logger  # type: ignore[import-untyped]

from seamark.embedded.connections import CONNECTIONS
from seamark.failures import PlatformFailed

if TYPE_CHECKING:
    from seamark.server.settings import Settings

REQUEST_S = 60  # a worker process that is stuck longer is replaced
KEEP_ALIVE_S = 5
STALLED_S = 60  # a client that reads nothing for so long is disconnected
SEND_BUFFER = 128 * 1024  # [byte] in the kernel, which doubles it, for each connection


class _Application(BaseApplication):  # type: ignore[misc]
    """The web application; made in each worker process, after the fork."""

    def __init__(self, settings: Settings, options: dict[str, Any]) -> None:
        self._settings, self._options = settings, options
        super().__init__()

    def load_config(self) -> None:
        """Set the options."""
        for name, value in self._options.items():
            self.cfg.set(name, value)

    def load(self) -> Any:
        """Return the ASGI application."""
        gc.disable()  # of modules hardly anything is garbage
        from seamark.server.app import WebApplication

        gc.enable()
        return WebApplication(self._settings)


class _Log(Logger):  # type: ignore[misc]
    """Gunicorn's and uvicorn's messages as events of the service's log."""

    def setup(self, cfg: Any) -> None:
        """Write where the service writes."""
        super().setup(cfg)
        self.error_log.handlers = list(logging.getLogger().handlers)


def serve(settings: Settings, *, processes: int, grace_s: int) -> None:
    """Serve until SIGTERM.

    Raises
    ------
    PlatformFailed
        The database has not been brought to this version, or the data folder is not its own.
    """
    from seamark.server.database import schema
    from seamark.server.database.data_folder import WrongDataFolder
    from seamark.server.monitoring import log

    log.configure(settings.log_level)
    try:
        # In a child: the library of the object storage has threads, which no fork may inherit.
        with ProcessPoolExecutor(1, get_context("fork")) as child:
            child.submit(schema.check_all, settings).result()
    except (schema.SchemaTooOld, WrongDataFolder) as error:
        raise PlatformFailed(f"{error}.") from None
    options = {
        "bind": f"{settings.host}:{settings.port}",
        "workers": processes,
        "worker_class": "seamark.embedded.web_worker.WebWorker",
        "when_ready": _prepare_listeners,
        "graceful_timeout": grace_s,
        "timeout": REQUEST_S,
        "keepalive": KEEP_ALIVE_S,
        "errorlog": "-",
        "loglevel": "warning",
        "logger_class": _Log,
        "control_socket_disable": True,
    }
    _allow_connections()
    _Application(settings, options).run()


def _prepare_listeners(arbiter: Any) -> None:
    """Set options that accepted connections inherit."""
    for listener in arbiter.LISTENERS:
        if listener.sock.family != socket.AF_UNIX:
            # The kernel closes a connection whose client has stopped reading.
            listener.sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, STALLED_S * 1000)
            # Otherwise the kernel would hold megabytes for each client that reads slowly.
            listener.sock.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, SEND_BUFFER)


def _allow_connections() -> None:
    """Raise the limit of open files, so that slow clients do not use up all of them."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = 2 * CONNECTIONS if hard == resource.RLIM_INFINITY else min(2 * CONNECTIONS, hard)
    resource.setrlimit(resource.RLIMIT_NOFILE, (max(soft, wanted), hard))
