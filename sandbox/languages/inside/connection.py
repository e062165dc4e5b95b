"""The program's end of the protocol (docs/protocol.md), as all scripts in this folder speak it."""

import json
import os
import resource
import struct
import sys
from collections.abc import Sequence
from itertools import pairwise

TYPE_CHECKING = False  # `typing` takes a millisecond of every start
if TYPE_CHECKING:
    from typing import Any, NoReturn

VERSION = 1
HEADER = struct.Struct("<cB2xI")
COMMAND = struct.Struct("<4d")
SIZES = struct.Struct("<II")
ERROR = struct.Struct("<cH")
MOST_BYTES = 65536  # [B] one frame
MOST_FIELD = 1e6  # [m/s, rad/s] a command beyond is a mistake, not a wish
MOST_SENTENCE, MOST_TEXT = 1500, 16000  # [B]
DESCRIPTORS = 4096  # above the limit of open files


class Connection:
    """The descriptor and the number of the question that waits for an answer."""

    def __init__(self, descriptor: int) -> None:
        self.fd = descriptor
        self.sequence = 0

    def send(self, kind: bytes, body: bytes = b"") -> None:
        """Send one frame that answers the present question."""
        os.write(self.fd, HEADER.pack(kind, VERSION, self.sequence) + body)

    def receive(self) -> tuple[bytes, bytes]:
        """Return kind and body of the next question; ends the process if nobody asks any more."""
        data = os.read(self.fd, MOST_BYTES)
        if not data:
            os._exit(0)
        kind, _, self.sequence = HEADER.unpack_from(data)
        return kind, data[HEADER.size :]

    def close_others(self, *kept: int) -> None:
        """Close every descriptor but this one, the standard streams and those that are kept."""
        wanted = sorted({2, self.fd, *kept, DESCRIPTORS})
        for before, after in pairwise(wanted):
            os.closerange(before + 1, after)

    def program(self) -> "tuple[dict[str, Any], bytes]":
        """Receive header and program."""
        header_size, source_size = SIZES.unpack(self.receive()[1])
        data = bytearray()
        while len(data) < header_size + source_size:
            data += self.receive()[1]
        return json.loads(data[:header_size]), bytes(data[header_size:])

    def give_up(self, kind: bytes, sentence: str, text: str = "") -> "NoReturn":
        """Send the last frame and end."""
        words = sentence.encode("utf-8", "replace")[:MOST_SENTENCE]
        trace = text.encode("utf-8", "replace")[:MOST_TEXT]
        self.send(b"x", ERROR.pack(kind, len(words)) + words + trace)
        os._exit(1)

    def leave(self) -> "NoReturn":
        """Say the last word and end well."""
        sys.stdout.flush()
        self.send(b"q")
        os._exit(0)


def connected(
    numbers: Sequence[str], *, inherited: bool = False, images: bool = False
) -> Connection:
    """Close what is not needed, set the limits, say that the box is up.

    Parameters
    ----------
    numbers : 3 texts
        The protocol's descriptor; processes and memory [MiB] to limit here, 0 where control groups
        do it.
    inherited : bool
        Whether a program that this process becomes keeps the connection.
    images : bool
        Whether the descriptor of images may be needed: then `close_others` is the caller's to call.
    """
    descriptor, processes, memory_mib = map(int, numbers)
    connection = Connection(descriptor)
    if not images:
        connection.close_others()
    _limit(resource.RLIMIT_NPROC, processes)
    _limit(resource.RLIMIT_AS, memory_mib << 20)
    os.set_inheritable(descriptor, inherited)
    return connection


def _limit(which: int, value: int) -> None:
    """Lower a limit for good; 0 leaves it."""
    if value:
        resource.setrlimit(which, (value, value))
