"""The trials of one run in parallel processes; the listener receives them in order.

Each trial is a fork of this process, pinned to one core together with its box. The messages of the
first trial that has not ended are forwarded at once; those of the later trials are buffered until
their turn. So a listener cannot tell how many processes there were, but by how many rows it gets
at once.
"""

import os
import select
import signal
import socket
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from typing import NoReturn

from seamark.sandbox.outcome import SandboxBroken
from seamark.sandbox.pool import BoxLease, Pool, stock_key
from seamark.worker.evaluation.cores import Cores
from seamark.worker.ipc import messages
from seamark.worker.ipc.listener import GatheringSender, Listener, deliver
from seamark.worker.ipc.messages import BoxFailed, Crashed, Message, Reader, TrialReport
from seamark.worker.ipc.outcomes import TrialOutcome
from seamark.worker.ipc.process_control import die_with_parent, pin, run_forked

# [byte] of later trials; when they have more, they must wait, and no new trial starts.
BUFFER_MAX = 64 * 2**20
POLL_S = 0.25  # [s] between two attempts to acquire a core
STOP_WITHIN_S = 2.0  # [s] for a trial that is stopped to end its box
RunTrial = Callable[[int, Listener], TrialOutcome]


class TrialBroken(Exception):
    """The process of a trial died or failed: a failure of the platform."""


class WarmBoxes:
    """The boxes that one run takes from the pool of its process, and leases to its trials.

    While trials run, the boxes for the next ones start: those of the first program's language.
    """

    def __init__(self, pool: Pool, languages: Sequence[str], waiting_max: int) -> None:
        """Say what programs each trial has, and for how many trials boxes may wait."""
        self._pool = pool
        self._language, self._per_trial = first_language(languages)
        self._waiting_max = waiting_max

    def lease(self) -> BoxLease:
        """Return boxes for the next trial, as far as they wait: the trial starts the others."""
        return self._pool.lease(self._language, self._per_trial)

    def start(self, trials: int) -> None:
        """Start the boxes that are missing for so many trials to come."""
        self._pool.stock(self._language, self._per_trial * min(self._waiting_max, trials))
        self._pool.refill()


def first_language(languages: Sequence[str]) -> tuple[str, int]:
    """Return the language of the first program, and how many programs have boxes like its box."""
    alike = [each for each in languages if stock_key(each) == stock_key(languages[0])]
    return languages[0], len(alike)


class ParallelTrials:
    """Runs trials in processes of their own; `run_trial` is called in the forks."""

    def __init__(
        self,
        run_trial: RunTrial,
        cores: Cores,
        count: int,
        *,
        buffer_max: int = BUFFER_MAX,
        warm_boxes: WarmBoxes | None = None,
    ) -> None:
        self._run_trial = run_trial
        self._warm_boxes = warm_boxes
        self._buffer_max = buffer_max
        self._cores = cores
        self._count = count
        self._next = 0
        self._processes: dict[int, TrialProcess] = {}  # by trial, until all is forwarded

    def outcomes(self, listener: Listener) -> Iterator[TrialOutcome]:
        """Yield how each trial ended, in order, after `listener` has received all of it.

        Closing the generator early stops the trials that are still running.

        Raises
        ------
        TrialBroken, SandboxBroken
            A trial's process died or failed; its box failed.
        """
        try:
            for trial in range(self._count):
                yield self._forward(trial, listener)
                self._processes.pop(trial).close()
        finally:
            self._stop()

    def _forward(self, trial: int, listener: Listener) -> TrialOutcome:
        """Forward the messages of a trial until its end, and attend to the others meanwhile."""
        while True:
            self._start_more()
            process = self._processes[trial]
            while (message := process.next_message()) is not None:
                match message:
                    case TrialReport():
                        return message.outcome()
                    case BoxFailed(reason):
                        raise SandboxBroken(reason)
                    case Crashed(text):
                        raise TrialBroken(text)
                    case _:
                        deliver(message, listener)
            self._receive(trial)

    def _start_more(self) -> None:
        """Start trials in their order while there are free cores and room in the buffer."""
        first = self._next
        while self._next < self._count and self._buffered_bytes() <= self._buffer_max // 2:
            core = self._cores.acquire()
            if core is None:
                break
            box = self._warm_boxes.lease() if self._warm_boxes else None
            self._processes[self._next] = TrialProcess(self._run_trial, self._next, core, box)
            self._next += 1
        if self._warm_boxes and first < self._next < self._count:
            self._warm_boxes.start(self._count - self._next)

    def _buffered_bytes(self) -> int:
        return sum(process.buffered_bytes for process in self._processes.values())

    def _receive(self, first: int) -> None:
        """Read from the trials; the later ones have to wait while the buffer is full."""
        full = self._buffered_bytes() > self._buffer_max
        senders = {
            process.channel: process
            for trial, process in self._processes.items()
            if not process.ended and (trial == first or not full)
        }
        ready, _, _ = select.select(list(senders), [], [], POLL_S)
        for channel in ready:
            process = senders[channel]
            process.receive()
            if process.ended:
                self._cores.release(process.core)
                if process.failed:  # as in a run of one after the other: no trial follows it
                    self._count = min(self._count, process.trial + 1)

    def _stop(self) -> None:
        for process in self._processes.values():
            process.terminate()
        for process in self._processes.values():
            process.close()
        self._processes.clear()


