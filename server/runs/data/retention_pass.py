"""Retention when an admin asks for it: at once, over all runs, by the maintenance of a worker.

By itself the maintenance looks at one folder of runs after the other, which takes hours where there
are many. Each step is short, since the maintenance has more to do.
"""

import time
from collections import deque

from sqlalchemy import func, select, update
from sqlalchemy.orm import Session

from seamark.server.accounts import audit
from seamark.server.accounts.audit import SERVICE, AuditAction
from seamark.server.database import counters
from seamark.server.database.engine import Database
from seamark.server.database.queue_tables import Counter
from seamark.server.database.tables import Run
from seamark.server.runs.data import disk_usage, retention
from seamark.server.settings import Settings
from seamark.server.storage import storage

REQUESTED_AT = "retention_requested"
FOLDERS_PER_STEP = 20


def request(session: Session) -> None:
    """Ask for a pass; the maintenance of a worker begins with it within seconds."""
    counters.store(session, REQUESTED_AT, time.time())


def requested_at(session: Session) -> float:
    """Return since when a pass has been asked for that has not begun; 0 without one."""
    return counters.value(session, REQUESTED_AT)


class RetentionPass:
    """Carries out the passes that are asked for, step by step."""

    def __init__(self, database: Database, settings: Settings) -> None:
        self._database, self._settings = database, settings
        self._folders: deque[int] | None = None  # that are left; None: nothing to do
        self._runs = self._bytes = 0

    def step(self) -> None:
        """Begin a pass that is asked for, or go on with one."""
        if storage.is_away(self._settings):
            return
        if self._folders is None:
            if self._take_request():
                self._folders = deque(retention.folders(self._database))
                self._runs = self._bytes = 0
        elif not self._delete_some():
            self._end()

    def _take_request(self) -> bool:
        asked = (Counter.name == REQUESTED_AT, Counter.value > 0)
        with self._database.writing() as session:
            taken = update(Counter).where(*asked).values(value=0.0).returning(Counter.name)
            return session.scalar(taken) is not None

    def _delete_some(self) -> bool:
        """Delete the data of at most a batch of runs; False if there is nothing left to look at."""
        for _ in range(FOLDERS_PER_STEP):
            if not self._folders:
                return self._count(retention.to_trim(self._database, self._settings)) > 0
            if self._count(retention.expired(self._database, self._settings, self._folders[0])):
                return True
            self._folders.popleft()
        return True

    def _count(self, run_ids: list[int]) -> int:
        """Delete the data of runs and add up what that frees; return of how many."""
        if not run_ids:
            return 0
        with self._database.reading() as session:
            size = session.scalar(select(func.sum(Run.data_bytes)).where(Run.id.in_(run_ids)))
        deleted = retention.delete(self._database, self._settings, run_ids)
        self._runs += len(deleted)
        self._bytes += int(size or 0)
        return len(deleted)

    def _end(self) -> None:
        detail = {"runs": self._runs, "bytes": self._bytes}
        with self._database.writing() as session:
            audit.record(session, SERVICE, AuditAction.RETENTION_ENDED, "", detail)
        disk_usage.measure(self._database, self._settings)
        self._folders = None
