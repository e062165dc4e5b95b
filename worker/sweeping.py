"""The sweep: runs of dead workers go back to the line, and every queued run has a ticket."""

import structlog
from celery import Celery
from redis import Redis
from redis.exceptions import RedisError

from server import broker, checks, live, programs, runs
from server.db import Database
from server.runs import RunState
from server.settings import Settings

UNUSED_S = 86_400.0  # [s] a program is kept that nothing refers to
_log = structlog.get_logger()


def sweep_once(app: Celery, database: Database, redis: "Redis", settings: Settings) -> None:
    """Sweep, tell those who watch, and top up the tickets; a broker that is away is no failure."""
    with database.writing() as session:
        report = runs.sweep(session, settings)
        checks.sweep(session)
    try:
        for run_id in report.returned:
            _tell(redis, run_id, RunState.QUEUED)
        for run_id in report.given_up:
            _tell(redis, run_id, RunState.FAILED)
            live.append(redis, run_id, live.END, {})
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
            return checks.refers_to(session, sha256)

    gone = programs.forget_unused(settings.data, older_than_s=UNUSED_S, used=used)
    if gone:
        _log.info("programs_forgotten", count=gone)


def _tell(redis: "Redis", run_id: int, state: RunState) -> None:
    data = {"state": str(state), "position": None, "progress": 0.0, "t_simulated": 0.0}
    live.append(redis, run_id, live.STATE, data)
