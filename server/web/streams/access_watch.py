"""What outlives the request that began it ends when that request would be refused by now."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager

from sqlalchemy.exc import SQLAlchemyError

from seamark.server.accounts import credentials
from seamark.server.accounts.credentials import Credential
from seamark.server.database.engine import Database
from seamark.server.monitoring.outages import Outage

RENEW_S = 2.0  # between two looks


class AccessWatch:
    """Looks again, with one query for all streams and sessions of a web process.

    Belongs to the event loop. Looks at nothing while nothing goes on.
    """

    def __init__(self, database: Database, *, every_s: float = RENEW_S) -> None:
        self._database, self._every_s = database, every_s
        self._open: dict[object, tuple[Credential, Callable[[], None]]] = {}
        self._outage = Outage("database", of="streams")
        self._task: asyncio.Task[None] | None = None

    @contextmanager
    def watching(self, credential: Credential | None, end: Callable[[], None]) -> Iterator[None]:
        """Call `end` if the credential is refused before the block ends.

        Without one, as for a guest, there is nothing that could be revoked.
        """
        if credential is None:
            yield
            return
        key = object()
        self._open[key] = credential, end
        if self._task is None:
            self._task = asyncio.create_task(self._watch())
        try:
            yield
        finally:
            self._open.pop(key, None)

    async def _watch(self) -> None:
        try:
            while self._open:
                await asyncio.sleep(self._every_s)
                await self._look()
        finally:
            self._task = None

    async def _look(self) -> None:
        known = {credential for credential, _ in self._open.values()}
        try:
            refused = await asyncio.to_thread(self._refused, known)
        except SQLAlchemyError as error:  # nobody can revoke anything either
            self._outage.failed(error)
            return
        self._outage.over()
        for key, (credential, end) in list(self._open.items()):
            if credential in refused:
                del self._open[key]
                end()

    def _refused(self, known: Collection[Credential]) -> set[Credential]:
        with self._database.reading() as session:
            return credentials.refused(session, known)
