"""Replaces the worker after programs were installed: it finds out at its start what it can run.

Its successor starts first. Then the old worker claims no more runs, and ends when it has finished
those that it has. So nothing waits, and nothing is begun twice.
"""

from __future__ import annotations

import socket
import time
from collections.abc import Callable, Collection
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from seamark.embedded.installed_tools import LOOK_EVERY_S, InstalledTools

if TYPE_CHECKING:
    from collections.abc import Iterator

    from sqlalchemy.orm import Session

    from seamark.embedded.supervisor import Child, Supervisor
    from seamark.server.settings import Settings

STEP_EVERY_S = 1.0  # [s] between two looks into the database
SETTLED_S = 2 * LOOK_EVERY_S + 1.0  # [s] after the last installation; then no change is unseen


@dataclass(frozen=True, slots=True)
class _Predecessor:
    """A worker that ends as soon as it has no run."""

    child: Child
    names: frozenset[str]  # as the database lists it


class WorkerRenewal:
    """Looks for newly installed programs, and replaces the worker.

    Parameters
    ----------
    start
        Starts a worker as a child of `children` and returns it.
    installer
        File that is locked as long as programs are being installed; None: nobody installs any.
    """

    def __init__(
        self,
        settings: Settings,
        children: Supervisor,
        start: Callable[[], Child],
        *,
        say: Callable[[str], None],
        tools: InstalledTools,
        installer: Path | None = None,
        step_every_s: float = STEP_EVERY_S,
        settled_s: float = SETTLED_S,
    ) -> None:
        self._settings = settings
        self._children = children
        self._start = start
        self._say = say
        self._tools = tools
        self._installer = installer
        self._step_every_s, self._settled_s = step_every_s, settled_s
        self._worker = start()
        self._predecessor: _Predecessor | None = None
        self._replaced: frozenset[str] = frozenset()
        self._step_at = 0.0  # monotonic
        self._installed_at = time.monotonic()
        self._announcement = ExitStack()

    def __enter__(self) -> WorkerRenewal:
        """Let runs wait for what is being installed."""
        from seamark.server.storage import installation

        if self._installer is not None:
            self._announcement.enter_context(installation.announced(self._settings))
        return self

    def __exit__(self, *_: object) -> None:
        """Refuse again what no worker can run."""
        self._announcement.close()

    def step(self) -> None:
        """Do what is due; may be called several times a second."""
        if time.monotonic() < self._step_at:
            return
        self._step_at = time.monotonic() + self._step_every_s
        changed = self._tools.changed()
        if self._predecessor is not None:
            self._end_predecessor(self._predecessor)
        elif changed:
            self._replace_worker()
        elif self._installer is not None:
            self._end_announcement(self._installer)

    def _replace_worker(self) -> None:
        """Start a successor, unless the simulator is still being compiled."""
        from seamark.server.messaging import workers

        with self._writing() as session:
            listed = [worker for worker in workers.listed(session) if _is_ours(worker.name)]
            alive = [worker for worker in listed if worker.alive]
            if not alive or any(worker.preparing for worker in alive):
                return
            for worker in alive:
                workers.drain(session, worker.name)
        self._say("Programs were installed on this machine: a new worker looks at them.")
        self._replaced = frozenset(worker.name for worker in alive)
        self._predecessor = _Predecessor(self._worker, self._replaced)
        self._worker = self._start()
        self._tools.accept()

    def _end_predecessor(self, predecessor: _Predecessor) -> None:
        """Let the old worker end when it has finished its runs, then take it off the list."""
        from seamark.server.messaging import workers

        with self._writing() as session:
            if predecessor.child in self._children.children:
                if not _has_runs(session, predecessor.names):
                    self._children.retire(predecessor.child)
                return
            for name in predecessor.names:
                workers.forget(session, name)
        self._predecessor = None

    def _end_announcement(self, installer: Path) -> None:
        """Say that nothing is being installed any more when a worker has tried all of it."""
        from seamark.server.messaging import workers
        from seamark.server.storage import installation

        if installation.is_locked(installer):
            self._installed_at = time.monotonic()
            return
        if time.monotonic() < self._installed_at + self._settled_s:
            return
        with self._writing() as session:
            alive = {worker.name for worker in workers.listed(session) if worker.alive}
        if alive - self._replaced:
            self._announcement.close()
            self._installer = None

    @contextmanager
    def _writing(self) -> Iterator[Session]:
        """Give a session of a connection of its own: the supervisor forks."""
        from seamark.server.database.engine import Database

        database = Database(self._settings.database_url)
        try:
            with database.writing() as session:
                yield session
        finally:
            database.close()


def _is_ours(worker: str) -> bool:
    """Return whether a worker runs on this machine."""
    return worker.endswith(f"@{socket.gethostname()}")


def _has_runs(session: Session, names: Collection[str]) -> bool:
    from seamark.server.messaging import workers
    from seamark.server.runs.queue import queue

    return any(workers.worker_of(process) in names for process in queue.busy_processes(session))
