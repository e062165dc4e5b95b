"""Question and answer with the processes of one box, while all its limits are minded."""

import contextlib
import os
import select
import socket
import struct
import time
from typing import NoReturn

from seamark.sandbox import verdicts
from seamark.sandbox.isolation.process_tree import Confined
from seamark.sandbox.limits import Limits, Patience
from seamark.sandbox.outcome import Outcome, ProgramEnded, SandboxBroken, Verdict
from seamark.sandbox.protocol import messages
from seamark.sandbox.protocol.head_tail import HeadTail
from seamark.sandbox.protocol.messages import Failure, FrameInvalid

SLICE_S = 0.25  # [s] waiting is cut into these, so that all limits are seen
LAST_WORDS_S = 2.0  # [s] for the process to end after its connection did
READ_BYTES = 65536  # [B] the capacity of a pipe


class Conversation:
    """The trusted side of the protocol. Whatever the program does, it ends as an outcome."""

    def __init__(self, cage: Confined, limits: Limits) -> None:
        self.limits = limits
        self.outcome: Outcome | None = None
        self._cage = cage
        self._socket = cage.socket
        self._poll = select.poll()
        for descriptor in (self._socket.fileno(), cage.pidfd, cage.output):
            self._poll.register(descriptor, select.POLLIN)
        self._socket_fd = self._socket.fileno()
        self._look_every_s = cage.cpu_every_s
        self._look_at = 0.0
        self._buffer = bytearray(messages.MOST_BYTES)
        self._view = memoryview(self._buffer)
        self._printed = HeadTail(limits.output_kib << 10)
        self._news = HeadTail(limits.output_kib << 10)
        self._sequence = 0
        self._loaded = False
        self._waited_s = self._cpu_before_s = self._cpu_seen_s = 0.0

    def begin(self) -> None:
        """From now on time and blame are the program's: it arrives."""
        self._loaded = True
        self._cpu_before_s = self._cpu_seen_s = self._cage.cpu_s()
        self._waited_s = 0.0

    def finish(self) -> Outcome:
        """Say good-bye; the same process must answer and end by itself, well."""
        self.ask(messages.QUIT)
        self._look_at_limits()
        self._cage.memory_mib()
        self.answer(messages.BYE, self.limits.stepping, "The end of the program")
        code = self._cage.exit_code(LAST_WORDS_S)
        if code != 0:
            self.end(verdicts.died(code) if code else _lives_on())
        self._drain()
        self.outcome = self._outcome(Failure(Verdict.OK, "The program ended well.", ""))
        return self.outcome

    def take_output(self) -> bytes:
        """Return what was printed since the last call: head and tail if it is much."""
        self._drain()
        return self.last_output()

    def last_output(self) -> bytes:
        """Return what was printed and already read since the last call."""
        text = self._news.text()
        self._news = HeadTail(self.limits.output_kib << 10)
        return text

    def ask(self, kind: bytes, body: bytes | memoryview = b"") -> None:
        """Send one frame."""
        if self.outcome is not None:
            raise ProgramEnded(self.outcome)
        self._sequence += 1
        message = messages.frame(kind, self._sequence, body)
        try:
            self._socket.send(message, socket.MSG_DONTWAIT)
        except BlockingIOError:
            self._send_slowly(message)
        except (BrokenPipeError, ConnectionResetError):
            self._gone()

    def _send_slowly(self, message: bytes) -> None:
        """Send a frame to a program that has not read those before, as soon as there is room."""
        writable = select.poll()
        writable.register(self._socket_fd, select.POLLOUT)
        begin = time.monotonic()
        while True:
            writable.poll(SLICE_S * 1000)
            self._look_around()
            try:
                self._socket.send(message, socket.MSG_DONTWAIT)
                return
            except BlockingIOError:
                if time.monotonic() - begin > self.limits.start_wall_s:
                    wall_s = self.limits.start_wall_s
                    self._late("The program", wall_s, since_cpu_s=self._cpu_seen_s)
            except (BrokenPipeError, ConnectionResetError):
                self._gone()

    def answer(self, kind: bytes, patience: Patience, waited_for: str) -> memoryview:
        """Return the program's answer; drains its output and minds all limits meanwhile.

        Most answers come at once: one system call waits for them a little while. Only what takes
        longer is waited for with an eye on everything else.
        """
        begin = time.monotonic()
        try:
            size = self._socket.recv_into(self._buffer, 0, socket.MSG_TRUNC)
        except BlockingIOError:
            size = self._wait(patience, waited_for, begin)
        except ConnectionResetError:
            size = self._received_bytes()
        now = time.monotonic()
        self._waited_s += now - begin
        if now > self._look_at:
            self._look_at = now + self._look_every_s
            self._look_around()
            if self._waited_s > self.limits.wall_s:
                self._late(waited_for, 0.0, since_cpu_s=self._cpu_before_s)
        return self._received(kind, size)

    def _wait(self, patience: Patience, waited_for: str, begin: float) -> int:
        """Return the size of an answer that takes long; ends the run if it takes too long."""
        seen_s = self._cpu_seen_s
        deadline = begin + min(patience.wall_s, max(self.limits.wall_s - self._waited_s, 0.0))
        while True:
            now = time.monotonic()
            seen_s = self._mind_answer(patience, waited_for, seen_s, now - begin)
            left_s = min(deadline - now, SLICE_S)
            descriptors = dict(self._poll.poll(left_s * 1000 if left_s > 0 else 0))
            self._drain()
            if self._socket_fd in descriptors:
                return self._received_bytes()
            if self._cage.pidfd in descriptors:
                self._gone()
            if left_s <= 0:
                self._late(waited_for, patience.wall_s, since_cpu_s=seen_s)

    def _mind_answer(
        self, patience: Patience, waited_for: str, seen_s: float, waited_s: float
    ) -> float:
        """End the run if one answer took too much CPU time; return that of its begin.

        It was last read some steps before. On one core, more than the time that went by since the
        begin cannot be this answer's.
        """
        self._look_at_limits()
        begin_s = max(seen_s, self._cpu_seen_s - waited_s)
        if self._loaded and self._cpu_seen_s - begin_s > patience.cpu_s:
            self._look_at_memory()
            self.end(verdicts.answer_limit(waited_for, patience.cpu_s))
        return begin_s

    def _received(self, kind: bytes, size: int) -> memoryview:
        """Return the frame that came if it is the answer to the present question.

        One that came before its question was asked has the number of another, or the answer to
        the question has: the next frame then ends the run.
        """
        head = messages.HEADER
        if head.size <= size <= len(self._buffer):  # the usual answer is seen at a glance
            if head.unpack_from(self._buffer) == (kind, messages.VERSION, self._sequence):
                return self._view[:size]
        elif size == 0:
            self._gone()
        data = self._view[:size]
        try:
            if size > len(self._buffer):
                raise FrameInvalid(f"The program sent a frame of {size} bytes past its runner.")
            if messages.check(data, kind + messages.FAILED, self._sequence) == messages.FAILED:
                self._failed(messages.failure(data))
        except FrameInvalid as reason:
            self.end(verdicts.misbehaved(str(reason)))
        return data

    def _received_bytes(self) -> int:
        """Return the size of the waiting frame, also if it is cut; 0 at the connection's end.

        A peer that left without reading everything is told of once, before what it sent last.
        """
        for _ in range(2):
            with contextlib.suppress(ConnectionResetError):
                return self._socket.recv_into(
                    self._buffer, 0, socket.MSG_TRUNC | socket.MSG_DONTWAIT
                )
        return 0

    def _look_around(self) -> None:
        """Take what was printed and read the clock of the box, now and then."""
        self._drain()
        self._look_at_limits()

    def _drain(self) -> None:
        """Take what the program printed; ends the run if it is too much."""
        data = b" "
        while data:
            try:
                data = os.read(self._cage.output, READ_BYTES)
            except BlockingIOError:
                return
            self._printed.feed(data)
            self._news.feed(data)
            if self._printed.total > self.limits.output_max_mib << 20 and self.outcome is None:
                self.end(verdicts.output_limit(self.limits))
        if self._cage.output >= 0 and self.outcome is None:
            self._forget_output()

    def _forget_output(self) -> None:
        """Stop looking at a pipe whose other end is closed: it would be readable for ever."""
        try:
            self._poll.unregister(self._cage.output)
        except KeyError:
            return

    def _look_at_limits(self) -> None:
        self._cpu_seen_s = self._cage.cpu_s()
        used_s = self._cpu_seen_s - self._cpu_before_s
        if self._loaded and used_s > self.limits.cpu_s:
            self._look_at_memory()
            self.end(verdicts.cpu_limit(self.limits, used_s))

    def _look_at_memory(self) -> None:
        """End the run if the kernel ended a process for memory, which itself takes CPU time."""
        if self._cage.out_of_memory():
            self.end(verdicts.memory_limit(self.limits))
        if self._cage.host_out_of_memory():
            raise SandboxBroken("the kernel ended the box for memory that the host did not have")

    def _late(self, waited_for: str, wall_s: float, *, since_cpu_s: float) -> NoReturn:
        """End the run for its wall time; the host is suspected if little CPU time was used."""
        self._look_at_limits()
        said = verdicts.wall_limit(waited_for, wall_s)
        if self._waited_s + wall_s > self.limits.wall_s:
            said, wall_s = verdicts.run_limit(self.limits), self.limits.wall_s
            since_cpu_s = self._cpu_before_s
        self.end(said, suspect_host=self._cpu_seen_s - since_cpu_s < wall_s / 2)

    def _failed(self, failure: Failure) -> NoReturn:
        """End the run for what the runner reports, seen in the light of the kernel's counters."""
        if failure.verdict is Verdict.USER_ERROR and self._cage.out_of_memory():
            failure = verdicts.memory_limit(self.limits)
        elif failure.verdict is Verdict.USER_ERROR and self._cage.out_of_processes():
            failure = verdicts.process_limit(self.limits, failure.traceback)
        self.end(failure)

    def _gone(self) -> NoReturn:
        """End the run because the process ended, or closed its connection and lives on."""
        code = self._cage.exit_code(LAST_WORDS_S)
        if code is None:
            self.end(_lives_on())
        self._look_at_memory()
        self._look_at_limits()
        self._failed(self._last_words() or verdicts.died(code))

    def _last_words(self) -> Failure | None:
        """Return the error that the program sent while we were still asking, if there is one."""
        try:
            data = self._view[: self._received_bytes()]
            *_, answered = messages.HEADER.unpack_from(data)
            messages.check(data, messages.FAILED, min(answered, self._sequence))
            return messages.failure(data)
        except (BlockingIOError, FrameInvalid, struct.error):
            return None

    def end(self, failure: Failure, *, suspect_host: bool = False) -> NoReturn:
        """Kill the box, keep what is known, raise it."""
        outcome = self._outcome(failure, suspect_host=suspect_host)
        self._cage.kill()
        self.outcome = outcome
        self._drain()
        if not self._loaded:
            raise SandboxBroken(
                f"{failure.sentence} {messages.readable(self._printed.text())}".strip()
            )
        self.outcome = self._outcome(failure, suspect_host=suspect_host)
        raise ProgramEnded(self.outcome)

    def _outcome(self, failure: Failure, *, suspect_host: bool = False) -> Outcome:
        return Outcome(
            verdict=failure.verdict,
            sentence=failure.sentence,
            traceback=failure.traceback,
            cpu_s=max(self._cage.cpu_s() - self._cpu_before_s, 0.0),
            wall_s=self._waited_s,
            memory_mib=self._cage.memory_mib(),
            output=self._printed.text(),
            output_dropped=self._printed.dropped,
            suspect_host=suspect_host,
        )


def _lives_on() -> Failure:
    return verdicts.misbehaved("The program closed its connection to the simulator and lived on.")
