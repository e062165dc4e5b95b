"""The program's end of the protocol (docs/protocol.md), for the scripts inside a box."""

import os
import resource
from collections.abc import Sequence
from itertools import pairwise

from .wire import ERROR, HEADER, MAX_MESSAGE_BYTES, SIZES, VERSION

TYPE_CHECKING = False  # importing `typing` would take a millisecond of every start
if TYPE_CHECKING:
    from typing import Any, NoReturn

MAX_SENTENCE_BYTES, MAX_TEXT_BYTES = 1500, 16000
MAX_DESCRIPTORS = 4096  # above the limit of open files
DISCONNECTED = 70  # exit code: the connection is lost


class Connection:
    """The socket, and the sequence number of the pending request."""

    def __init__(self, descriptor: int) -> None:
        self.descriptor = descriptor
        self.sequence = 0

    def send(self, message_type: bytes, body: bytes = b"") -> None:
        """Send one message that answers the pending request."""
        os.write(self.descriptor, HEADER.pack(message_type, VERSION, self.sequence) + body)

    def receive(self) -> tuple[bytes, bytes]:
        """Return type and body of the next request; exit if the simulator is gone."""
        data = os.read(self.descriptor, MAX_MESSAGE_BYTES)
        if not data:
            os._exit(0)
        message_type, _, self.sequence = HEADER.unpack_from(data)
        return message_type, data[HEADER.size :]

    def close_others(self, *kept: int) -> None:
        """Close all descriptors except this one, the standard streams and those that are kept."""
        wanted = sorted({2, self.descriptor, *kept, MAX_DESCRIPTORS})
        for before, after in pairwise(wanted):
            os.closerange(before + 1, after)

    def program(self) -> "tuple[dict[str, Any], bytes]":
        """Receive header and program."""
        import json  # noqa: PLC0415  (6 ms that a script which becomes another does not need)

        header_size, source_size = SIZES.unpack(self.receive()[1])
        data = bytearray()
        while len(data) < header_size + source_size:
            data += self.receive()[1]
        return json.loads(data[:header_size]), bytes(data[header_size:])

    def give_up(self, letter: bytes, sentence: str, text: str = "") -> "NoReturn":
        """Report an error, with the letter of its verdict, and exit."""
        encoded = sentence.encode("utf-8", "replace")[:MAX_SENTENCE_BYTES]
        trace = text.encode("utf-8", "replace")[:MAX_TEXT_BYTES]
        try:
            self.send(b"x", ERROR.pack(letter, len(encoded)) + encoded + trace)
        except OSError:
            os._exit(DISCONNECTED)
        os._exit(1)

    def quit(self) -> "NoReturn":
        """Send the last message and exit. No `atexit` and no `__del__` of the program runs."""
        self.send(b"q")
        os._exit(0)


def connected(
    numbers: Sequence[str], *, inherited: bool = False, images: bool = False
) -> Connection:
    """Return the connection after closing other descriptors and setting the limits.

    Parameters
    ----------
    numbers : 3 texts
        The socket's descriptor; the limits of processes and memory [MiB] to set here, 0 if control
        groups enforce them.
    inherited : bool
        Whether a program that replaces this process keeps the connection.
    images : bool
        Whether the images' descriptor may be needed: then the caller has to call `close_others`.
    """
    descriptor, processes, memory_mib = map(int, numbers)
    connection = Connection(descriptor)
    if not images:
        connection.close_others()
    # Inside the user namespace: outside, the boxes of one user would share the limit.
    _limit(resource.RLIMIT_NPROC, processes)
    _limit(resource.RLIMIT_AS, memory_mib << 20)
    os.set_inheritable(descriptor, inherited)
    return connection


def _limit(which: int, value: int) -> None:
    """Lower a limit for good; 0 keeps it."""
    if value:
        resource.setrlimit(which, (value, value))
