"""The services of a web process: settings, database, broker, live streams."""

from dataclasses import dataclass

from celery import Celery
from flask import current_app
from redis import Redis

from seamark.server.database.engine import Database
from seamark.server.messaging import broker
from seamark.server.programs.reader import ProgramReader
from seamark.server.settings import Settings
from seamark.server.streams.hub import Hub


@dataclass(frozen=True, slots=True)
class Services:
    """Everything that is created once per process."""

    settings: Settings
    database: Database
    redis: Redis
    streams: Hub
    celery: Celery
    reader: ProgramReader

    @classmethod
    def start(cls, settings: Settings) -> "Services":
        """Create all services; none connects before its first use."""
        database = Database(settings.database_url)
        return cls(
            settings=settings,
            database=database,
            redis=broker.connect(settings),
            streams=Hub(database, settings),
            celery=broker.celery_app(settings),
            reader=ProgramReader(),
        )

    def wake_worker(self) -> None:
        """Tell a worker that there is work; only after the commit, or it finds nothing."""
        broker.send_tickets(self.celery)

    def close(self) -> None:
        """Stop threads and close connections."""
        self.reader.close()
        self.streams.close()
        self.redis.close()
        self.celery.close()
        self.database.close()


def services() -> Services:
    """Return the services of the current application."""
    current: Services = current_app.extensions["seamark"]
    return current
