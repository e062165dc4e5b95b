"""Says what became of runs that had lost their workers, and has other workers take them over."""

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


def announce(app: Celery, redis: "Redis", recovery: Recovery) -> None:
    """Publish the new states, and send the tickets that the queue lacks; after the commit."""
    try:
        for run_id in recovery.requeued:
            live_events.publish_state(redis, run_id, RunState.QUEUED)
        for run_id in recovery.failed:
            live_events.publish_state(redis, run_id, RunState.FAILED)
        tickets = broker.top_up(app, redis, recovery.tickets)
    except RedisError as error:  # the queue is in the database: a broker that is away is no failure
        _outage.failed(error)
        return
    _outage.over()
    if recovery.requeued or recovery.failed or tickets:
        _log.info(
            "runs_recovered", requeued=recovery.requeued, failed=recovery.failed, tickets=tickets
        )
