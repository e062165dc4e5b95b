"""What a simulator child tells its celery child: small framed messages over a stream socket."""

import json
import select
import socket
import struct
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from enum import Enum
from typing import Any

_HEADER = struct.Struct("<cI")
LENGTH_MAX = 64 * 2**20  # [byte]
_CHUNK = 256 * 1024


class Kind(Enum):
    """The sorts of messages; the first four may come often."""

    ROWS = b"R"  # float64 bytes of whole telemetry rows
    LOG = b"L"  # what the program printed
    TRIAL = b"T"  # JSON: a trial has ended, {"trial", ...}
    CUT = b"X"  # JSON: forget this trial's rows, it is done again, {"trial", "why"}
    HELLO = b"H"  # JSON: {"pid"}
    ENDING = b"D"  # JSON: how the evaluation ended, see seamark.worker.evaluation.evaluation.Ending
    ERROR = b"E"  # text: a traceback of ours
    RESULT = b"P"  # pickle: how one trial ended, from a fork to its parent alone


@dataclass(frozen=True, slots=True)
class Frame:
    """One message."""

    kind: Kind
    payload: bytes

    def json(self) -> dict[str, Any]:
        """Return the payload of a JSON message."""
        value: dict[str, Any] = json.loads(self.payload)
        return value


class StreamBroken(Exception):
    """The other side sent something that is no message: our failure."""


def send(channel: socket.socket, kind: Kind, payload: bytes | Mapping[str, Any]) -> None:
    """Send one message; blocks while the other side does not read."""
    body = payload if isinstance(payload, bytes) else json.dumps(payload).encode()
    channel.sendall(_HEADER.pack(kind.value, len(body)) + body)


class Reader:
    """Takes messages from a socket without waiting longer than asked."""

    def __init__(self, channel: socket.socket) -> None:
        self._channel = channel
        self._buffer = bytearray()
        self.ended = False  # the other side has closed its end, and all its messages were taken

    def read(self, timeout_s: float) -> Iterator[Frame]:
        """Yield what is there, after waiting up to `timeout_s` for the first byte."""
        ready, _, _ = select.select([self._channel], [], [], timeout_s)
        if ready:
            data = self._channel.recv(_CHUNK)
            self._buffer += data
            self.ended = not data
        while (frame := self._take()) is not None:
            yield frame

    def _take(self) -> Frame | None:
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
        try:
            return Frame(Kind(code), payload)
        except ValueError:
            raise StreamBroken(f"a message of the unknown kind {code!r}") from None
