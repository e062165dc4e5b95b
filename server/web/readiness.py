"""Whether a run that is submitted now would be evaluated; answered in time, whatever hangs.

Each part is asked in a thread of its own. One that does not answer keeps its thread, and the next
call waits for the same one, so that a part that hangs for a day costs one thread.
"""

import threading
import time
from collections.abc import Callable, Mapping

from redis import Redis
from redis.exceptions import RedisError
from sqlalchemy import text
from sqlalchemy.exc import SQLAlchemyError

from seamark.server.database.engine import Database
from seamark.server.messaging import workers
from seamark.server.monitoring.outages import Outage
from seamark.server.runs.queue import queue
from seamark.server.settings import Settings
from seamark.server.storage import storage

ANSWER_S = 1.5  # that the parts have together
IDLE_S = 60.0  # that runs may wait beside free slots: recovery sends missing tickets every 10 s
OK, _UNKNOWN, _SILENT = "ok", "unknown", "does not answer"


class Readiness:
    """What one web process knows of the parts of the service."""

    def __init__(
        self,
        settings: Settings,
        database: Database,
        redis: Redis,
        outage: Outage,
        *,
        idle_s: float = IDLE_S,
    ) -> None:
        self._settings, self._database, self._redis = settings, database, redis
        self._outage = outage
        self._watch = _ClaimWatch(idle_s)
        self._parts = {
            "database": _Part(self._ask_database),
            "broker": _Part(self._ask_broker),
            "storage": _Part(lambda: {"storage": storage.refusal(settings) or OK}),
        }

    def checks(self) -> dict[str, str]:
        """Return what is wrong with each part, or "ok"."""
        until = time.monotonic() + ANSWER_S
        asked = {name: part.ask() for name, part in self._parts.items()}
        checks = {"worker": _UNKNOWN, "queue": _UNKNOWN}
        for name, answer in asked.items():
            checks |= answer.within(until) or {name: _SILENT}
        return checks

    def _ask_database(self) -> dict[str, str]:
        try:
            with self._database.reading() as session:
                session.execute(text("SELECT 1"))
                alive = workers.alive_count(session)
                idle_s = self._watch.idle_s(queue.neglected(session, self._settings))
        except SQLAlchemyError as error:
            return {"database": type(error).__name__}
        self._outage.over()
        neglect = "" if idle_s is None else f"slots are free, but no run started for {idle_s:.0f} s"
        return {
            "database": OK,
            "worker": OK if alive else "no worker is alive",
            "queue": neglect or OK,
        }

    def _ask_broker(self) -> dict[str, str]:
        try:
            self._redis.ping()
        except RedisError as error:
            return {"broker": type(error).__name__}
        return {"broker": OK}


class _ClaimWatch:
    """Sees from look to look whether runs wait although workers could start them."""

    def __init__(self, patience_s: float) -> None:
        self._patience_s = patience_s
        self._last_start: float | None = None
        self._since = 0.0  # monotonic

    def idle_s(self, last_start: float | None) -> float | None:
        """Return for how long no run was claimed; None while that is as it should be.

        Parameters
        ----------
        last_start
            When the last run started, if one could start now; None if none could.
        """
        now = time.monotonic()
        if last_start is None or last_start != self._last_start:
            self._last_start, self._since = last_start, now
            return None
        idle_s = now - self._since
        return idle_s if idle_s >= self._patience_s else None


class _Answer:
    """What a part says, as soon as it does."""

    def __init__(self) -> None:
        self._there = threading.Event()
        self._details: Mapping[str, str] | None = None

    def give(self, details: Mapping[str, str] | None) -> None:
        self._details = details
        self._there.set()

    def within(self, until: float) -> Mapping[str, str] | None:
        """Return it, or None if it does not come until then."""
        self._there.wait(max(until - time.monotonic(), 0.0))
        return self._details


class _Part:
    """Something that is asked by one thread at a time."""

    def __init__(self, question: Callable[[], Mapping[str, str]]) -> None:
        self._question = question
        self._lock = threading.Lock()
        self._pending: _Answer | None = None

    def ask(self) -> _Answer:
        with self._lock:
            if self._pending is None:
                self._pending = _Answer()
                # A daemon: a part that hangs does not keep the process from ending.
                threading.Thread(target=self._answer, args=(self._pending,), daemon=True).start()
            return self._pending

    def _answer(self, answer: _Answer) -> None:
        details: Mapping[str, str] | None = None
        try:
            details = self._question()
        finally:
            with self._lock:
                self._pending = None
            answer.give(details)
