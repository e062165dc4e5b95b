"""The process of a worker that sends e-mail, where a mail server is set.

    python -s -P -m seamark.worker.service.mail_sender <parent>

A process of its own: a mail server that is slow holds neither requests nor runs nor maintenance.
"""

import sys
from functools import partial

import structlog
from sqlalchemy.exc import SQLAlchemyError

from seamark.server import log
from seamark.server.database import worker_role
from seamark.server.database.engine import Database
from seamark.server.mail import sending, smtp
from seamark.server.messaging import broker
from seamark.server.messaging.shared_meters import SharedMeters
from seamark.server.settings import Settings
from seamark.worker.service.shutdown import follow_worker

POLL_S = 2.0  # [s] between two looks into the outbox
_log = structlog.get_logger()


def main(parent: str) -> None:
    """Be the sender of e-mail of one worker."""
    stopping = follow_worker(int(parent))
    settings = Settings.load()
    log.configure(settings.log_level, settings.log_format)
    database, meters = Database(settings.database_url), SharedMeters(broker.connect(settings))
    with database.engine.connect() as connection:
        if worker_role.is_restricted(connection):
            _log.error("no_mail_sent", why="the database role of this worker reads no addresses")
            stopping.wait()
            return
    deliver = partial(smtp.deliver, settings)
    while not stopping.wait(POLL_S):
        try:
            sending.prepare(database)
            while not stopping.is_set() and sending.send_next(database, settings, deliver):
                meters.add()
        except SQLAlchemyError:
            _log.exception("mail_not_sent")
        meters.add()


if __name__ == "__main__":
    main(*sys.argv[1:])
