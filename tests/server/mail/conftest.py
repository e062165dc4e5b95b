"""A mail server on the loopback interface, and the cast with confirmed addresses."""

import re
import shutil
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import pytest

from seamark.server.accounts.permissions import Viewer
from seamark.server.database.engine import Database
from seamark.server.database.schema import upgrade
from seamark.server.mail import addresses, sending, smtp
from seamark.server.settings import Settings
from tests.cast import Backend
from tests.services.smtp import Inbox, server, with_mail

LINK = re.compile(r"link=([\w-]+)")


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


@pytest.fixture
def inbox() -> Iterator[tuple[Inbox, str]]:
    with server() as started:
        yield started


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
