"""Changes of state, published to all web processes at once.

What a run records is in its files, and its state in the database. A message that is lost only makes
viewers wait for the next look at the database, so the broker keeps none.
"""

import json
from typing import Any

from redis import Redis

CHANNEL = "seamark.states"
RUN = "run"  # key of the run's id in a message; the other keys are those of a state event


def publish_state(
    redis: "Redis", run_id: int, state: str, *, progress: float = 0.0, t_simulated: float = 0.0
) -> None:
    """Publish the state of a run that is not queued, or that has lost its progress.

    Raises RedisError.
    """
    values = {"state": str(state), "progress": progress, "t_simulated": t_simulated}
    redis.publish(CHANNEL, json.dumps({RUN: run_id} | values | {"position": None}))


def parse(message: bytes) -> tuple[int, dict[str, Any]]:
    """Return the run's id and the values of its state."""
    values: dict[str, Any] = json.loads(message)
    return int(values.pop(RUN)), values
