"""Hands e-mails to the operator's SMTP server.

With the standard library: its `email` refuses line breaks in headers, its `smtplib` has TLS with
verified certificates, and this runs in the workers, which never import Flask, whose extension is
a thin layer over the same two.
"""

import smtplib
import ssl
from collections.abc import Callable
from email.message import EmailMessage
from email.policy import SMTP
from email.utils import formatdate, make_msgid, parseaddr
from urllib.parse import unquote, urlsplit

from seamark.server.settings import Settings

TIMEOUT_S = 20.0  # of each answer of the server
Deliver = Callable[[EmailMessage], None]


class MailRefused(Exception):
    """The server will never take this e-mail."""


def message(settings: Settings, to: str, subject: str, text: str) -> EmailMessage:
    """Return an e-mail of the service; raises ValueError for line breaks in address or subject."""
    made = EmailMessage(policy=SMTP)
    made["From"] = settings.mail_from
    made["To"] = to
    made["Subject"] = subject
    made["Date"] = formatdate(usegmt=True)
    domain = parseaddr(settings.mail_from)[1].rpartition("@")[2]
    made["Message-ID"] = make_msgid(domain=domain)
    made["Auto-Submitted"] = "auto-generated"  # RFC 3834: nobody's absence answers it
    made.set_content(text)
    return made


def deliver(settings: Settings, mail: EmailMessage) -> None:
    """Hand an e-mail to the SMTP server.

    Raises
    ------
    MailRefused
        The server refuses it for good.
    OSError
        The server is away, slow, has a certificate that is not trusted, or refuses for now; also
        smtplib.SMTPException, which is one.
    """
    try:
        with _connect(settings.mail_url) as server:
            server.send_message(mail)
    except smtplib.SMTPRecipientsRefused as refused:
        codes = [code for code, _ in refused.recipients.values()]
        if min(codes) >= 500:
            raise MailRefused(f"the address is refused: {codes[0]}") from None
        raise
    except (smtplib.SMTPSenderRefused, smtplib.SMTPDataError) as refused:
        if refused.smtp_code >= 500:
            raise MailRefused(f"refused: {refused.smtp_code}") from None
        raise


def _connect(url: str) -> smtplib.SMTP:
    """Connect, with TLS unless the URL says otherwise, and sign in."""
    parts = urlsplit(url)
    host, encrypted = parts.hostname or "", ssl.create_default_context()
    if parts.scheme == "smtps":
        server: smtplib.SMTP = smtplib.SMTP_SSL(
            host, parts.port or 465, timeout=TIMEOUT_S, context=encrypted
        )
    else:
        server = smtplib.SMTP(host, parts.port or 587, timeout=TIMEOUT_S)
    try:
        if parts.scheme == "smtp" and parts.query != "tls=none":
            server.starttls(context=encrypted)
        if parts.username:
            server.login(unquote(parts.username), unquote(parts.password or ""))
    except BaseException:
        server.close()
        raise
    return server
