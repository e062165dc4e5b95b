"""What those see who watch a run: thinned telemetry, the log, the state.

A broker that is away must not stop a run, so errors are logged once and swallowed.
"""

import math
import time
from typing import Any

import numpy as np
import structlog
from numpy.typing import NDArray
from redis import Redis
from redis.exceptions import RedisError

from seamark.server.messaging import live_events
from seamark.sim.recording.telemetry import INDEX, NAMES

SHOWN_HZ = 5.0  # rows per simulated second at most
EVERY_S = 0.1  # [s] of wall time between two batches
LOG_MAX = 16 * 1024  # [byte] of printed text per event; all of it is in the log file
_T = INDEX["t"]
_TRIAL = INDEX["trial"]
COLUMNS = [name for name in NAMES if name != "step_us"]
_AT = [INDEX[name] for name in COLUMNS]


class Broadcast:
    """Sends the live events of one run."""

    def __init__(self, redis: "Redis", run_id: int) -> None:
        self._redis = redis
        self._run_id = run_id
        self._rows: list[list[float | None]] = []
        self._sent_at = 0.0
        self._last = (-1.0, -math.inf)  # trial and time of the last row that was kept
        self._silent = False

    def rows(self, rows: NDArray[np.float64]) -> None:
        """Keep every fourth row or so, and send them in batches."""
        for row in rows:
            trial, t = float(row[_TRIAL]), float(row[_T])
            if trial == self._last[0] and 0 <= t - self._last[1] < 1 / SHOWN_HZ - 1e-9:
                continue
            self._last = (trial, t)
            self._rows.append([_short(value) for value in row[_AT].tolist()])
        if time.monotonic() - self._sent_at >= EVERY_S:
            self.flush()

    def flush(self) -> None:
        """Send the rows that wait."""
        if self._rows:
            self._send(live_events.TELEMETRY, {"columns": COLUMNS, "rows": self._rows})
            self._rows = []
            self._sent_at = time.monotonic()

    def log(self, text: bytes) -> None:
        """Send what the program printed."""
        self._send(live_events.LOG, {"text": text[:LOG_MAX].decode("utf-8", "replace")})

    def state(self, state: str, *, progress: float, t_simulated: float) -> None:
        """Send where the run is."""
        data = {"state": str(state), "progress": progress, "t_simulated": t_simulated}
        self._send(live_events.STATE, data | {"position": None})

    def end(self) -> None:
        """Tell that nothing more comes."""
        self._send(live_events.END, {})

    def _send(self, kind: str, data: dict[str, Any]) -> None:
        try:
            live_events.append(self._redis, self._run_id, kind, data)
            self._silent = False
        except RedisError as error:
            if not self._silent:
                structlog.get_logger().warning(
                    "live_event_lost", run=self._run_id, kind=kind, error=str(error)
                )
            self._silent = True


def _short(value: float) -> float | None:
    """Return the value with seven digits, enough for a chart; what is no number is left out."""
    return float(f"{value:.7g}") if math.isfinite(value) else None
