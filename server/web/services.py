"""The services of a web process: settings, database, broker, live streams."""

from contextlib import suppress
from dataclasses import dataclass

from celery import Celery
from flask import current_app
from redis import Redis
from redis.exceptions import RedisError

from seamark.server.database.engine import Database
from seamark.server.messaging import broker
from seamark.server.messaging.shared_meters import SharedMeters
from seamark.server.monitoring.outages import Outage
from seamark.server.programs.reader import ProgramReader
from seamark.server.runs.downloads.conversions import Conversions
from seamark.server.runs.logs.log_reader import LogReader
from seamark.server.settings import Settings
from seamark.server.web.readiness import Readiness
from seamark.server.web.streams.hub import Hub


@dataclass(frozen=True, slots=True)
class Services:
    """Everything that is created once per process."""

    settings: Settings
    database: Database
    redis: Redis
    streams: Hub
    celery: Celery
    reader: ProgramReader
    conversions: Conversions
    logs: LogReader
    meters: SharedMeters
    outage: Outage  # of the database, as requests see it
    readiness: Readiness

    @classmethod
    def start(cls, settings: Settings) -> "Services":
        """Create all services; none connects before its first use."""
        database, redis = Database(settings.database_url), broker.connect(settings)
        outage = Outage("database")
        return cls(
            settings=settings,
            database=database,
            redis=redis,
            streams=Hub(database, settings),
            celery=broker.celery_app(settings),
            reader=ProgramReader(),
            conversions=Conversions(),
            logs=LogReader(),
            meters=SharedMeters(redis),
            outage=outage,
            readiness=Readiness(settings, database, redis, outage),
        )

    def wake_worker(self) -> None:
        """Tell a worker that there is work; only after the commit, or it finds nothing."""
        broker.send_tickets(self.celery)

    def share_meters(self) -> None:
        """Add what this process has counted to what all have, and report that it is there."""
        with suppress(RedisError):
            if self.meters.add():
                self.meters.report(self.streams.open_streams)

    def close(self) -> None:
        """Stop threads and close connections."""
        self.reader.close()
        self.streams.close()
        with suppress(RedisError):
            if self.meters.add():  # else it would wait a second time for a broker that hangs
                self.meters.leave()
        self.redis.close()
        self.celery.close()
        self.database.close()


def services() -> Services:
    """Return the services of the current application."""
    current: Services = current_app.extensions["seamark"]
    return current
