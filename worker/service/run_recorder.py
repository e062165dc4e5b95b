"""Writes what happens during a run into its files."""

import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from seamark.server.runs.data.files import RunFiles
from seamark.sim.recording.telemetry import INDEX


class RunRecorder:
    """The `seamark.worker.ipc.listener.Listener` of a run on the server.

    Parameters
    ----------
    trial_s
        How long a trial is [s].
    truncate
        Shortens the rows that others follow; None: those of `files`.
    shown_trials
        After so many trials everything is held back, until `show` or `discard`; None: nothing is.
    """

    def __init__(
        self,
        files: RunFiles,
        *,
        trial_s: float,
        truncate: Callable[[int], None] | None = None,
        shown_trials: int | None = None,
    ) -> None:
        self.t_simulated = 0.0  # [s] over all trials
        self._files = files
        self._shown_trials = shown_trials
        self._held: RunFiles | None = None  # where everything goes since the last shown trial
        self._truncate = truncate or files.truncate_rows
        self._trial_s = trial_s
        self._trial_start_row = 0
        self.first_rows_at: float | None = None  # monotonic

    @property
    def holds_back(self) -> bool:
        """Whether trials have begun that nobody may see yet."""
        return self._held is not None

    @property
    def _current(self) -> RunFiles:
        return self._held or self._files

    def rows(self, rows: NDArray[np.float64]) -> None:
        """Append telemetry."""
        if self.first_rows_at is None:
            self.first_rows_at = time.monotonic()
        self._current.append_rows(rows)
        last = rows[-1]
        self.t_simulated = float(last[INDEX["trial"]]) * self._trial_s + float(last[INDEX["t"]])

    def log(self, text: bytes) -> None:
        """Append what the program printed."""
        self._current.append_log(text)

    def trial_ended(self, trial: int) -> None:
        """Keep the rows so far: a restart of the next trial does not touch them."""
        if trial + 1 == self._shown_trials:
            self._held = self._files.held_back()
        self._trial_start_row = self._current.row_count()

    def trial_restarted(self, trial: int, reason: str) -> None:
        """Discard the rows of the trial, and log that it starts again."""
        truncate = self._truncate if self._held is None else self._held.truncate_rows
        truncate(self._trial_start_row)
        self.log(f"[Trial {trial + 1} starts again: the host was slow.]\n".encode())

    def show(self) -> None:
        """Let everybody who may see the run see what was held back."""
        if self._held is not None:
            self._files.append_all(self._held)
            self._held = None

    def discard(self) -> None:
        """Remove what was held back."""
        if self._held is not None:
            self._held.remove()
            self._held = None
