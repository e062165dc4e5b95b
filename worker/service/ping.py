"""Whether the workers of this host are at work or hang, for health checks.

A worker that is cut off from broker and database does not hang: a restart would end its runs and
change nothing. So only silence towards a service that can be reached counts.
"""

import socket
import time

from redis.exceptions import RedisError
from sqlalchemy import func, select
from sqlalchemy.exc import SQLAlchemyError

from seamark.server.database.engine import Database
from seamark.server.database.tables import Worker
from seamark.server.messaging import broker
from seamark.server.messaging.workers import ALIVE_S
from seamark.server.settings import Settings

ANSWER_S = 5.0  # [s] a main process that has work answers within a fraction of a second


def problem(settings: Settings) -> str | None:
    """Return why a worker of this host seems to hang; None if nothing says so."""
    return _silent_main_process(settings) or _old_heartbeat(settings)


def _silent_main_process(settings: Settings) -> str | None:
    """Ask the main processes, through the broker."""
    with broker.connect(settings) as client:
        try:
            client.ping()
        except RedisError:
            return None
    replies = broker.celery_app(settings).control.ping(
        timeout=ANSWER_S, limit=1, pattern=_names("*"), matcher="glob"
    )
    return None if replies else f"no worker of this host has answered within {ANSWER_S:g} s"


def _old_heartbeat(settings: Settings) -> str | None:
    """Look at the last heartbeat of this host: a thread of the main process reports them."""
    database = Database(settings.database_url)
    mine = Worker.name.like(_names("%"))
    try:
        with database.reading() as session:
            seen_at = session.scalar(select(func.max(Worker.seen_at)).where(mine, Worker.slots > 0))
    except SQLAlchemyError:
        return None
    finally:
        database.close()
    if seen_at is None:
        return "no worker of this host is listed"
    age_s = time.time() - seen_at
    return f"the last heartbeat is {age_s:.0f} s old" if age_s > ALIVE_S else None


def _names(any_text: str) -> str:
    """Return a pattern for the names that `command_line` gives to the workers of this host."""
    return f"seamark-{any_text}@{socket.gethostname()}"
