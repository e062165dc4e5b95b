"""Both ends of the protocol, each with a peer that sends arbitrary packets.

The simulator's end is the real `ProtocolSession` over a real socket; only the process tree is a
fake, since a peer that may send anything needs no process. The runner is the real one, in a process
of its own.
"""

import contextlib
import os
import select
import signal
import socket
import struct
import types
from collections.abc import Sequence
from typing import Any, cast

from seamark.sandbox.isolation.process_tree import ProcessTree
from seamark.sandbox.languages.inside.connection import DISCONNECTED
from seamark.sandbox.languages.inside.wire import MAX_VALUE, SIZES
from seamark.sandbox.limits import Limits
from seamark.sandbox.outcome import ProgramEnded, SandboxBroken, Verdict
from seamark.sandbox.protocol import answers, messages
from seamark.sandbox.protocol.messages import MessageInvalid
from seamark.sandbox.protocol.session import ProtocolSession
from tests.fuzz.runner_forks import NUMBER, forks

LIMITS = Limits(step_wall_s=5.0, start_wall_s=5.0)
SOON = struct.pack("@ll", 5, 0)
END_WITHIN_S = 20.0  # [s] a runner that hangs is found; it has nothing to wait for
VERDICTS = {Verdict.PROTOCOL_ERROR, *messages.VERDICTS.values()}

HEADER = (
    b'{"protocol": 1, "filename": "a.py", "config": {}, '
    b'"layout": {"observation": [["t", 0], ["error", 3]], "booleans": []}}'
)
SOURCE = b"""
class Controller:
    def __init__(self, config): ...
    def reset(self, level): ...
    def step(self, observation):
        return [observation.t, *observation.error]
"""


class FakeProcessTree:
    """What a session sees of the processes of a box."""

    cpu_every_s = 0.02

    def __init__(self) -> None:
        self.socket, self.theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVTIMEO, SOON)
        self.theirs.setblocking(False)
        self.output, self.stdout = os.pipe2(os.O_NONBLOCK)
        self.pidfd = os.eventfd(0)  # never readable, like that of a running process

    def cpu_s(self) -> float:
        return 0.0

    def run_queue_waits_s(self) -> dict[int, float]:
        return {}

    def memory_mib(self) -> float:
        return 0.0

    def out_of_memory(self) -> bool:
        return False

    def host_out_of_memory(self) -> bool:
        return False

    def out_of_processes(self) -> bool:
        return False

    def exit_code(self, within_s: float) -> int | None:
        return DISCONNECTED

    def kill(self) -> None: ...

    def close(self) -> None:
        self.socket.close()
        self.theirs.close()
        for descriptor in (self.output, self.stdout, self.pidfd):
            os.close(descriptor)


def simulator(sent: Sequence[bytes], printed: bytes = b"") -> Verdict:
    """Send all requests to a peer that has sent these packets and left; return the verdict.

    Decoded answers are checked again here: nothing that is not finite may get through.
    """
    tree = FakeProcessTree()
    try:
        with contextlib.suppress(BlockingIOError):  # the kernel's buffer is limited
            for packet in sent:
                tree.theirs.send(packet)
        with contextlib.suppress(BlockingIOError):
            os.write(tree.stdout, printed)
        tree.theirs.shutdown(socket.SHUT_WR)
        session = ProtocolSession(cast(ProcessTree, tree), LIMITS)
        return _asked(session)
    finally:
        tree.close()


def _asked(session: ProtocolSession) -> Verdict:
    limit = LIMITS.step_limit
    try:
        session.answer(messages.READY, limit, "start")
        session.begin()
        for request, message_type, read in (
            (messages.SOURCE, messages.READY, None),
            (messages.OBSERVE, messages.COMMAND, answers.command),
            (messages.UPDATE, messages.TRACK, answers.track),
            (messages.DETECT, messages.DETECTIONS, answers.detections),
        ):
            session.ask(request, b"")
            data = session.answer(message_type, limit, "the answer")
            if read is not None:
                _assert_finite(read(data))
        return session.finish().verdict
    except MessageInvalid:
        return Verdict.PROTOCOL_ERROR
    except ProgramEnded as end:
        if end.outcome.verdict not in VERDICTS:
            raise AssertionError(f"a message led to {end.outcome.verdict}") from end
        text = end.outcome.sentence + end.outcome.traceback
        if not all(c.isprintable() or c in "\n\t" for c in text):
            raise AssertionError(f"control characters in {text!r}") from end
        return end.outcome.verdict
    except SandboxBroken:  # it ended before there was a program: our failure, not a crash
        return Verdict.PROTOCOL_ERROR


def _assert_finite(answer: Any) -> None:
    """Raise AssertionError for an answer that no simulator could use."""
    if isinstance(answer, float):
        if not abs(answer) <= MAX_VALUE:
            raise AssertionError(f"{answer} got through")
    elif isinstance(answer, (tuple, list)):
        for one in answer:
            _assert_finite(one)


def loading(sequence: int = 1) -> list[bytes]:
    """Return the messages that load a good program."""
    sizes = SIZES.pack(len(HEADER), len(SOURCE))
    return [
        messages.message(messages.BEGIN, sequence, sizes),
        messages.message(messages.SOURCE, sequence + 1, HEADER + SOURCE),
    ]


def runner(sent: Sequence[bytes]) -> tuple[int, list[bytes]]:
    """Send these packets to a runner and leave; return its exit code and the types it answered."""
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    process = forks()
    with theirs:
        socket.send_fds(process, [b"r"], [theirs.fileno()])
    pid = _number(process)
    ours.setblocking(False)
    try:
        with contextlib.suppress(BlockingIOError, BrokenPipeError):
            for packet in sent:
                ours.send(packet)
        with contextlib.suppress(OSError):
            ours.shutdown(socket.SHUT_WR)
        if not select.select([process], [], [], END_WITHIN_S)[0]:
            os.kill(pid, signal.SIGKILL)  # nobody has waited for it: the number is still its own
            _number(process)
            raise AssertionError(f"the runner hangs after {sent!r}")
        return _number(process), _types(ours)
    finally:
        ours.close()


def _number(process: socket.socket) -> int:
    (number,) = NUMBER.unpack(process.recv(NUMBER.size))
    return int(number)


def _types(ours: socket.socket) -> list[bytes]:
    """Return the types of the waiting messages; the kernel first reports that the peer has left."""
    types_: list[bytes] = []
    for _ in range(2):
        with contextlib.suppress(BlockingIOError, ConnectionResetError):
            while packet := ours.recv(1 << 17):
                messages.check(packet, packet[:1], struct.unpack_from("<I", packet, 4)[0])
                types_.append(packet[:1])
    return types_


GOOD_EXITS = types.MappingProxyType(
    {
        0: "it quit, or the peer is gone",
        1: "it reported an error",
        DISCONNECTED: "it is disconnected",
    }
)
