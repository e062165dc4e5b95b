"""A mail server on the loopback interface that keeps what it receives."""

from collections.abc import Iterator
from contextlib import contextmanager
from email import message_from_bytes, policy
from email.message import EmailMessage
from typing import Any

from aiosmtpd.controller import Controller
from aiosmtpd.smtp import Envelope

from seamark.server.settings import Settings

SITE = "https://seamark.example"


class Inbox:
    """What an SMTP server has received; it can refuse."""

    def __init__(self) -> None:
        self.received: list[tuple[str, EmailMessage]] = []  # recipient, message
        self.answer = "250 OK"

    async def handle_DATA(self, _server: Any, _session: Any, envelope: Envelope) -> str:  # noqa: N802
        if self.answer.startswith("250"):
            content = envelope.content
            assert isinstance(content, bytes)
            mail = message_from_bytes(content, EmailMessage, policy=policy.default)
            self.received += [(to, mail) for to in envelope.rcpt_tos]
        return self.answer


class OnFreePort(Controller):
    """A mail server on a port that the system chooses."""

    def _trigger_server(self) -> None:
        self.port = self.server.sockets[0].getsockname()[1]  # type: ignore[union-attr]
        super()._trigger_server()  # type: ignore[no-untyped-call]


@contextmanager
def server() -> Iterator[tuple[Inbox, str]]:
    """Start a mail server; gives what it receives, and its URL for SEAMARK_MAIL_URL."""
    inbox = Inbox()
    controller = OnFreePort(inbox, hostname="127.0.0.1", port=0)
    controller.start()
    try:
        yield inbox, f"smtp://127.0.0.1:{controller.port}?tls=none"
    finally:
        controller.stop()


def with_mail(settings: Settings, url: str) -> Settings:
    """Return settings with which e-mail is sent to a server."""
    changes = {"mail_url": url, "mail_from": "Seamark <seamark@seamark.example>", "url": SITE}
    return settings.model_copy(update=changes)
