"""E-mail addresses of accounts. One is used only after its owner has confirmed it by a link."""

import re
import secrets
import time
from dataclasses import dataclass

from sqlalchemy import delete, select
from sqlalchemy.orm import Session

from seamark.server.accounts import accounts
from seamark.server.database.mail_tables import MailAddress
from seamark.server.database.tables import User
from seamark.server.mail import outbox
from seamark.server.mail.outbox import MailKind
from seamark.server.settings import MAIL_ADDRESS

ADDRESS_MAX = 254  # [character] RFC 5321, 4.5.3.1.3
HOURS = 24  # until the link expires
NOTIFY_MINUTES = (5, 30, 120, 480)  # that the page offers
NOTIFY_MINUTES_MAX = 7 * 24 * 60
ACCOUNTS_MAX = 5  # with one address, that get a link for a new password
_ADDRESS = re.compile(MAIL_ADDRESS)


class MailRejected(Exception):
    """The address cannot be stored or used. The text is for the user."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MailSettings:
    """What an account has chosen about e-mail."""

    address: str | None = None  # confirmed
    pending: str | None = None  # its link has been sent and not been opened yet
    notify_minutes: int | None = None


def of_account(session: Session, user_id: int) -> MailSettings:
    """Return what an account has chosen about e-mail."""
    minutes = session.scalar(select(User.notify_minutes).where(User.id == user_id))
    address = session.get(MailAddress, user_id)
    if address is None:
        return MailSettings(notify_minutes=minutes)
    return MailSettings(
        address=address.address, pending=_pending_of(address), notify_minutes=minutes
    )


def propose(session: Session, user_id: int, address: str) -> None:
    """Have a link sent to an address; opening it makes the address that of the account.

    Until then an earlier address stays.

    Raises
    ------
    MailRejected
        It is no address, or it has got too many e-mails within the last hour.
    """
    address = checked(address)
    row = session.get(MailAddress, user_id)
    if row is None:
        row = MailAddress(user_id=user_id)
        session.add(row)
    row.pending, row.pending_hash = address, None
    row.pending_until = time.time() + HOURS * 3600.0
    if not outbox.add(session, MailKind.CONFIRMATION, outbox.hashed(address), user_id=user_id):
        raise MailRejected(
            "Too many e-mails are waiting or have been sent to this address. Try again in an hour."
        )


def draw_link(session: Session, user_id: int) -> tuple[str, str] | None:
    """Return the address to confirm and the secret of a new link; None if there is none."""
    address = session.get(MailAddress, user_id)
    pending = None if address is None else _pending_of(address)
    if address is None or pending is None:
        return None
    text = secrets.token_urlsafe(24)
    address.pending_hash = accounts.secret_hash(text)
    return pending, text


def confirm(session: Session, text: str) -> User:
    """Make the address of a link that of its account. The link works once.

    Raises
    ------
    MailRejected
        It is unknown, expired or has been used.
    """
    query = select(MailAddress).where(
        MailAddress.pending_hash == accounts.secret_hash(text.strip()),
        MailAddress.pending_until > time.time(),
    )
    row = session.scalar(query.with_for_update())
    if row is None or row.pending is None:
        raise MailRejected(
            "This link is unknown, expired or has been used. Enter the address again on the "
            "account page."
        )
    row.address, row.address_hash = row.pending, outbox.hashed(row.pending)
    row.pending = row.pending_hash = row.pending_until = None
    return session.get_one(User, row.user_id)


def remove(session: Session, user_id: int) -> None:
    """Forget the address of an account, and what was to be sent to it."""
    session.execute(delete(MailAddress).where(MailAddress.user_id == user_id))
    outbox.cancel(session, user_id)
    set_notification(session, user_id, None)


def set_notification(session: Session, user_id: int, minutes: int | None) -> None:
    """Ask for an e-mail about each run that took `minutes` or longer; None: no e-mail.

    Raises
    ------
    MailRejected
        There is no confirmed address, or the number is out of range.
    """
    if minutes is not None:
        if not 0 <= minutes <= NOTIFY_MINUTES_MAX:
            raise MailRejected(f"Minutes: a number from 0 to {NOTIFY_MINUTES_MAX}.")
        if of_account(session, user_id).address is None:
            raise MailRejected("Confirm an e-mail address first.")
    session.get_one(User, user_id).notify_minutes = minutes


def owners(session: Session, address_hash: str) -> list[User]:
    """Return the accounts that have confirmed an address and are not disabled, oldest first."""
    query = select(User).join(MailAddress, MailAddress.user_id == User.id)
    query = query.where(MailAddress.address_hash == address_hash, User.disabled_at.is_(None))
    return list(session.scalars(query.order_by(User.id).limit(ACCOUNTS_MAX)))


def checked(address: str) -> str:
    """Return an address without spaces around it; raises MailRejected if it is none."""
    address = address.strip()
    if len(address) > ADDRESS_MAX or not _ADDRESS.fullmatch(address):
        raise MailRejected("Enter an e-mail address, such as ana@example.org.")
    return address


def request_reset(session: Session, address: str) -> None:
    """Have links for new passwords sent to an address if accounts have confirmed it.

    Whether there are any is looked up when the e-mail is sent: until then the same is done for
    every address, so that neither the answer nor its time tells.

    Raises
    ------
    MailRejected
        It is no address.
    """
    outbox.add(session, MailKind.RESET, outbox.hashed(checked(address)))


def _pending_of(row: MailAddress) -> str | None:
    is_open = row.pending_until is not None and row.pending_until > time.time()
    return row.pending if is_open else None
