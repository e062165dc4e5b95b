"""All live streams of a web process, on its event loop."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncGenerator, Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Any

import structlog

from seamark.server.accounts.credentials import Credential
from seamark.server.database.engine import Database
from seamark.server.settings import Settings
from seamark.server.web.streams.access_watch import AccessWatch
from seamark.server.web.streams.events import LOG, Position
from seamark.server.web.streams.feed import Feed
from seamark.server.web.streams.inbox import WAITING_MAX, Inbox
from seamark.server.web.streams.listener import Listener

THREADS = 4  # that read files and the database for streams; pages have others
_log = structlog.get_logger()


class Hub:
    """Lets any number of viewers follow runs.

    `full` and `viewers` may be asked in any thread; all else is called on the event loop.

    Parameters
    ----------
    waiting_max
        Bytes that may wait for one viewer; one for whom more would wait is disconnected.
    """

    def __init__(
        self, database: Database, settings: Settings, *, waiting_max: int = WAITING_MAX
    ) -> None:
        self._waiting_max = waiting_max
        self._database, self._settings = database, settings
        self._threads = ThreadPoolExecutor(THREADS, thread_name_prefix="streams")
        self._feeds: dict[int, Feed] = {}
        self._tasks: dict[int, asyncio.Task[None]] = {}
        self._listener: asyncio.Task[None] | None = None
        self.access = AccessWatch(database)  # of the sessions of programs, too
        self.open_streams = 0
        self._ending = False

    @property
    def full(self) -> bool:
        """Whether there are as many streams as there may be."""
        return self.open_streams >= self._settings.streams_max

    def viewers(self, run_id: int) -> int:
        """Return how many follow a run in this process."""
        feed = self._feeds.get(run_id)
        return 0 if feed is None else feed.viewers

    async def follow(
        self,
        run_id: int,
        after: Position | None,
        *,
        shows_log: bool,
        credential: Credential | None = None,
        gone: asyncio.Future[Any],
        abort: Callable[[], None],
    ) -> AsyncGenerator[bytes, None]:
        """Yield the events of a run until its end, until `gone` or until `end_all`.

        Parameters
        ----------
        after
            Where the viewer resumes; the start of the newest trial if None.
        credential
            Of the viewer: when it is refused, the stream ends.
        abort
            Closes the connection of a viewer that is too slow.
        """
        if self._ending or self.full:  # the client connects again, and may then be refused
            return
        inbox = Inbox("" if shows_log else LOG, waiting_max=self._waiting_max)
        gone.add_done_callback(lambda _: inbox.close())
        feed = self._feed(run_id)
        feed.viewers += 1
        self.open_streams += 1
        try:
            with self.access.watching(credential, inbox.close):
                start = await feed.join(inbox, abort, after)
                for frame in start.frames:
                    if shows_log or frame.type != LOG:
                        yield frame.data
                while (waiting := await inbox.take()) is not None:
                    yield waiting.data
        finally:
            feed.leave(inbox)
            self.open_streams -= 1
            feed.viewers -= 1
            if not feed.viewers:
                self._forget(run_id, feed)

    def end_all(self) -> None:
        """End all streams; their clients connect again, to another process."""
        self._ending = True
        for feed in self._feeds.values():
            feed.close()
        if self._listener is not None:
            self._listener.cancel()

    def close(self) -> None:
        """Stop the threads."""
        self._threads.shutdown(wait=False, cancel_futures=True)

    def _feed(self, run_id: int) -> Feed:
        if run_id not in self._feeds:
            feed = Feed(
                run_id, database=self._database, settings=self._settings, threads=self._threads
            )
            self._feeds[run_id] = feed
            self._tasks[run_id] = asyncio.create_task(feed.run())
            self._tasks[run_id].add_done_callback(partial(self._ended, run_id, feed))
        if self._listener is None:
            listener = Listener(self._settings, self._feeds)
            self._listener = asyncio.create_task(listener.listen())
        return self._feeds[run_id]

    def _ended(self, run_id: int, feed: Feed, task: asyncio.Task[None]) -> None:
        """End the streams of a feed that has ended, for whatever reason."""
        feed.close()
        self._forget(run_id, feed)
        if not task.cancelled() and (error := task.exception()) is not None:
            _log.error("stream_failed", run=run_id, error=repr(error))

    def _forget(self, run_id: int, feed: Feed) -> None:
        if self._feeds.get(run_id) is feed:
            del self._feeds[run_id]
            self._tasks.pop(run_id).cancel()
