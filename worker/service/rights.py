"""What the database role of a worker may do, as soon as the database can be asked."""

import threading

from seamark.server.database import worker_role
from seamark.server.database.engine import DATABASE_AWAY, Database
from seamark.server.monitoring.outages import Outage

RETRY_S = 2.0


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
