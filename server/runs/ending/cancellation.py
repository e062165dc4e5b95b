"""Cancelling a run, for the page and the API."""

import structlog
from redis import Redis
from redis.exceptions import RedisError

from seamark.server.accounts import audit
from seamark.server.accounts.audit import Actor, AuditAction
from seamark.server.database.engine import Database
from seamark.server.messaging import live_events
from seamark.server.runs.ending import results
from seamark.server.runs.record.states import RunState
from seamark.server.runs.submission import sweeps

_log = structlog.get_logger()


def cancel(
    database: Database, redis: Redis, run_id: int, *, not_owner: Actor | None = None
) -> bool:
    """Cancel a run; False if it has already ended.

    Viewers of a queued run are notified here, those of a running one by its worker.

    Parameters
    ----------
    not_owner
        The actor, for the audit log, if the run belongs to somebody else.
    """
    with database.writing() as session:
        previous = results.cancel(session, run_id)
        if previous is not None and not_owner is not None:
            audit.record(session, not_owner, AuditAction.RUN_CANCELLED, f"run {run_id}")
    if previous is RunState.QUEUED:
        try:
            live_events.publish_state(redis, run_id, RunState.CANCELLED)
        except RedisError as error:  # open streams also poll the database, only less often
            _log.warning("state_not_published", run=run_id, error=str(error))
    return previous is not None


def cancel_sweep(database: Database, redis: Redis, sweep_id: int) -> int:
    """Cancel the runs of a sweep that have not ended; return how many."""
    with database.reading() as session:
        ids = sweeps.live_runs(session, sweep_id)
    return sum(cancel(database, redis, run_id) for run_id in ids)
