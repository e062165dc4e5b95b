"""Request and answer with the processes of one box, while all of its limits are enforced."""

import contextlib
import os
import select
import socket
import struct
import time
from typing import NoReturn

from seamark.sandbox import verdicts
from seamark.sandbox.isolation.process_tree import ProcessTree
from seamark.sandbox.languages.inside.wire import HEADER, MAX_MESSAGE_BYTES, VERSION
from seamark.sandbox.limits import MAX_STEP_WALL_S, AnswerLimit, Limits
from seamark.sandbox.outcome import Failure, Outcome, ProgramEnded, SandboxBroken, Verdict
from seamark.sandbox.protocol import messages
from seamark.sandbox.protocol.head_tail import HeadTail
from seamark.sandbox.protocol.messages import MessageInvalid
from seamark.sandbox.protocol.starvation import Starvation

POLL_S = 0.25  # [s] the longest wait after which all limits are checked again
EXIT_WITHIN_S = 2.0  # [s] for the process to exit after its connection ended
LOCATE_WITHIN_S = 1.0  # [s] for a runner to say where its program is
READ_BYTES = 65536  # [B] the capacity of a pipe
# Plain numbers: to convert the members of an enumeration costs time at every request.
_AT_ONCE, _WHOLE_SIZE = int(socket.MSG_DONTWAIT), int(socket.MSG_TRUNC)


