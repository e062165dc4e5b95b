"""Beside each worker: says that it lives, and sweeps, so that recovery does not hang on beat.

    python -s -P -m seamark.worker.service.supervise <worker's name>

A process of its own, not a thread of Celery's: the pool forks, and threads do not survive that; and
not a task, because tasks wait while all children are busy with long runs.
"""

import os
import signal
import sys
import threading
import time

import structlog
from sqlalchemy.exc import SQLAlchemyError

from seamark.server import workers
from seamark.server.database.engine import Database
from seamark.server.messaging import broker
from seamark.worker.ipc.process_control import die_with_parent
from seamark.worker.service.app import app, settings
from seamark.worker.service.maintenance import forget_programs, sweep_once

TIDY_S = 3600.0  # [s] between two looks for programs that nobody needs

_log = structlog.get_logger()


def main(name: str) -> None:
    """Go round until the worker ends."""
    die_with_parent(os.getppid())
    ended = threading.Event()
    signal.signal(signal.SIGTERM, lambda *_: ended.set())
    database, redis = Database(settings.database_url), broker.connect(settings)
    tidy_at = time.monotonic()
    while not ended.wait(settings.sweep_s):
        try:
            if time.monotonic() >= tidy_at:
                tidy_at += TIDY_S
                forget_programs(database, settings)
            with database.writing() as session:
                workers.heartbeat(session, name)
            sweep_once(app, database, redis, settings)
        except SQLAlchemyError:
            _log.exception("sweep_failed", worker=name)


if __name__ == "__main__":
    main(sys.argv[1])
