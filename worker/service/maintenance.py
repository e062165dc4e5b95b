"""The sweep: runs of dead workers go back to the line, and every queued run has a ticket."""

import structlog
from celery import Celery
from redis import Redis
from redis.exceptions import RedisError

from seamark.server.checks import queue
from seamark.server.database.engine import Database
from seamark.server.messaging import broker, live_events
from seamark.server.programs import store
from seamark.server.runs import door as runs
from seamark.server.runs.door import RunState
from seamark.server.settings import Settings

UNUSED_S = 86_400.0  # [s] a program is kept that nothing refers to
_log = structlog.get_logger()


def sweep_once(app: Celery, database: Database, redis: "Redis", settings: Settings) -> None:
    """Sweep, tell those who watch, and top up the tickets; a broker that is away is no failure."""
    with database.writing() as session:
        report = runs.sweep(session, settings)
        queue.recover(session)
    try:
        for run_id in report.returned:
            _tell(redis, run_id, RunState.QUEUED)
        for run_id in report.given_up:
            _tell(redis, run_id, RunState.FAILED)
            live_events.append(redis, run_id, live_events.END, {})
        tickets = broker.top_up(app, redis, report.queued)
    except RedisError as error:
        _log.warning("sweep_without_broker", error=str(error))
        return
    if report.returned or report.given_up or tickets:
        _log.info("swept", returned=report.returned, given_up=report.given_up, tickets=tickets)


def forget_programs(database: Database, settings: Settings) -> None:
    """Delete the programs that only a refused order or an old check has brought."""

    def used(sha256: str) -> bool:
        with database.reading() as session:
            return queue.refers_to(session, sha256)

    gone = store.delete_unused(settings.data, older_than_s=UNUSED_S, used=used)
    if gone:
        _log.info("programs_forgotten", count=gone)


def _tell(redis: "Redis", run_id: int, state: RunState) -> None:
    data = {"state": str(state), "position": None, "progress": 0.0, "t_simulated": 0.0}
    live_events.append(redis, run_id, live_events.STATE, data)