class TrialProcess:
    """One trial in a process of its own."""

    def __init__(self, run_trial: RunTrial, trial: int, core: int, box: BoxLease | None) -> None:
        self.trial, self.core = trial, core
        self._box = box
        self._buffer: deque[Message] = deque()
        self.buffered_bytes = 0
        self.ended = self.failed = False
        self.channel, childs = socket.socketpair(socket.AF_UNIX, socket.SOCK_STREAM)
        parent = os.getpid()
        self._pid = os.fork()
        if self._pid == 0:
            self.channel.close()
            _child(run_trial, trial, core, childs, parent, box)
        if box:
            box.hand_over()
        childs.close()
        self._reader = Reader(self.channel)
        self._pidfd = os.pidfd_open(self._pid)

    def receive(self) -> None:
        """Buffer the messages that came, and Crashed if the process died before its end."""
        for message in self._reader.read(0.0):
            self._put(message)
        if self._reader.closed and not self.ended:
            self._put(Crashed(f"the process of trial {self.trial} died: {self._exit_reason()}"))

    def _put(self, message: Message) -> None:
        match message:
            case TrialReport():
                self.ended = True
                self.failed = message.outcome().result is None
            case BoxFailed() | Crashed():
                self.ended = self.failed = True
        self._buffer.append(message)
        self.buffered_bytes += messages.size(message)

    def _exit_reason(self) -> str:
        """Return how the process ended, which has closed its connection; `close` reaps it."""
        if not select.select([self._pidfd], [], [], STOP_WITHIN_S)[0]:
            return "it closed its connection and is still running"
        end = os.waitid(os.P_PIDFD, self._pidfd, os.WEXITED | os.WNOWAIT)
        if end is None or end.si_code == os.CLD_EXITED:
            return f"exit code {end.si_status if end else 'unknown'}"
        return signal.Signals(end.si_status).name

    def next_message(self) -> Message | None:
        """Remove and return the oldest message in the buffer; None if it is empty."""
        if not self._buffer:
            return None
        message = self._buffer.popleft()
        self.buffered_bytes -= messages.size(message)
        return message

    def terminate(self) -> None:
        """Tell the process to end its box and itself."""
        if self._pidfd >= 0 and not self.ended:
            signal.pidfd_send_signal(self._pidfd, signal.SIGTERM)

    def close(self) -> None:
        """Wait for the process to end, and kill it if it does not."""
        if self._pidfd < 0:
            return
        if not select.select([self._pidfd], [], [], STOP_WITHIN_S)[0]:
            signal.pidfd_send_signal(self._pidfd, signal.SIGKILL)
        os.waitpid(self._pid, 0)
        os.close(self._pidfd)
        self._pidfd = -1
        self.channel.close()
        if self._box:
            self._box.close()


def _child(
    run_trial: RunTrial,
    trial: int,
    core: int,
    channel: socket.socket,
    parent: int,
    box: BoxLease | None,
) -> NoReturn:
    """Be the process of a trial: never returns."""

    def run() -> None:
        for number in (signal.SIGTERM, signal.SIGINT):
            signal.signal(number, _exit)
        die_with_parent(parent)
        pin(core)
        if box:
            box.take_over()
        messages.send(channel, _result(run_trial, trial, channel))

    run_forked(run, lambda text: messages.send(channel, Crashed(text)))


def _result(run_trial: RunTrial, trial: int, channel: socket.socket) -> Message:
    try:
        with GatheringSender(channel) as sender:
            outcome = run_trial(trial, sender)
        return TrialReport.of(outcome)
    except SandboxBroken as broken:
        return BoxFailed(str(broken))


def _exit(_number: int, _frame: object) -> NoReturn:
    """Leave the trial by an exception, so that its box is closed."""
    raise SystemExit
