"""Messages between the processes of a worker: types, one encoder, one decoder.

On the wire, a stream socket: one byte for the type, the payload's length (uint32, little-endian),
the payload.
"""

import json
import pickle
import select
import socket
import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from seamark.sim.recording import telemetry
from seamark.worker.ipc.outcomes import RunOutcome, TrialOutcome

LENGTH_MAX = 64 * 2**20  # [byte]
_HEADER = struct.Struct("<cI")
_CHUNK = 256 * 1024


@dataclass(frozen=True, slots=True)
class Started:
    """A process has taken the job."""

    pid: int


@dataclass(frozen=True, slots=True, eq=False)
class Rows:
    """Rows of telemetry."""

    rows: NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Log:
    """What the program printed."""

    text: bytes


@dataclass(frozen=True, slots=True)
class TrialEnded:
    """A trial is complete: all of its telemetry has been sent."""

    trial: int


@dataclass(frozen=True, slots=True)
class TrialRestarted:
    """A trial starts again, for `reason`: its telemetry so far is void."""

    trial: int
    reason: str


@dataclass(frozen=True, slots=True)
class TrialReport:
    """How one trial ended; sent by a fork to its parent, and unpickled there only."""

    pickled: bytes

    @classmethod
    def of(cls, outcome: TrialOutcome) -> "TrialReport":
        """Return the report of an outcome."""
        return cls(pickle.dumps(outcome))

    def outcome(self) -> TrialOutcome:
        """Return the outcome that was reported."""
        # From a fork of this very process, which could as well write into our memory.
        outcome: TrialOutcome = pickle.loads(self.pickled)  # noqa: S301
        return outcome


@dataclass(frozen=True, slots=True)
class BoxFailed:
    """The sandbox failed, not the program."""

    reason: str


@dataclass(frozen=True, slots=True)
class RunEnded:
    """The evaluation is complete."""

    outcome: RunOutcome


@dataclass(frozen=True, slots=True)
class Crashed:
    """The sending process failed with an exception: a failure of the platform."""

    traceback: str


Message = (
    Started
    | Rows
    | Log
    | TrialEnded
    | TrialRestarted
    | TrialReport
    | BoxFailed
    | RunEnded
    | Crashed
)


class StreamBroken(Exception):
    """The other side sent something that is no message: a failure of the platform."""


class _Codec(NamedTuple):
    code: bytes  # one byte on the wire
    encode: Callable[[Any], bytes]
    decode: Callable[[bytes], Message]


def _json(values: object) -> bytes:
    return json.dumps(values).encode()


_CODECS: dict[type[Message], _Codec] = {
    Started: _Codec(b"S", lambda m: _json(m.pid), lambda b: Started(json.loads(b))),
    Rows: _Codec(
        b"R", lambda m: telemetry.to_bytes(m.rows), lambda b: Rows(telemetry.from_bytes(b))
    ),
    Log: _Codec(b"L", lambda m: m.text, Log),
    TrialEnded: _Codec(b"T", lambda m: _json(m.trial), lambda b: TrialEnded(json.loads(b))),
    TrialRestarted: _Codec(
        b"A", lambda m: _json([m.trial, m.reason]), lambda b: TrialRestarted(*json.loads(b))
    ),
    TrialReport: _Codec(b"P", lambda m: m.pickled, TrialReport),
    BoxFailed: _Codec(b"B", lambda m: m.reason.encode(), lambda b: BoxFailed(_text(b))),
    RunEnded: _Codec(
        b"E",
        lambda m: _json(m.outcome.to_json()),
        lambda b: RunEnded(RunOutcome.from_json(json.loads(b))),
    ),
    Crashed: _Codec(b"C", lambda m: m.traceback.encode(), lambda b: Crashed(_text(b))),
}
_DECODERS = {codec.code: codec.decode for codec in _CODECS.values()}


def _text(payload: bytes) -> str:
    return payload.decode("utf-8", "replace")


def send(channel: socket.socket, message: Message) -> None:
    """Send one message; blocks while the other side does not read."""
    codec = _CODECS[type(message)]
    payload = codec.encode(message)
    channel.sendall(_HEADER.pack(codec.code, len(payload)) + payload)


def size(message: Message) -> int:
    """Return how many bytes a waiting message takes, about; only the frequent ones count."""
    match message:
        case Rows(rows):
            return rows.nbytes
        case Log(text):
            return len(text)
        case _:
            return 0


class Reader:
    """Reads messages from a socket without waiting longer than asked."""

    def __init__(self, channel: socket.socket) -> None:
        self._channel = channel
        self._buffer = bytearray()
        self.closed = False  # the other side has closed its end, and everything was read

    def read(self, timeout_s: float) -> Iterator[Message]:
        """Yield the messages that are there, after waiting up to `timeout_s` for the first byte.

        Raises
        ------
        StreamBroken
            When what came is no message.
        """
        ready, _, _ = select.select([self._channel], [], [], timeout_s)
        if ready:
            data = self._channel.recv(_CHUNK)
            self._buffer += data
            self.closed = not data
        while (message := self._next()) is not None:
            yield message

    def _next(self) -> Message | None:
        if len(self._buffer) < _HEADER.size:
            return None
        code, length = _HEADER.unpack_from(self._buffer)
        if length > LENGTH_MAX:
            raise StreamBroken(f"a message of {length} bytes")
        end = _HEADER.size + length
        if len(self._buffer) < end:
            return None
        payload = bytes(self._buffer[_HEADER.size : end])
        del self._buffer[:end]
        if code not in _DECODERS:
            raise StreamBroken(f"a message of unknown type {code!r}")
        return _DECODERS[code](payload)
