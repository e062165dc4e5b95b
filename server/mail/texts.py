"""What the e-mails say, found at the moment of sending."""

from dataclasses import dataclass
from email.message import EmailMessage
from urllib.parse import quote

from sqlalchemy.orm import Session

from seamark.sandbox.printable_text import visible_text
from seamark.server.accounts import audit, password_resets
from seamark.server.accounts.audit import AuditAction
from seamark.server.database.mail_tables import MailAddress
from seamark.server.database.tables import User
from seamark.server.mail import addresses, notices, outbox
from seamark.server.mail.notices import EndedRun
from seamark.server.mail.outbox import ClaimedMail, MailKind
from seamark.server.mail.smtp import message
from seamark.server.settings import Settings

CONFIRMATION = """\
Hello {name},

this address was entered for the account {name} at {url}.
Open this link within {hours} hours to confirm it:

{link}

If this was not you, ignore this e-mail: without the link the address is not used.
"""
RESET = """\
Hello,

somebody asked for a new password at {url}. {which}

{links}

Each link works once, within {hours} hours. If this was not you, ignore this e-mail:
your password stays as it is.
"""
RUNS = """\
Hello {name},

{what}

{runs}
{more}
Change or switch off these e-mails on your account page: {url}/account
"""


@dataclass(frozen=True, slots=True)
class Composed:
    """An e-mail; `upto` is the last notice of a run that it is about."""

    mail: EmailMessage
    upto: int | None = None


def compose(session: Session, settings: Settings, mail: ClaimedMail) -> Composed | None:
    """Return what is to be sent, with links drawn in this transaction; None if nothing is."""
    if mail.kind is MailKind.RESET:
        return _reset(session, settings, mail.address_hash)
    user = None if mail.user_id is None else session.get(User, mail.user_id)
    if user is None or user.disabled_at is not None:
        return None
    if mail.kind is MailKind.CONFIRMATION:
        return _confirmation(session, settings, user, mail.address_hash)
    return _runs(session, settings, user)


def _confirmation(
    session: Session, settings: Settings, user: User, address_hash: str
) -> Composed | None:
    drawn = addresses.draw_link(session, user.id)
    if drawn is None or outbox.hashed(drawn[0]) != address_hash:  # another one was entered since
        return None
    link = f"{settings.url}/mail/confirm?link={quote(drawn[1])}"
    text = CONFIRMATION.format(name=user.name, url=settings.url, hours=addresses.HOURS, link=link)
    return Composed(message(settings, drawn[0], "Confirm your e-mail address", text))


def _reset(session: Session, settings: Settings, address_hash: str) -> Composed | None:
    owners = addresses.owners(session, address_hash)
    if not owners:
        return None
    links = []
    for user in owners:
        secret = password_resets.create(session, user.name)
        audit.record(
            session, audit.SERVICE, AuditAction.RESET_LINK_MADE, user.name, {"by": "e-mail"}
        )
        links.append(f"{user.name}: {settings.url}/reset?link={quote(secret)}")
    which = "The account of this address:" if len(owners) == 1 else "The accounts of this address:"
    text = RESET.format(
        url=settings.url, which=which, links="\n".join(links), hours=password_resets.HOURS
    )
    to = session.get_one(MailAddress, owners[0].id).address or ""
    return Composed(message(settings, to, "New password", text))


def _runs(session: Session, settings: Settings, user: User) -> Composed | None:
    address, own = notices.ended_runs(session, user.id), session.get(MailAddress, user.id)
    if address is None or own is None or own.address is None:
        return None
    first, rest = address.shown[0], address.count - len(address.shown)
    subject = f"{address.count} runs have ended"
    what = f"{address.count} of your runs have ended:"
    if address.count == 1:
        subject, what = f"Run {first.id} {first.state}", "your run has ended:"
    text = RUNS.format(
        name=user.name,
        url=settings.url,
        what=what,
        runs="\n\n".join(_run(settings, run) for run in address.shown),
        more=f"\nThe other {rest}: {settings.url}/runs/\n" if rest else "",
    )
    return Composed(message(settings, own.address, subject, text), upto=address.upto)


def _run(settings: Settings, run: EndedRun) -> str:
    title = f" “{visible_text(run.title)}”" if run.title else ""
    score = "" if run.score is None else f", score {run.score:.3f}"
    return f"Run {run.id}{title}, {run.benchmark}: {run.state}{score}\n{settings.url}/runs/{run.id}"
