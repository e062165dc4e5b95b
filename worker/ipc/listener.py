"""Listeners: the receivers of what happens during a run, in this process or across a socket."""

import socket
import time
from types import TracebackType
from typing import Protocol, Self

import numpy as np
from numpy.typing import NDArray

from seamark.worker.ipc import messages
from seamark.worker.ipc.messages import Log, Message, Rows, TrialEnded, TrialRestarted

# [s] a simulator writes rows a thousand times a second, and each message wakes the process that
# reads it: as much work as a few control steps. Whoever watches sees no delay that short.
TOGETHER_S = 0.05


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


class GatheringSender(Sender):
    """A sender of fewer messages: rows wait for others, but no longer than `TOGETHER_S`.

    Leaving it as a context sends the last ones.
    """

    def __init__(self, channel: socket.socket) -> None:
        super().__init__(channel)
        self._waiting: list[NDArray[np.float64]] = []
        self._send_at_s = 0.0  # monotonic

    def rows(self, rows: NDArray[np.float64]) -> None:
        """Send telemetry, unless some has just been sent."""
        self._waiting.append(rows)
        if time.monotonic() >= self._send_at_s:
            self._send_rows()

    def log(self, text: bytes) -> None:
        """Send what the program printed, after the rows before it."""
        self._send_rows()
        super().log(text)

    def trial_ended(self, trial: int) -> None:
        """Send that a trial is complete, after its rows."""
        self._send_rows()
        super().trial_ended(trial)

    def trial_restarted(self, trial: int, reason: str) -> None:
        """Send that a trial starts again; nobody needs its rows that wait."""
        self._waiting.clear()
        super().trial_restarted(trial, reason)

    def _send_rows(self) -> None:
        if self._waiting:
            super().rows(np.concatenate(self._waiting))
            self._waiting.clear()
            self._send_at_s = time.monotonic() + TOGETHER_S

    def __enter__(self) -> Self:
        """Return the sender itself."""
        return self

    def __exit__(
        self,
        error_type: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Send the rows that wait."""
        self._send_rows()


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
