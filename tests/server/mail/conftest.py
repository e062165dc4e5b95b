"""A mail server on the loopback interface, and the cast with confirmed addresses."""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import partial

import pytest
from sqlalchemy import func, select, update

from seamark.server.database.mail_tables import OutgoingMail
from seamark.server.database.tables import Run
from seamark.server.mail import addresses, sending, smtp
from tests.cast import Backend
from tests.services.smtp import Inbox, server, with_mail

ANN = "Ann@example.org"
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


@pytest.fixture
def post(backend: Backend, inbox: tuple[Inbox, str]) -> Post:
    received, url = inbox
    settings = with_mail(backend.settings, url)
    return Post(backend.database, settings, backend.viewers, received)


def rows(post: Backend, table: type) -> int:
    with post.database.reading() as session:
        return session.scalar(select(func.count()).select_from(table)) or 0


def age(post: Backend, seconds: float) -> None:
    """Let all that waits have been written earlier, and be due."""
    with post.database.writing() as session:
        older = {"created_at": OutgoingMail.created_at - seconds, "next_try_at": 0.0}
        session.execute(update(OutgoingMail).values(**older))


def long_run(post: Post, who: str, *, minutes: float = 31.0, **changes: str) -> int:
    """Return a run that ended so long after it was submitted, with 30 minutes to tell about."""
    with post.database.writing() as session:
        addresses.set_notification(session, post.user_id(who), 30)
    claim = post.running(who, **changes)
    with post.database.writing() as session:
        earlier = Run.queued_at - minutes * 60.0
        session.execute(update(Run).where(Run.id == claim.run_id).values(queued_at=earlier))
    assert post.finish(claim)
    return claim.run_id
