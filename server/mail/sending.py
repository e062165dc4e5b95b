"""Sends what is in the outbox, one e-mail after the other."""

import structlog

from seamark.server.database.engine import Database
from seamark.server.mail import notices, outbox, texts
from seamark.server.mail.outbox import ClaimedMail
from seamark.server.mail.smtp import Deliver, MailRefused
from seamark.server.monitoring import meters
from seamark.server.settings import Settings

_log = structlog.get_logger()


def send_next(database: Database, settings: Settings, deliver: Deliver) -> bool:
    """Send the e-mail that is due; False if there is none, or the mail server is away.

    No transaction is open while the mail server is talked to. A sender that dies then sends the
    e-mail twice, with another link: better than not at all.
    """
    with database.writing() as session:
        mail = outbox.claim(session)
        composed = None if mail is None else texts.compose(session, settings, mail)
    if mail is None:
        return False
    if composed is None:
        return _end(database, mail, "dropped")
    try:
        deliver(composed.mail)
    except MailRefused as refused:
        return _end(database, mail, "refused", why=str(refused))
    except OSError as error:
        if outbox.is_too_old(mail):
            return _end(database, mail, "given_up", why=type(error).__name__)
        # Not its text: a server may repeat the address in it.
        _log.warning("mail_delayed", mail=mail.id, tries=mail.tries, why=type(error).__name__)
        meters.MAILS.labels("delayed").inc()
        return False
    if composed.upto is not None and mail.user_id is not None:
        with database.writing() as session:
            notices.forget_told(session, mail.user_id, composed.upto)
    return _end(database, mail, "sent")


def _end(database: Database, mail: ClaimedMail, outcome: str, *, why: str = "") -> bool:
    with database.writing() as session:
        outbox.end(session, mail.id)
    meters.MAILS.labels(outcome).inc()
    _log.info("mail_ended", mail=mail.id, kind=mail.kind, outcome=outcome, why=why)
    return True


def prepare(database: Database) -> None:
    """Queue e-mails about runs that have ended, and forget what was sent long ago."""
    with database.writing() as session:
        notices.queue_due(session)
        outbox.forget(session)
