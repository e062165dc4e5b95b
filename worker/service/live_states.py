"""Publishes the states of runs live; what a run records, the web processes read from its files.

The queue is in the database: an unreachable broker must not stop a run, so its errors are logged
once and ignored.
"""

import structlog
from celery import Celery
from redis import Redis
from redis.exceptions import RedisError

from seamark.server.messaging import broker, live_events
from seamark.server.monitoring.outages import Outage
from seamark.server.runs.queue.lost_attempts import Recovery
from seamark.server.runs.record.states import RunState

_log = structlog.get_logger()
_outage = Outage("broker", of="recovery")


class LivePublisher:
    """Publishes the states of one run."""

    def __init__(self, redis: "Redis", run_id: int) -> None:
        self._redis = redis
        self._run_id = run_id
        self._failing = False

    def state(self, state: str, *, progress: float, t_simulated: float) -> None:
        """Publish the state and the progress of the run."""
        try:
            live_events.publish_state(
                self._redis, self._run_id, state, progress=progress, t_simulated=t_simulated
            )
            self._failing = False
        except RedisError as error:
            if not self._failing:
                _log.warning("state_not_published", run=self._run_id, error=str(error))
            self._failing = True


def announce(app: Celery, redis: "Redis", recovery: Recovery) -> None:
    """Publish what became of runs that had lost their workers, and send the tickets that they lack.

    After the commit.
    """
    try:
        for run_id in recovery.requeued:
            live_events.publish_state(redis, run_id, RunState.QUEUED)
        for run_id in recovery.failed:
            live_events.publish_state(redis, run_id, RunState.FAILED)
        tickets = broker.top_up(app, redis, recovery.tickets)
    except RedisError as error:
        _outage.failed(error)
        return
    _outage.over()
    if recovery.requeued or recovery.failed or tickets:
        _log.info(
            "runs_recovered", requeued=recovery.requeued, failed=recovery.failed, tickets=tickets
        )
