"""Both sides of the protocol beside a peer that sends whatever it likes.

The trusted side is the real `Conversation` over a real socket; only the processes of a box are
stood in for, since a peer that may send anything needs none. The runner is the real one, in a fork.
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

from seamark.sandbox.isolation.process_tree import Confined
from seamark.sandbox.languages.python_inside.runner import Runner
from seamark.sandbox.languages.python_inside.values import Observation
from seamark.sandbox.limits import Limits
from seamark.sandbox.outcome import ProgramEnded, SandboxBroken, Verdict
from seamark.sandbox.protocol import answers, messages
from seamark.sandbox.protocol.messages import FrameInvalid
from seamark.sandbox.protocol.session import Conversation

LIMITS = Limits(step_wall_s=5.0, start_wall_s=5.0)
CLOSED = 70  # exit code of a runner whose connection is gone
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


class Cage:
    """What the trusted side sees of a box's processes."""

    cpu_every_s = 0.02

    def __init__(self) -> None:
        self.socket, self.theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVTIMEO, SOON)
        self.theirs.setblocking(False)
        self.output, self._printing = os.pipe2(os.O_NONBLOCK)
        self.pidfd = os.eventfd(0)  # never readable, like that of a process that lives

    def cpu_s(self) -> float:
        return 0.0

    def memory_mib(self) -> float:
        return 0.0

    def out_of_memory(self) -> bool:
        return False

    def host_out_of_memory(self) -> bool:
        return False

    def out_of_processes(self) -> bool:
        return False

    def exit_code(self, within_s: float) -> int | None:
        return CLOSED

    def kill(self) -> None: ...

    def close(self) -> None:
        self.socket.close()
        self.theirs.close()
        for descriptor in (self.output, self._printing, self.pidfd):
            os.close(descriptor)


def trusted(sent: Sequence[bytes], printed: bytes = b"") -> Verdict:
    """Ask all questions of a peer that has sent these packets and left; return the verdict.

    What it answers is checked here once more: nothing that is not finite may get through.
    """
    cage = Cage()
    try:
        with contextlib.suppress(BlockingIOError):  # the kernel holds only so much
            for packet in sent:
                cage.theirs.send(packet)
        with contextlib.suppress(BlockingIOError):
            os.write(cage._printing, printed)
        cage.theirs.shutdown(socket.SHUT_WR)
        talk = Conversation(cast(Confined, cage), LIMITS)
        return _asked(talk)
    finally:
        cage.close()


def _asked(talk: Conversation) -> Verdict:
    patience = LIMITS.stepping
    try:
        talk.answer(messages.READY, patience, "start")
        talk.begin()
        for question, kind, read in (
            (messages.SOURCE, messages.READY, None),
            (messages.OBSERVE, messages.ANSWER, answers.command),
            (messages.UPDATE, messages.TRACK, answers.track),
            (messages.DETECT, messages.DETECTIONS, answers.detections),
        ):
            talk.ask(question, b"")
            data = talk.answer(kind, patience, "the answer")
            if read is not None:
                _must_be_sound(read(data))
        return talk.finish().verdict
    except FrameInvalid:
        return Verdict.PROTOCOL_ERROR
    except ProgramEnded as end:
        if end.outcome.verdict not in VERDICTS:
            raise AssertionError(f"a frame made {end.outcome.verdict}") from end
        text = end.outcome.sentence + end.outcome.traceback
        if not all(c.isprintable() or c in "\n\t" for c in text):
            raise AssertionError(f"control characters in {text!r}") from end
        return end.outcome.verdict
    except SandboxBroken:  # it ended before there was a program: ours to explain, no crash
        return Verdict.PROTOCOL_ERROR


def _must_be_sound(answer: Any) -> None:
    """Raise AssertionError for an answer that no simulator could use."""
    if isinstance(answer, float):
        if not abs(answer) <= answers.MOST_FIELD:
            raise AssertionError(f"{answer} got through")
    elif isinstance(answer, (tuple, list)):
        for one in answer:
            _must_be_sound(one)


def loading(sequence: int = 1) -> list[bytes]:
    """Return the frames that load a program which is well."""
    sizes = messages.SIZES.pack(len(HEADER), len(SOURCE))
    return [
        messages.frame(messages.BEGIN, sequence, sizes),
        messages.frame(messages.SOURCE, sequence + 1, HEADER + SOURCE),
    ]


def runner(sent: Sequence[bytes]) -> tuple[int, list[bytes]]:
    """Send these packets to a runner and leave; return its exit code and the kinds it answered."""
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    pid = os.fork()
    if pid == 0:
        _be_runner(ours, theirs)
    theirs.close()
    pidfd = os.pidfd_open(pid)
    ours.setblocking(False)
    try:
        with contextlib.suppress(BlockingIOError, BrokenPipeError):
            for packet in sent:
                ours.send(packet)
        with contextlib.suppress(OSError):
            ours.shutdown(socket.SHUT_WR)
        if not select.select([pidfd], [], [], END_WITHIN_S)[0]:
            os.kill(pid, signal.SIGKILL)
            raise AssertionError(f"the runner hangs after {sent!r}")
        return os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]), _kinds(ours)
    finally:
        os.close(pidfd)
        ours.close()


def _be_runner(ours: socket.socket, theirs: socket.socket) -> None:
    """Be the runner in this fork; never returns."""
    try:
        ours.close()
        quiet = os.open("/dev/null", os.O_RDWR)
        for number in (1, 2):
            os.dup2(quiet, number)
        Observation._fields.clear()
        Runner(theirs.fileno()).run()
    finally:
        os._exit(99)


def _kinds(ours: socket.socket) -> list[bytes]:
    """Return the kinds of what is waiting; a peer that left is told of before it."""
    kinds: list[bytes] = []
    for _ in range(2):
        with contextlib.suppress(BlockingIOError, ConnectionResetError):
            while packet := ours.recv(1 << 17):
                messages.check(packet, packet[:1], struct.unpack_from("<I", packet, 4)[0])
                kinds.append(packet[:1])
    return kinds


GOOD_EXITS = types.MappingProxyType(
    {0: "the last word, or nobody there", 1: "it said what was wrong", CLOSED: "cannot speak"}
)
