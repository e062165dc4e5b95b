"""The lease of a claimed run: renewed while it is evaluated and stored, given back if it fails."""

import time
from collections.abc import Callable
from typing import NamedTuple, TypeVar

import structlog
from sqlalchemy.orm import Session

from seamark.server.database.engine import DATABASE_AWAY, Database
from seamark.server.runs.queue import lost_attempts
from seamark.server.runs.queue import queue as run_queue
from seamark.server.runs.queue.lost_attempts import AttemptEnd
from seamark.server.runs.queue.queue import Claim, LeaseStatus
from seamark.server.runs.record.states import RunState
from seamark.server.settings import Settings
from seamark.worker.service.live_states import LivePublisher
from seamark.worker.service.worker_process import ShuttingDown

CANCEL_POLL_S = 0.4  # [s] between two checks of whether the run was cancelled
RETRY_S = 1.0  # [s] between two attempts to reach the database
_log = structlog.get_logger()
_Result = TypeVar("_Result")


class LeaseEnded(Exception):
    """The run is no longer this worker's: it was cancelled, or claimed by another worker."""

    def __init__(self, status: LeaseStatus) -> None:
        super().__init__(status.name)
        self.status = status


class Progress(NamedTuple):
    """How far a run is."""

    done: float  # 0 to 1
    t_simulated: float  # [s] over all trials


class RunLease:
    """The lease of one claim.

    Parameters
    ----------
    progress
        Returns what a renewal reports.
    isolation
        Of the run's program; None: it has none.
    """

    def __init__(
        self,
        claim: Claim,
        database: Database,
        live: LivePublisher,
        *,
        settings: Settings,
        shutting_down: Callable[[], bool],
        progress: Callable[[], Progress],
        isolation: str | None,
    ) -> None:
        self._claim, self._database, self._live = claim, database, live
        self._settings, self._shutting_down = settings, shutting_down
        self._progress, self._isolation = progress, isolation
        self._poll_at = self._heartbeat_at = 0.0  # monotonic
        self._away = False  # the database

    def watch(self) -> None:
        """Renew the lease; raise if the run was cancelled, or this worker cannot go on with it."""
        if self._shutting_down():
            raise ShuttingDown
        try:
            self._watch(time.monotonic())
        except DATABASE_AWAY as error:
            # Go on: whether another worker has the run by then is known when the database is back.
            self._database_away(error)

    def _watch(self, now: float) -> None:
        if now >= self._heartbeat_at:
            self._poll_at = now + CANCEL_POLL_S
            _require_held(self._heartbeat())
            self._heartbeat_at = now + self._settings.heartbeat_s
            self._away = False
        elif now >= self._poll_at:
            self._poll_at = now + CANCEL_POLL_S
            with self._database.reading() as session:
                self.require_held(session)

    def keep(self) -> None:
        """Renew the lease of a run whose files are being stored; a cancelled one is stored too."""
        if self._shutting_down():
            raise ShuttingDown
        now = time.monotonic()
        if now < self._heartbeat_at:
            return
        self._heartbeat_at = now + self._settings.heartbeat_s
        try:
            if self._heartbeat() is LeaseStatus.LOST:
                raise LeaseEnded(LeaseStatus.LOST)
        except DATABASE_AWAY as error:
            self._database_away(error)

    def require_held(self, session: Session) -> None:
        """Raise LeaseEnded if the run is no longer this worker's."""
        _require_held(run_queue.poll(session, self._claim))

    def cancelled(self) -> bool:
        """Return whether the owner has cancelled the run."""
        with self._database.reading() as session:
            return run_queue.poll(session, self._claim) is LeaseStatus.CANCELLED

    def when_there(self, action: Callable[[Session], _Result]) -> _Result:
        """Do something as soon as the database is there: the evaluation took longer."""
        while True:
            try:
                with self._database.writing() as session:
                    return action(session)
            except DATABASE_AWAY as error:
                if self._shutting_down():
                    raise
                self._database_away(error)
                time.sleep(RETRY_S)

    def release(self, end: AttemptEnd) -> None:
        """Return the run to its position in the queue, or fail it for good."""
        try:
            with self._database.writing() as session:
                state = lost_attempts.release(session, self._claim, end, settings=self._settings)
        except DATABASE_AWAY as error:  # then the lease ends
            self._database_away(error)
            return
        if state is not None:
            self._live.state(state, progress=0.0, t_simulated=0.0)

    def _heartbeat(self) -> LeaseStatus:
        progress, t_simulated = self._progress()
        with self._database.writing() as session:
            status = run_queue.heartbeat(
                session,
                self._claim,
                progress=progress,
                t_simulated=t_simulated,
                isolation=self._isolation,
            )
        self._live.state(RunState.RUNNING, progress=progress, t_simulated=t_simulated)
        return status

    def _database_away(self, error: Exception) -> None:
        if not self._away:
            _log.warning("database_away", error=str(error))
        self._away = True


def _require_held(status: LeaseStatus) -> None:
    if status is not LeaseStatus.HELD:
        raise LeaseEnded(status)
