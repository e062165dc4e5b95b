"""Gunicorn with our settings and nothing read from files."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from gunicorn.app.base import BaseApplication  # type: ignore[import-untyped]

from seamark.failures import PlatformFailed

if TYPE_CHECKING:
    from seamark.server.settings import Settings

REQUEST_S = 60  # a worker process that is stuck longer is replaced
KEEP_ALIVE_S = 5
CONNECTIONS = 1000


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
        """Return the WSGI application."""
        from seamark.server.app import create_app

        return create_app(self._settings)


def serve(settings: Settings, *, processes: int, threads: int, grace_s: int) -> None:
    """Serve until SIGTERM.

    Raises
    ------
    PlatformFailed
        The database has not been brought to this version.
    """
    from seamark.server import log
    from seamark.server.database import schema
    from seamark.server.database.engine import Database

    log.configure()
    database = Database(settings.database_url)
    try:
        schema.check(database.engine)
    except schema.SchemaTooOld as error:
        raise PlatformFailed(f"{error}.") from None
    finally:
        database.close()
    options = {
        "bind": f"{settings.host}:{settings.port}",
        "workers": processes,
        "worker_class": "gthread",
        "threads": threads,
        "worker_connections": CONNECTIONS,
        "graceful_timeout": grace_s,
        "timeout": REQUEST_S,
        "keepalive": KEEP_ALIVE_S,
        "errorlog": "-",
        "loglevel": "warning",
        "control_socket_disable": True,
    }
    _Application(settings, options).run()
