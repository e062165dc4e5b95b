"""The maintenance process of each worker: recovers runs of dead workers, forgets old programs.

    python -s -P -m seamark.worker.service.maintenance <parent>

A process of its own and not a Celery task: tasks wait while all children are busy with long runs.
"""

import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import structlog
from celery import Celery
from redis import Redis
from redis.exceptions import RedisError

from seamark.server import log
from seamark.server.checks import queue
from seamark.server.database.engine import Database
from seamark.server.messaging import broker, live_events
from seamark.server.programs import store
from seamark.server.runs import queue as run_queue
from seamark.server.runs.states import RunState
from seamark.server.settings import Settings
from seamark.worker.service.shutdown import follow_worker

POLL_S = 0.2  # [s] between two checks of what is due
FORGET_EVERY_S = 3600.0
_log = structlog.get_logger()


@dataclass(slots=True)
class PeriodicTask:
    """An action that is repeated; it runs for the first time one period after the start."""

    name: str
    period_s: float
    action: Callable[[], None]
    due_at: float = 0.0  # monotonic

    def __post_init__(self) -> None:
        """Schedule the first time."""
        self.due_at = time.monotonic() + self.period_s


def run_due(tasks: Sequence[PeriodicTask]) -> None:
    """Run what is due; a failure is logged, and stops neither the other tasks nor the next time."""
    for task in tasks:
        if time.monotonic() < task.due_at:
            continue
        task.due_at = time.monotonic() + task.period_s
        try:
            task.action()
        except Exception:
            _log.exception("maintenance_failed", task=task.name)


def recover_runs(app: Celery, database: Database, redis: "Redis", settings: Settings) -> None:
    """Return the runs of dead workers to the queue, publish that, and add missing tickets."""
    with database.writing() as session:
        report = run_queue.recover(session, settings)
    try:
        for run_id in report.requeued:
            live_events.publish_state(redis, run_id, RunState.QUEUED)
        for run_id in report.failed:
            live_events.publish_end(redis, run_id, RunState.FAILED)
        tickets = broker.top_up(app, redis, report.queued)
    except RedisError as error:  # the queue is in the database: a broker that is away is no failure
        _log.warning("recovery_without_broker", error=str(error))
        return
    if report.requeued or report.failed or tickets:
        _log.info("runs_recovered", requeued=report.requeued, failed=report.failed, tickets=tickets)


def recover_checks(database: Database) -> None:
    """Return the checks of dead workers to the queue, and forget old ones."""
    with database.writing() as session:
        queue.recover(session)


def forget_programs(database: Database, settings: Settings) -> None:
    """Delete old programs that neither a run nor a check refers to."""

    def used(sha256: str) -> bool:
        with database.reading() as session:
            return queue.refers_to(session, sha256)

    count = store.delete_unused(settings.data, used=used)
    if count:
        _log.info("programs_forgotten", count=count)


def main(parent: str) -> None:
    """Be the maintenance process of one worker."""
    stopping = follow_worker(int(parent))
    log.configure()
    settings = Settings.load()
    app, redis = broker.celery_app(settings), broker.connect(settings)
    database, recovery_s = Database(settings.database_url), settings.sweep_s
    tasks = [
        PeriodicTask(
            "recover_runs", recovery_s, lambda: recover_runs(app, database, redis, settings)
        ),
        PeriodicTask("recover_checks", recovery_s, lambda: recover_checks(database)),
        PeriodicTask(
            "forget_programs", FORGET_EVERY_S, lambda: forget_programs(database, settings)
        ),
    ]
    while not stopping.wait(POLL_S):
        run_due(tasks)


if __name__ == "__main__":
    main(*sys.argv[1:])
