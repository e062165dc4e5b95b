"""Publishes a run live: thinned telemetry, the log, the state.

An unreachable broker must not stop a run, so its errors are logged once and ignored.
"""

import math
import time
from typing import Any

import numpy as np
import structlog
from numpy.typing import NDArray
from redis import Redis
from redis.exceptions import RedisError

from seamark.sandbox.printable_text import printable_text
from seamark.server.messaging import live_events
from seamark.sim.recording import telemetry
from seamark.sim.recording.telemetry import INDEX, STEP_US

PUBLISHED_HZ = 5.0  # rows per simulated second at most
BATCH_S = 0.1  # [s] of wall time between two batches
LOG_MAX = 16 * 1024  # [byte] of printed text per event; all of it is in the log file
_T = INDEX["t"]
_TRIAL = INDEX["trial"]


class LivePublisher:
    """Publishes the live events of one run."""

    def __init__(self, redis: "Redis", run_id: int) -> None:
        self._redis = redis
        self._run_id = run_id
        self._columns: list[str] = []
        self._rows: list[list[float | None]] = []
        self._sent_at = 0.0
        self._last = (-1.0, -math.inf)  # trial and time of the last row that was kept
        self._failing = False

    def rows(self, rows: NDArray[np.float64]) -> None:
        """Publish about every fourth row, in batches."""
        self._columns = list(telemetry.names(rows.shape[1]))
        del self._columns[STEP_US]
        for row in rows:
            trial, t = float(row[_TRIAL]), float(row[_T])
            if trial == self._last[0] and 0 <= t - self._last[1] < 1 / PUBLISHED_HZ - 1e-9:
                continue
            self._last = (trial, t)
            self._rows.append([_rounded(value) for value in np.delete(row, STEP_US).tolist()])
        if time.monotonic() - self._sent_at >= BATCH_S:
            self.flush()

    def flush(self) -> None:
        """Publish the rows that are waiting."""
        if self._rows:
            self._publish(live_events.TELEMETRY, {"columns": self._columns, "rows": self._rows})
            self._rows = []
            self._sent_at = time.monotonic()

    def log(self, text: bytes) -> None:
        """Publish what the program printed."""
        shown = printable_text(text[:LOG_MAX].decode("utf-8", "replace"))
        self._publish(live_events.LOG, {"text": shown})

    def state(self, state: str, *, progress: float, t_simulated: float) -> None:
        """Publish the state and the progress of the run."""
        data = {"state": str(state), "progress": progress, "t_simulated": t_simulated}
        self._publish(live_events.STATE, data | {"position": None})

    def end(self) -> None:
        """Publish that no more events follow."""
        self._publish(live_events.END, {})

    def _publish(self, event_type: str, data: dict[str, Any]) -> None:
        try:
            live_events.append(self._redis, self._run_id, event_type, data)
            self._failing = False
        except RedisError as error:
            if not self._failing:
                structlog.get_logger().warning(
                    "live_event_lost", run=self._run_id, type=event_type, error=str(error)
                )
            self._failing = True


def _rounded(value: float) -> float | None:
    """Return the value with seven digits, enough for a chart; None if it is not finite."""
    return float(f"{value:.7g}") if math.isfinite(value) else None
