"""The process of a worker that sends e-mail, where a mail server is set.

    python -s -P -m seamark.worker.service.mail_sender <parent>

A process of its own: a mail server that is slow holds neither requests nor runs nor maintenance.
"""

import sys
from functools import partial

import structlog
from sqlalchemy.exc import SQLAlchemyError

from seamark.server.database.engine import DATABASE_AWAY, Database
from seamark.server.mail import sending, smtp
from seamark.server.messaging import broker
from seamark.server.messaging.shared_meters import SharedMeters
from seamark.server.monitoring import log
from seamark.server.monitoring.outages import Outage
from seamark.server.settings import Settings
from seamark.worker.service.worker_process import are_restricted, follow_worker

POLL_S = 2.0  # [s] between two looks into the outbox
_log = structlog.get_logger()


def main(parent: str) -> None:
    """Be the sender of e-mail of one worker."""
    stopping = follow_worker(int(parent))
    settings = Settings.load()
    log.configure(settings.log_level)
    database, meters = Database(settings.database_url), SharedMeters(broker.connect(settings))
    if are_restricted(database, stopping):
        _log.error("no_mail_sent", why="the database role of this worker reads no addresses")
        stopping.wait()
        return
    outage = Outage("database", process="mail")
    deliver = partial(smtp.deliver, settings)
    while not stopping.wait(POLL_S):
        try:
            sending.prepare(database)
            while not stopping.is_set() and sending.send_next(database, settings, deliver):
                meters.add()
            outage.over()
        except DATABASE_AWAY as error:
            outage.failed(error)
        except SQLAlchemyError:
            _log.exception("mail_not_sent")
        meters.add()


if __name__ == "__main__":
    main(*sys.argv[1:])
