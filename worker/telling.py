"""A listener at one end of a socket, for whoever reads frames at the other end."""

import socket

import numpy as np
from numpy.typing import NDArray

from worker import frames
from worker.frames import Kind


class Telling:
    """A `worker.trials.Listener` that passes everything on as frames."""

    def __init__(self, channel: socket.socket) -> None:
        self._channel = channel

    def rows(self, rows: NDArray[np.float64]) -> None:
        """Send telemetry."""
        frames.send(self._channel, Kind.ROWS, np.ascontiguousarray(rows, "<f8").tobytes())

    def log(self, text: bytes) -> None:
        """Send what the program printed."""
        frames.send(self._channel, Kind.LOG, text)

    def trial_ended(self, trial: int) -> None:
        """Tell that a trial has ended."""
        frames.send(self._channel, Kind.TRIAL, {"trial": trial})

    def cut(self, trial: int, why: str) -> None:
        """Tell that a trial is done again."""
        frames.send(self._channel, Kind.CUT, {"trial": trial, "why": why})
