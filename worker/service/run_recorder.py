"""Writes what happens during a run into its files."""

import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from seamark.server.runs.files import RunFiles
from seamark.sim.recording.telemetry import INDEX


class RunRecorder:
    """The `seamark.worker.ipc.listener.Listener` of a run on the server."""

    def __init__(
        self, files: RunFiles, *, trial_s: float, truncate: Callable[[int], None] | None = None
    ) -> None:
        self.t_simulated = 0.0  # [s] over all trials
        self._files = files
        self._truncate = truncate or files.truncate_rows
        self._trial_s = trial_s
        self._trial_start_row = 0
        self.first_rows_at: float | None = None  # monotonic

    def rows(self, rows: NDArray[np.float64]) -> None:
        """Append telemetry."""
        if self.first_rows_at is None:
            self.first_rows_at = time.monotonic()
        self._files.append_rows(rows)
        last = rows[-1]
        self.t_simulated = float(last[INDEX["trial"]]) * self._trial_s + float(last[INDEX["t"]])

    def log(self, text: bytes) -> None:
        """Append what the program printed."""
        self._files.append_log(text)

    def trial_ended(self, trial: int) -> None:
        """Keep the rows so far: a restart of the next trial does not touch them."""
        self._trial_start_row = self._files.row_count()

    def trial_restarted(self, trial: int, reason: str) -> None:
        """Discard the rows of the trial, and log that it starts again."""
        self._truncate(self._trial_start_row)
        self.log(f"[Trial {trial + 1} starts again: the host was slow.]\n".encode())
