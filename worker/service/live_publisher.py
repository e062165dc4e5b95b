"""Publishes the state of a run live; what it records, the web processes read from its files.

An unreachable broker must not stop a run, so its errors are logged once and ignored.
"""

import structlog
from redis import Redis
from redis.exceptions import RedisError

from seamark.server.messaging import live_events


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
                structlog.get_logger().warning(
                    "state_not_published", run=self._run_id, error=str(error)
                )
            self._failing = True
