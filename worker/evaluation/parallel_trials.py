"""The trials of one run as processes side by side, heard in the order of the trials.

Each trial is a fork of this process, pinned to a core together with its box. What it tells passes
through at once if it is the first trial that has not ended; what the later ones tell is kept until
their turn. So whoever listens cannot see how many processes there were.
"""

import os
import pickle
import select
import signal
import socket
import sys
import traceback
from collections import deque
from collections.abc import Callable, Iterator
from typing import NoReturn

import numpy as np

from seamark.sandbox.outcome import SandboxBroken
from seamark.sandbox.pool import Loan
from seamark.sim.recording.telemetry import WIDTH
from seamark.worker.evaluation.box_supply import Supply
from seamark.worker.evaluation.cores import Cores
from seamark.worker.evaluation.trial import TrialEnd, TrialListener
from seamark.worker.ipc import messages
from seamark.worker.ipc.listener import Telling
from seamark.worker.ipc.messages import Frame, Kind, Reader
from seamark.worker.ipc.process_control import die_with_parent, pin

KEPT_MAX = 64 * 2**20  # [byte] of later trials; beyond it they wait, and no new one starts
LOOK_S = 0.25  # [s] between two looks for a core that has become free
END_WITHIN_S = 2.0  # [s] for a trial that is stopped to end its box
RunOne = Callable[[int, TrialListener], TrialEnd]


class TrialBroken(Exception):
    """The process of a trial died or failed: our failure."""


class SideBySide:
    """Runs trials in processes of their own; `run_one` is called in the forks."""

    def __init__(
        self,
        run_one: RunOne,
        cores: Cores,
        count: int,
        *,
        kept_max: int = KEPT_MAX,
        supply: Supply | None = None,
    ) -> None:
        self._run_one = run_one
        self._supply = supply
        self._kept_max = kept_max
        self._cores = cores
        self._count = count
        self._next = 0
        self._hands: dict[int, Hand] = {}  # by trial, those that have not been heard to the end

    def ends(self, listener: TrialListener) -> Iterator[TrialEnd]:
        """Yield how each trial ended, in order, after `listener` has heard all of it.

        Whoever closes the generator early stops the trials that still run.

        Raises
        ------
        TrialBroken, SandboxBroken
            A trial's process died or failed; its box failed.
        """
        try:
            for trial in range(self._count):
                yield self._heard(trial, listener)
                self._hands.pop(trial).close()
        finally:
            self._stop()

    def _heard(self, trial: int, listener: TrialListener) -> TrialEnd:
        """Pass on what a trial tells until its end, and mind the others meanwhile."""
        while True:
            self._start_more()
            hand = self._hands[trial]
            while (frame := hand.next_frame()) is not None:
                if frame.kind is Kind.RESULT:
                    return _result(frame)
                _pass(frame, listener)
            self._listen(trial)

    def _start_more(self) -> None:
        """Start trials in their order while there are free cores and room for what they tell."""
        first = self._next
        while self._next < self._count and self._kept_bytes() <= self._kept_max // 2:
            core = self._cores.take()
            if core is None:
                break
            loan = self._supply.lend() if self._supply else None
            self._hands[self._next] = Hand(self._run_one, self._next, core, loan)
            self._next += 1
        if self._supply and first < self._next < self._count:
            self._supply.provide(self._count - self._next)

    def _kept_bytes(self) -> int:
        return sum(hand.kept_bytes for hand in self._hands.values())

    def _listen(self, first: int) -> None:
        """Take what the trials tell; the later ones have to wait while there is no room."""
        full = self._kept_bytes() > self._kept_max
        heard = {
            hand.channel: hand
            for trial, hand in self._hands.items()
            if not hand.ended and (trial == first or not full)
        }
        ready, _, _ = select.select(list(heard), [], [], LOOK_S)
        for channel in ready:
            hand = heard[channel]
            hand.take()
            if hand.ended:
                self._cores.give_back(hand.core)
                if hand.failed:  # as in a run of one after the other: nothing comes after it
                    self._count = min(self._count, hand.trial + 1)

    def _stop(self) -> None:
        for hand in self._hands.values():
            hand.ask_to_stop()
        for hand in self._hands.values():
            hand.close()
        self._hands.clear()


