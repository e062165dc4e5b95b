"""Keeps the side processes of a worker running, and reports that the worker is alive.

In a thread of Celery's main process. That process forks its pool, and a fork must not inherit a
lock that this thread holds at the moment; so no fork happens while the thread works.
"""

import os
import signal
import subprocess
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from datetime import UTC, datetime

import structlog

from seamark.server.database.engine import DATABASE_AWAY
from seamark.server.messaging.workers import RUNNING
from seamark.server.monitoring.outages import Outage
from seamark.worker.ipc.fork_server import Process
from seamark.worker.ipc.process_control import RestartBackoff, exit_reason
from seamark.worker.service.nursery import spawn

POLL_S = 0.25  # [s] between two checks of the processes
REPORT_S = 5.0  # [s] well below seamark.server.messaging.workers.ALIVE_S
STOP_WITHIN_S = 3.0  # [s] for a side process to release what it works on
BROKEN_DEATHS = 3  # in a row; then it counts as broken even while it is running again
_log = structlog.get_logger()
_no_fork = threading.RLock()
os.register_at_fork(
    before=_no_fork.acquire, after_in_parent=_no_fork.release, after_in_child=_no_fork.release
)
ReportStates = Callable[[dict[str, str]], None]
Start = Callable[[Sequence[str]], Process]


class SideProcesses:
    """The side processes of one worker, each a Python module with arguments."""

    def __init__(
        self,
        commands: Mapping[str, Sequence[str]],
        report: ReportStates,
        *,
        leave: Callable[[], None],
        start: Start = spawn,
        report_s: float = REPORT_S,
    ) -> None:
        """Start nothing yet.

        Parameters
        ----------
        commands
            Name -> what `start` is given.
        report
            Is called with the state of each process every `report_s`, and when a state changes:
            "running", or "restarting since" with the time of the first death (ISO 8601, UTC).
        leave
            Is called once, after the last report.
        """
        self._processes = [_SideProcess(name, command, start) for name, command in commands.items()]
        self._report = report
        self._leave = leave
        self._report_s = report_s
        self._report_at = 0.0
        self._reported: dict[str, str] = {}
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._serve, name="side-processes", daemon=True)

    def start(self) -> None:
        """Start the processes and watch them from now on."""
        self._thread.start()

    def stop(self) -> None:
        """Terminate the processes soon; returns at once."""
        self._stopping.set()

    def join(self) -> None:
        """Wait until the processes have ended."""
        self._thread.join()

    def _serve(self) -> None:
        outage = Outage("database", process="worker")
        while True:
            with _no_fork:
                self._watch_on(outage)
            if self._stopping.wait(POLL_S):
                break
        for process in self._processes:
            process.terminate()
        try:
            self._leave()
        except Exception:
            _log.exception("worker_still_listed")
        for process in self._processes:
            process.wait()

    def _watch_on(self, outage: Outage) -> None:
        """Keep the processes running, whatever becomes of the report."""
        try:
            if self._watch():
                outage.over()
        except DATABASE_AWAY as error:
            outage.failed(error)
        except Exception:
            _log.exception("side_processes_failed")

    def _watch(self) -> bool:
        """Keep the processes running; return whether their states were reported."""
        for process in self._processes:
            process.keep_running()
        states = {process.name: process.state for process in self._processes}
        if states != self._reported or time.monotonic() >= self._report_at:
            # Before the call: one that fails is not repeated at once.
            self._report_at, self._reported = time.monotonic() + self._report_s, states
            self._report(states)
            return True
        return False


class _SideProcess:
    """One process that is restarted, after a back-off, when it ends."""

    def __init__(self, name: str, command: Sequence[str], start: Start) -> None:
        self.name = name
        self._command, self._start = command, start
        self._process: Process | None = None
        self._backoff = RestartBackoff()
        self._started_at = self._start_at = 0.0  # monotonic
        self._died_at = ""  # the first of the deaths in a row

    @property
    def state(self) -> str:
        if self._process is not None and self._backoff.deaths < BROKEN_DEATHS:
            return RUNNING
        return f"restarting since {self._died_at}"

    def keep_running(self) -> None:
        """Start the process if it is not running and the time has come."""
        now = time.monotonic()
        if self._process is not None and (code := self._process.poll()) is not None:
            self._note_death(code, now)
            self._process = None
        if self._process is None and now >= self._start_at:
            self._process = self._start(self._command)
            self._started_at = now
        elif self._process is not None:
            self._backoff.note_life(now - self._started_at)

    def _note_death(self, code: int, now: float) -> None:
        if not self._backoff.deaths:
            self._died_at = datetime.now(UTC).isoformat(timespec="seconds")
        wait_s = self._backoff.next_wait_s()
        self._start_at = now + wait_s
        _log.error(
            "side_process_died", process=self.name, why=exit_reason(code), restart_in_s=wait_s
        )

    def terminate(self) -> None:
        if self._process is not None:
            self._process.send_signal(signal.SIGTERM)

    def wait(self) -> None:
        """Wait for the end, and kill the process if it does not come."""
        if self._process is None:
            return
        try:
            self._process.wait(STOP_WITHIN_S)
        except subprocess.TimeoutExpired:
            self._process.send_signal(signal.SIGKILL)
            self._process.wait()