class ProtocolSession:
    """The simulator's end of the protocol. Whatever the program does, it ends with an outcome."""

    def __init__(self, tree: ProcessTree, limits: Limits) -> None:
        self.limits = limits
        self.outcome: Outcome | None = None
        self._tree = tree
        self._socket = tree.socket
        self._poll = select.poll()
        for descriptor in (self._socket.fileno(), tree.pidfd, tree.output):
            self._poll.register(descriptor, select.POLLIN)
        self._socket_fd = self._socket.fileno()
        self._send, self._receive_into = self._socket.send, self._socket.recv_into
        self._check_every_s = tree.cpu_every_s
        self._check_at_s = 0.0
        self._buffer = bytearray(MAX_MESSAGE_BYTES)
        self._view = memoryview(self._buffer)
        self._printed = HeadTail(limits.output_kib << 10)
        self._unread = HeadTail(limits.output_kib << 10)  # since the last `take_output`
        self._sequence = 0
        self._loaded = False
        self._name = self._shown_name = ""
        self._waited_s = self._cpu_before_s = self._cpu_seen_s = 0.0

    def begin(self, name: str = "", shown_name: str = "") -> None:
        """The program arrives: time and failures are its own from now on.

        Parameters
        ----------
        name, shown_name
            What the box calls its file, and what its owner does: texts for the owner say that.
        """
        self._loaded = True
        self._name, self._shown_name = name, shown_name or name
        self._cpu_before_s = self._cpu_seen_s = self._tree.cpu_s()
        self._waited_s = 0.0

    def finish(self) -> Outcome:
        """Ask the program to quit; its own process must answer and exit with 0."""
        self.ask(messages.QUIT)
        self._check_cpu()
        self._tree.memory_mib()  # without a control group it is read from the living process
        self.answer(messages.BYE, self.limits.step_limit, "The end of the program")
        code = self._tree.exit_code(EXIT_WITHIN_S)
        if code != 0:
            self.end(verdicts.died(code) if code else verdicts.still_running())
        self._drain()
        self.outcome = self._outcome(Failure(Verdict.OK, "The program ended well."))
        return self.outcome

    def take_output(self) -> bytes:
        """Return what was printed since the last call: head and tail if it is long."""
        self._drain()
        return self.last_output()

    def last_output(self) -> bytes:
        """Return what was printed and already read since the last call."""
        text = self._unread.text()
        self._unread = HeadTail(self.limits.output_kib << 10)
        return text

    def ask(self, message_type: bytes, body: bytes | memoryview = b"") -> None:
        """Send one message."""
        if self.outcome is not None:
            raise ProgramEnded(self.outcome)
        self._sequence += 1
        message = messages.message(message_type, self._sequence, body)
        try:
            self._send(message, _AT_ONCE)
        except BlockingIOError:
            self._send_slowly(message)
        except (BrokenPipeError, ConnectionResetError):
            self._disconnected()

    def _send_slowly(self, message: bytes) -> None:
        """Send to a program that has not read the messages before, as soon as there is room."""
        writable = select.poll()
        writable.register(self._socket_fd, select.POLLOUT)
        begin = time.monotonic()
        while True:
            writable.poll(POLL_S * 1000)
            self._check_box()
            try:
                self._socket.send(message, socket.MSG_DONTWAIT)
                return
            except BlockingIOError:
                if time.monotonic() - begin > self.limits.start_wall_s:
                    wall_s = self.limits.start_wall_s
                    self._timed_out("The program", wall_s, since_cpu_s=self._cpu_seen_s)
            except (BrokenPipeError, ConnectionResetError):
                self._disconnected()

    def answer(self, message_type: bytes, limit: AnswerLimit, waited_for: str) -> memoryview:
        """Return the program's answer; read its output and enforce all limits meanwhile.

        Most answers come at once: a single system call waits for them for a short time. Only while
        an answer takes longer is everything else watched too.
        """
        begin = time.monotonic()
        try:
            size = self._receive_into(self._buffer, 0, _WHOLE_SIZE)
        except BlockingIOError:
            size = self._wait(limit, waited_for, begin)
        except ConnectionResetError:
            size = self._received_bytes()
        now = time.monotonic()
        self._waited_s += now - begin
        if now > self._check_at_s:
            self._check_at_s = now + self._check_every_s
            self._check_box()
            if self._waited_s > self.limits.wall_s:
                self._timed_out(waited_for, 0.0, since_cpu_s=self._cpu_before_s)
        return self._received(message_type, size)

    def _wait(self, limit: AnswerLimit, waited_for: str, begin: float) -> int:
        """Return the size of a slow answer; end the run if it exceeds its limit.

        Time in which the host kept the program from running does not count.
        """
        seen_s = self._cpu_seen_s
        deadline = begin + min(limit.wall_s, max(self.limits.wall_s - self._waited_s, 0.0))
        starvation = Starvation(self._tree)
        while True:
            now = time.monotonic()
            seen_s = self._check_answer_cpu(limit, waited_for, seen_s, now - begin)
            left_s = deadline - now
            if left_s <= 0:
                left_s = _prolonged_s(left_s, starvation, now - begin)
            descriptors = dict(self._poll.poll(min(max(left_s, 0.0), POLL_S) * 1000))
            self._drain()
            if self._socket_fd in descriptors:
                self._waited_s -= starvation.so_far_s()
                return self._received_bytes()
            if self._tree.pidfd in descriptors:
                self._disconnected()
            if left_s <= 0:
                self._timed_out(waited_for, limit.wall_s, since_cpu_s=seen_s)

    def _check_answer_cpu(
        self, limit: AnswerLimit, waited_for: str, seen_s: float, waited_s: float
    ) -> float:
        """End the run if one answer used too much CPU time; return the CPU time at its begin.

        The CPU time was last read some steps before. On one core, no more than the time that has
        passed since the request can belong to this answer.
        """
        self._check_cpu()
        begin_s = max(seen_s, self._cpu_seen_s - waited_s)
        if self._loaded and self._cpu_seen_s - begin_s > limit.cpu_s:
            self._check_memory()
            self.end(self._located(verdicts.answer_cpu_limit(waited_for, limit.cpu_s)))
        return begin_s

    def _received(self, message_type: bytes, size: int) -> memoryview:
        """Return the received message if it answers the pending request.

        A message that was sent before its request carries another sequence number, or the real
        answer does: then the next message ends the run.
        """
        if HEADER.size <= size <= len(self._buffer):  # the usual answer: one comparison
            if HEADER.unpack_from(self._buffer) == (message_type, VERSION, self._sequence):
                return self._view[:size]
        elif size == 0:
            self._disconnected()
        data = self._view[:size]
        try:
            if size > len(self._buffer):
                raise MessageInvalid(f"The program bypassed its runner and sent {size} bytes.")
            answered = messages.check(data, message_type + messages.FAILED, self._sequence)
            if answered == messages.FAILED:
                self._failed(messages.failure(data))
        except MessageInvalid as reason:
            self.end(verdicts.protocol_error(str(reason)))
        return data

    def _received_bytes(self) -> int:
        """Return the size of the waiting message, before truncation; 0 at the end of connection.

        If the peer closed with unread data, the kernel reports that once, before the peer's last
        message.
        """
        for _ in range(2):
            with contextlib.suppress(ConnectionResetError):
                return self._socket.recv_into(
                    self._buffer, 0, socket.MSG_TRUNC | socket.MSG_DONTWAIT
                )
        return 0

    def _check_box(self) -> None:
        """Read the output and check the CPU time."""
        self._drain()
        self._check_cpu()

    def _drain(self) -> None:
        """Read what the program printed; end the run if it is too much."""
        data = b" "
        while data:
            try:
                data = os.read(self._tree.output, READ_BYTES)
            except BlockingIOError:
                return
            self._printed.feed(data)
            self._unread.feed(data)
            if self._printed.total > self.limits.output_max_mib << 20 and self.outcome is None:
                self.end(verdicts.output_limit(self.limits))
        if self._tree.output >= 0 and self.outcome is None:
            self._unregister_output()

    def _unregister_output(self) -> None:
        """Stop polling a pipe whose other end is closed: it would always be readable."""
        try:
            self._poll.unregister(self._tree.output)
        except KeyError:
            return

    def _check_cpu(self) -> None:
        self._cpu_seen_s = self._tree.cpu_s()
        used_s = self._cpu_seen_s - self._cpu_before_s
        if self._loaded and used_s > self.limits.cpu_s:
            self._check_memory()
            self.end(self._located(verdicts.cpu_limit(self.limits, used_s)))

    def _check_memory(self) -> None:
        """End the run if the kernel killed a process for memory, which takes CPU time itself."""
        if self._tree.out_of_memory():
            self.end(verdicts.memory_limit(self.limits))
        if self._tree.host_out_of_memory():
            raise SandboxBroken("the kernel killed the box because the host was out of memory")

    def _timed_out(self, waited_for: str, wall_s: float, *, since_cpu_s: float) -> NoReturn:
        """End the run for its wall time; the host is suspected if little CPU time was used."""
        self._check_cpu()
        failure = verdicts.answer_wall_limit(waited_for, wall_s)
        if self._waited_s + wall_s > self.limits.wall_s:
            failure, wall_s = verdicts.wall_limit(self.limits), self.limits.wall_s
            since_cpu_s = self._cpu_before_s
        suspect_host = self._cpu_seen_s - since_cpu_s < wall_s / 2
        self.end(self._located(failure), suspect_host=suspect_host)

    def _located(self, failure: Failure) -> Failure:
        """Return the failure of a program that does not return, with its line if that is known.

        The runner of a language that cannot tell ends at the signal, or goes on until it is killed.
        """
        if not self._loaded:
            return failure
        self._tree.interrupt()
        answered = select.poll()
        answered.register(self._socket_fd, select.POLLIN)
        answered.poll(LOCATE_WITHIN_S * 1000)
        where = self._pending_failure()
        if where is None:
            return failure
        return Failure(failure.verdict, f"{failure.sentence} {where.sentence}", where.traceback)

    def _failed(self, failure: Failure) -> NoReturn:
        """End the run with the failure that the runner reports, unless the kernel knows better."""
        if failure.verdict is Verdict.USER_ERROR and self._tree.out_of_memory():
            failure = verdicts.memory_limit(self.limits)
        elif failure.verdict is Verdict.USER_ERROR and self._tree.out_of_processes():
            failure = verdicts.process_limit(self.limits, failure.traceback)
        self.end(failure)

    def _disconnected(self) -> NoReturn:
        """End the run because the process exited, or closed its connection and keeps running."""
        code = self._tree.exit_code(EXIT_WITHIN_S)
        if code is None:
            self.end(verdicts.still_running())
        self._check_memory()
        self._check_cpu()
        self._failed(self._pending_failure() or verdicts.died(code))

    def _pending_failure(self) -> Failure | None:
        """Return the error that the program sent before it read our request, if there is one."""
        try:
            data = self._view[: self._received_bytes()]
            *_, answered = HEADER.unpack_from(data)
            messages.check(data, messages.FAILED, min(answered, self._sequence))
            return messages.failure(data)
        except (BlockingIOError, MessageInvalid, struct.error):
            return None

    def end(self, failure: Failure, *, suspect_host: bool = False) -> NoReturn:
        """Kill the box and raise the outcome."""
        outcome = self._outcome(failure, suspect_host=suspect_host)
        self._tree.kill()
        self.outcome = outcome
        self._drain()
        if not self._loaded:
            printed = messages.printable(self._printed.text())
            raise SandboxBroken(f"{failure.sentence} {printed}".strip())
        self.outcome = self._outcome(failure, suspect_host=suspect_host)
        raise ProgramEnded(self.outcome)

    def _outcome(self, failure: Failure, *, suspect_host: bool = False) -> Outcome:
        return Outcome(
            verdict=failure.verdict,
            sentence=self._for_owner(failure.sentence),
            traceback=self._for_owner(failure.traceback),
            cpu_s=max(self._tree.cpu_s() - self._cpu_before_s, 0.0),
            wall_s=self._waited_s,
            memory_mib=self._tree.memory_mib(),
            output=self._printed.text(),
            output_dropped=self._printed.dropped,
            suspect_host=suspect_host,
        )

    def _for_owner(self, text: str) -> str:
        named = text.replace(self._name, self._shown_name) if self._name else text
        return named[:MAX_MESSAGE_BYTES]


def _prolonged_s(left_s: float, starvation: Starvation, waited_s: float) -> float:
    """Return the wall time left, with that in which the host ran other processes."""
    prolonged_s = left_s + starvation.so_far_s()
    if prolonged_s > 0 and waited_s > MAX_STEP_WALL_S:
        raise SandboxBroken(f"in {waited_s:.0f} s the host hardly ran the program")
    return prolonged_s