class Hand:
    """One trial in a process of its own."""

    def __init__(self, run_one: RunOne, trial: int, core: int, loan: Loan | None) -> None:
        self.trial, self.core = trial, core
        self._loan = loan
        self._kept: deque[Frame] = deque()
        self.kept_bytes = 0
        self.ended = self.failed = False
        self.channel, childs = socket.socketpair(socket.AF_UNIX, socket.SOCK_STREAM)
        parent = os.getpid()
        self._pid = os.fork()
        if self._pid == 0:
            self.channel.close()
            _live(run_one, trial, core, childs, parent, loan)
        if loan:
            loan.leave()
        childs.close()
        self._reader = Reader(self.channel)
        self._pidfd = os.pidfd_open(self._pid)

    def take(self) -> None:
        """Keep what has come; raises TrialBroken if the process died before its end."""
        for frame in self._reader.read(0.0):
            if frame.kind is Kind.ERROR:
                raise TrialBroken(frame.payload.decode("utf-8", "replace"))
            if frame.kind is Kind.RESULT:
                self.ended = True
                self.failed = _result(frame).result is None
            self._kept.append(frame)
            self.kept_bytes += len(frame.payload)
        if self._reader.ended and not self.ended:
            raise TrialBroken(f"the process of trial {self.trial} died: {self._how()}")

    def _how(self) -> str:
        """Return how the process ended, whose end of the connection is closed; `close` reaps it."""
        if not select.select([self._pidfd], [], [], END_WITHIN_S)[0]:
            return "it closed its connection and lives on"
        end = os.waitid(os.P_PIDFD, self._pidfd, os.WEXITED | os.WNOWAIT)
        if end is None or end.si_code == os.CLD_EXITED:
            return f"exit code {end.si_status if end else 'unknown'}"
        return signal.Signals(end.si_status).name

    def next_frame(self) -> Frame | None:
        """Return the first message that has not been returned; None if there is none yet."""
        if not self._kept:
            return None
        frame = self._kept.popleft()
        self.kept_bytes -= len(frame.payload)
        return frame

    def ask_to_stop(self) -> None:
        """Tell the process to end its box and itself."""
        if self._pidfd >= 0 and not self.ended:
            signal.pidfd_send_signal(self._pidfd, signal.SIGTERM)

    def close(self) -> None:
        """Wait for the process's end, and bring it about if it does not come."""
        if self._pidfd < 0:
            return
        if not select.select([self._pidfd], [], [], END_WITHIN_S)[0]:
            signal.pidfd_send_signal(self._pidfd, signal.SIGKILL)
        os.waitpid(self._pid, 0)
        os.close(self._pidfd)
        self._pidfd = -1
        self.channel.close()
        if self._loan:
            self._loan.close()


def _pass(frame: Frame, listener: TrialListener) -> None:
    match frame.kind:
        case Kind.ROWS:
            listener.rows(np.frombuffer(frame.payload, "<f8").reshape(-1, WIDTH))
        case Kind.LOG:
            listener.log(frame.payload)
        case Kind.CUT:
            said = frame.json()
            listener.cut(said["trial"], said["why"])


def _result(frame: Frame) -> TrialEnd:
    """Return how a trial ended; raises SandboxBroken if its box failed."""
    # From a fork of this very process, which could as well write into our memory.
    end: TrialEnd | SandboxBroken = pickle.loads(frame.payload)  # noqa: S301
    if isinstance(end, SandboxBroken):
        raise end
    return end


def _live(
    run_one: RunOne,
    trial: int,
    core: int,
    channel: socket.socket,
    parent: int,
    loan: Loan | None,
) -> NoReturn:
    """Be the process of a trial: never returns."""
    status = 70  # EX_SOFTWARE
    try:
        for number in (signal.SIGTERM, signal.SIGINT):
            signal.signal(number, _leave)
        die_with_parent(parent)
        _run(run_one, trial, core, channel, loan)
        status = 0
    except SystemExit:
        status = 0
    finally:  # whatever happened, the code of the parent must not run a second time in here
        if status:
            traceback.print_exc()
            sys.stderr.flush()
        os._exit(status)


def _run(run_one: RunOne, trial: int, core: int, channel: socket.socket, loan: Loan | None) -> None:
    end: TrialEnd | SandboxBroken
    try:
        pin(core)
        if loan:
            loan.use()
        end = run_one(trial, Telling(channel))
    except SandboxBroken as broken:
        end = broken
    finally:
        failure = sys.exc_info()[0]
        if failure is not None and failure is not SystemExit:
            messages.send(channel, Kind.ERROR, traceback.format_exc().encode())
    messages.send(channel, Kind.RESULT, pickle.dumps(end))


def _leave(_number: int, _frame: object) -> NoReturn:
    """End the trial in order, with its box."""
    raise SystemExit
