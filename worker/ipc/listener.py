"""A listener at one end of a socket, for whoever reads frames at the other end."""

import socket

import numpy as np
from numpy.typing import NDArray

from seamark.worker.ipc import messages
from seamark.worker.ipc.messages import Kind


class Telling:
    """A `seamark.worker.evaluation.evaluation.Listener` that passes everything on as frames."""

    def __init__(self, channel: socket.socket) -> None:
        self._channel = channel

    def rows(self, rows: NDArray[np.float64]) -> None:
        """Send telemetry."""
        messages.send(self._channel, Kind.ROWS, np.ascontiguousarray(rows, "<f8").tobytes())

    def log(self, text: bytes) -> None:
        """Send what the program printed."""
        messages.send(self._channel, Kind.LOG, text)

    def trial_ended(self, trial: int) -> None:
        """Tell that a trial has ended."""
        messages.send(self._channel, Kind.TRIAL, {"trial": trial})

    def cut(self, trial: int, why: str) -> None:
        """Tell that a trial is done again."""
        messages.send(self._channel, Kind.CUT, {"trial": trial, "why": why})
