"""What the processes of a worker ask: whether it shuts down, and what its database role may do."""

import signal
import threading

from seamark.server.database import worker_role
from seamark.server.database.engine import DATABASE_AWAY, Database
from seamark.server.monitoring.outages import Outage
from seamark.worker.ipc.process_control import die_with_parent

RETRY_S = 2.0


class ShuttingDown(Exception):
    """The worker shuts down: what is under way returns to its queue, and counts as no failure."""


def follow_worker(parent: int) -> threading.Event:
    """Bind this side process to its worker; the event is set when the worker shuts down."""
    die_with_parent(parent)
    stopping = threading.Event()
    signal.signal(signal.SIGTERM, lambda *_: stopping.set())
    return stopping


def are_restricted(database: Database, stopping: threading.Event) -> bool:
    """Return whether this process has the rights of a worker only; True if it has to stop."""
    outage = Outage("database")
    while not stopping.is_set():
        try:
            with database.engine.connect() as connection:
                restricted = worker_role.is_restricted(connection)
        except DATABASE_AWAY as error:
            outage.failed(error)
            stopping.wait(RETRY_S)
        else:
            outage.over()
            return restricted
    return True
