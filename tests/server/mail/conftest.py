"""A mail server on the loopback interface, and the cast with confirmed addresses."""

import re
import shutil
from collections.abc import Iterator
from dataclasses import dataclass, field
from email import message_from_bytes, policy
from email.message import EmailMessage
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from aiosmtpd.controller import Controller
from aiosmtpd.smtp import Envelope

from seamark.server.accounts.permissions import Viewer
from seamark.server.database.engine import Database
from seamark.server.database.schema import upgrade
from seamark.server.mail import addresses, sending, smtp
from seamark.server.settings import Settings
from tests.cast import Backend

SITE = "https://seamark.example"
LINK = re.compile(r"link=([\w-]+)")


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


@dataclass
class Post(Backend):
    """The cast, a mail server, and what the sender of a worker does."""

    inbox: Inbox = field(default_factory=Inbox)

    def send_all(self) -> None:
        sending.prepare(self.database)
        while sending.send_next(self.database, self.settings, partial(smtp.deliver, self.settings)):
            pass

    def propose(self, name: str, address: str) -> None:
        with self.database.writing() as session:
            addresses.propose(session, self.user_id(name), address)

    def confirm(self, name: str, address: str) -> None:
        """Give an account an address by the link of the e-mail."""
        self.propose(name, address)
        self.send_all()
        with self.database.writing() as session:
            addresses.confirm(session, self.last_link())

    def last_link(self) -> str:
        found: str = LINK.findall(self.last_text())[-1]
        return found

    def last_text(self) -> str:
        text: str = self.inbox.received[-1][1].get_content()
        return text


def with_mail(settings: Settings, url: str) -> Settings:
    """Return settings with which e-mail is sent to a server."""
    changes = {"mail_url": url, "mail_from": "Seamark <seamark@seamark.example>", "url": SITE}
    return settings.model_copy(update=changes)


@pytest.fixture
def inbox() -> Iterator[tuple[Inbox, str]]:
    """An SMTP server on a free port, and its URL."""
    received = Inbox()
    controller = OnFreePort(received, hostname="127.0.0.1", port=0)
    controller.start()
    yield received, f"smtp://127.0.0.1:{controller.port}?tls=none"
    controller.stop()


@pytest.fixture(scope="session")
def cast_in_folder(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Viewer]]:
    """A data folder with the cast, to be copied: faster than to migrate a new database."""
    settings = Settings.model_validate({"data": tmp_path_factory.mktemp("cast")})
    upgrade(settings)
    database = Database(settings.database_url)
    viewers = Backend.with_cast(database, settings).viewers
    database.close()
    return settings.data, viewers


@pytest.fixture
def post(
    cast_in_folder: tuple[Path, dict[str, Viewer]], settings: Settings, inbox: tuple[Inbox, str]
) -> Iterator[Post]:
    (folder, viewers), (received, url) = cast_in_folder, inbox
    shutil.copytree(folder, settings.data, dirs_exist_ok=True)
    changed = {"database_url": f"sqlite:///{settings.data / 'seamark.db'}"}
    settings = with_mail(settings.model_copy(update=changed), url)
    database = Database(settings.database_url)
    yield Post(database, settings, viewers, received)
    database.close()
