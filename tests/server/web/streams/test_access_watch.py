"""What goes on for a token or a browser ends when that is refused, whatever the reason."""

import asyncio
import time
from collections.abc import Callable
from contextlib import ExitStack

import pytest
from sqlalchemy import update
from sqlalchemy.orm import Session

from seamark.server.accounts import accounts, browser_sessions
from seamark.server.accounts.audit import Actor
from seamark.server.accounts.credentials import Credential
from seamark.server.administration import people
from seamark.server.database.tables import BrowserSession, Token, User
from seamark.server.runs.ending import account_deletion
from seamark.server.web.streams.access_watch import AccessWatch
from tests.cast import Backend

DEADLINE_S = 60.0
End = Callable[[Session, int], None]


def token(session: Session, user_id: int) -> Credential:
    text = accounts.new_token(session, user_id, "t", ("read",), days=1)
    return Credential(Token, accounts.secret_hash(text))


def browser(session: Session, user_id: int) -> Credential:
    text = browser_sessions.begin(session, user_id)
    return Credential(BrowserSession, accounts.secret_hash(text))


def revoke(session: Session, user_id: int) -> None:
    (found,) = accounts.tokens(session, user_id)
    assert accounts.revoke_token(session, user_id, found.id)


def sign_out(session: Session, user_id: int) -> None:
    (found,) = browser_sessions.of_account(session, user_id, "")
    assert browser_sessions.end_by_handle(session, user_id, found.handle)


def expire(session: Session, user_id: int) -> None:
    for table in (Token, BrowserSession):
        passed = update(table).where(table.user_id == user_id).values(expires_at=time.time() - 1.0)
        session.execute(passed)


def disable(session: Session, user_id: int) -> None:
    people.disable(session, Actor("root"), session.get_one(User, user_id))


def close(session: Session, user_id: int) -> None:
    account_deletion.close(session, user_id, keep_published=True)


def new_password(session: Session, user_id: int) -> None:
    accounts.change_password(session, session.get_one(User, user_id).name, "another password")


CAUSES: dict[str, tuple[Callable[[Session, int], Credential], End]] = {
    "a revoked token": (token, revoke),
    "a token that has expired": (token, expire),
    "a token of a disabled account": (token, disable),
    "a token of a closed account": (token, close),
    "a token of an account with a new password": (token, new_password),
    "a browser that was signed out": (browser, sign_out),
    "a browser whose time has ended": (browser, expire),
    "a browser of a disabled account": (browser, disable),
    "a browser of a closed account": (browser, close),
    "a browser of an account with a new password": (browser, new_password),
}


@pytest.mark.parametrize("cause", CAUSES)
def test_what_goes_on_ends_within_a_renewal_and_nothing_else_does(
    backend: Backend, cause: str
) -> None:
    begin, end = CAUSES[cause]
    ben, eva = backend.user_id("ben"), backend.user_id("eva")
    with backend.database.writing() as session:
        known = begin(session, ben)
        others = [token(session, eva), browser(session, eva)]
    ended, endless = asyncio.Event(), list[str]()

    async def test() -> None:
        watch = AccessWatch(backend.database, every_s=0.05)
        with ExitStack() as stack:
            for other in (*others, None):
                stack.enter_context(watch.watching(other, lambda: endless.append(cause)))
            with watch.watching(known, ended.set):
                await looked(watch)
                assert not ended.is_set()
                with backend.database.writing() as session:
                    end(session, ben)
                async with asyncio.timeout(DEADLINE_S):
                    await ended.wait()
                await looked(watch)
        await asyncio.sleep(0)

    async def looked(watch: AccessWatch) -> None:
        """Wait until the watch has certainly looked: it ends what it does not know."""
        unknown = asyncio.Event()
        with watch.watching(Credential(Token, "0" * 64), unknown.set):
            async with asyncio.timeout(DEADLINE_S):
                await unknown.wait()

    asyncio.run(test())

    assert endless == []


def nothing() -> None:
    """Do nothing."""


def test_a_watch_with_nothing_to_watch_rests(backend: Backend) -> None:
    async def test() -> None:
        watch = AccessWatch(backend.database, every_s=0.05)
        with watch.watching(None, nothing):
            assert len(asyncio.all_tasks()) == 1
        with backend.database.writing() as session:
            known = token(session, backend.user_id("ben"))
        with watch.watching(known, nothing):
            assert len(asyncio.all_tasks()) == 2
        async with asyncio.timeout(DEADLINE_S):
            while len(asyncio.all_tasks()) > 1:
                await asyncio.sleep(0.05)

    asyncio.run(test())
