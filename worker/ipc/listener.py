"""Listeners: the receivers of what happens during a run, in this process or across a socket."""

import socket
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from seamark.worker.ipc import messages
from seamark.worker.ipc.messages import Log, Message, Rows, TrialEnded, TrialRestarted


class Listener(Protocol):
    """Is called in the order of the trials, however many of them run in parallel."""

    def rows(self, rows: NDArray[np.float64]) -> None:
        """Receive rows of telemetry in order."""

    def log(self, text: bytes) -> None:
        """Receive what the program printed."""

    def trial_ended(self, trial: int) -> None:
        """Learn that a trial is complete."""

    def trial_restarted(self, trial: int, reason: str) -> None:
        """Discard the rows of this trial: it starts again."""


class Sender:
    """A listener that sends everything through a socket; `deliver` is the other end."""

    def __init__(self, channel: socket.socket) -> None:
        self._channel = channel

    def rows(self, rows: NDArray[np.float64]) -> None:
        """Send telemetry."""
        messages.send(self._channel, Rows(rows))

    def log(self, text: bytes) -> None:
        """Send what the program printed."""
        messages.send(self._channel, Log(text))

    def trial_ended(self, trial: int) -> None:
        """Send that a trial is complete."""
        messages.send(self._channel, TrialEnded(trial))

    def trial_restarted(self, trial: int, reason: str) -> None:
        """Send that a trial starts again."""
        messages.send(self._channel, TrialRestarted(trial, reason))


def deliver(message: Message, listener: Listener) -> None:
    """Call the listener's method for a message.

    Raises
    ------
    StreamBroken
        When the message is none that a `Sender` sends.
    """
    match message:
        case Rows(rows):
            listener.rows(rows)
        case Log(text):
            listener.log(text)
        case TrialEnded(trial):
            listener.trial_ended(trial)
        case TrialRestarted(trial, reason):
            listener.trial_restarted(trial, reason)
        case _:
            raise messages.StreamBroken(f"{type(message).__name__} came unexpectedly")
