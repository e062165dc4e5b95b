"""One run that somebody watches: its files are read once for all of its viewers."""

from __future__ import annotations

import asyncio
from collections import OrderedDict
from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import replace
from typing import Any, TypeVar

import structlog
from sqlalchemy.exc import SQLAlchemyError

from seamark.server.database.engine import Database
from seamark.server.messaging import live_data
from seamark.server.monitoring.outages import Outage
from seamark.server.runs.data import stored_files
from seamark.server.runs.data.files import RunFiles
from seamark.server.runs.record.states import RunState
from seamark.server.runs.showing import views
from seamark.server.runs.showing.views import RunView
from seamark.server.settings import Settings
from seamark.server.web.streams import events
from seamark.server.web.streams.events import Frame, Position
from seamark.server.web.streams.excerpts import (
    START,
    Budget,
    Excerpt,
    excerpt,
    position_now,
    start_of_trial,
)
from seamark.server.web.streams.inbox import Inbox, TooSlow

TICK_S = 0.25  # between two looks at the files of a running run
TICK = Budget(telemetry=3_300, log=900)  # with names and ids 20 KB/s, however fast the run is
POLL_S = 10.0  # between two looks at the database; states are published in between
PENDING_MAX = 4 * 2**20  # [byte] of published data between two looks; more is dropped
_STARTS_MAX = 8  # kept for viewers that come at the same moment
_log = structlog.get_logger()

Result = TypeVar("Result")


def state_values(view: RunView, *, viewers: int) -> dict[str, Any]:
    """Return the values of a state event."""
    names = ("position", "estimate_s", "why_waiting", "progress", "t_simulated", "cause")
    values = {name: getattr(view, name) for name in names}
    return {"state": view.state.value} | values | {"viewers": viewers}


class Feed:
    """Reads a run and hands each event to all viewers.

    Parameters
    ----------
    threads
        Where files and the database are read.
    """

    def __init__(
        self, run_id: int, *, database: Database, settings: Settings, threads: Executor
    ) -> None:
        self._run_id = run_id
        self._database, self._settings, self._threads = database, settings, threads
        self._inboxes: dict[Inbox, Callable[[], None]] = {}
        self._position: Position | None = None
        self._attempt: int | None = None  # of a run that has ended
        self._starts: OrderedDict[object, asyncio.Task[Excerpt]] = OrderedDict()
        self._reading = asyncio.Lock()
        self._woken = asyncio.Event()
        self._pending = list[bytes]()  # published since the last look
        self._poll_now = self._running = self._closed = False
        self.misses_data = True  # of what was published; the worker sends the newest again
        self.viewers = 0  # with those that are about to join

    @property
    def wants_data(self) -> bool:
        """Whether what the worker records comes through the broker before it can be read."""
        return self._running and bool(self._settings.storage_url)

    async def run(self) -> None:
        """Send events until the run has ended."""
        outage = Outage("database", run=self._run_id)
        while True:
            try:
                view = await self._thread(self._view)
                outage.over()
            except SQLAlchemyError as error:  # what the run records is not in the database
                outage.failed(error)
                await self._send_until_next_poll()
                continue
            ended = view is None or view.state.final
            self._attempt = view.attempt if view is not None and ended else None
            await self._advance(START if ended else TICK)
            if view is not None:
                self._send(events.state(state_values(view, viewers=self.viewers)))
                self._running = view.state is RunState.RUNNING
            if ended:
                break
            await self._send_until_next_poll()
        self._send(events.end())
        self.close()

    async def join(
        self, inbox: Inbox, abort: Callable[[], None], after: Position | None
    ) -> Excerpt:
        """Add a viewer; return what it has to see before the frames of its inbox.

        Parameters
        ----------
        abort
            Called if it is too slow.
        after
            Where it resumes; the start of the newest trial if None.
        """
        position = self._position
        if position is None or (after is not None and after.is_beyond(position)):
            position = await self._advance(TICK)
        self._inboxes[inbox] = abort
        if self._closed:
            inbox.close()
        return await self._start(after, position)

    def leave(self, inbox: Inbox) -> None:
        """Remove a viewer."""
        self._inboxes.pop(inbox, None)

    def close(self) -> None:
        """Let all streams end when they have sent what is waiting."""
        self._closed = True
        for inbox in self._inboxes:
            inbox.close()

    def on_state(self, values: dict[str, Any]) -> None:
        """Send a state that was published."""
        state = RunState(values["state"])
        self._running = state is RunState.RUNNING
        if state.final:  # its last rows come first
            self.poll()
        else:
            self._send(events.state(values | {"viewers": self.viewers}))
            self._woken.set()

    def on_data(self, message: bytes) -> None:
        """Keep what was published of the files until the next look at them."""
        self._pending.append(message)
        if sum(map(len, self._pending)) > PENDING_MAX:
            self._pending.clear()  # the next message does not fit, and the rest is asked for

    def poll(self) -> None:
        """Look at the database now."""
        self._poll_now = True
        self._woken.set()

    async def _send_until_next_poll(self) -> None:
        loop = asyncio.get_running_loop()
        deadline = loop.time() + POLL_S
        while not self._poll_now and (left := deadline - loop.time()) > 0:
            try:
                async with asyncio.timeout(min(left, TICK_S) if self._running else left):
                    await self._woken.wait()
            except TimeoutError:
                pass
            self._woken.clear()
            if self._running:
                await self._advance(TICK)
        self._poll_now = False

    async def _advance(self, budget: Budget) -> Position:
        """Send what the files have had since the last time; return the position after it."""
        async with self._reading:
            published, self._pending = self._pending, []
            await self._thread(lambda: self._append(published))
            excerpt = await self._thread(lambda: self._excerpt(self._position, None, budget))
            self._position = excerpt.end
            for frame in excerpt.frames:
                self._send(frame)
            return excerpt.end

    def _send(self, frame: Frame) -> None:
        for inbox, abort in list(self._inboxes.items()):
            try:
                inbox.put(frame)
            except TooSlow:
                self.leave(inbox)
                inbox.close()
                abort()

    async def _start(self, after: Position | None, until: Position) -> Excerpt:
        key = (after, until)
        task = self._starts.get(key)
        if task is None:
            read = self._thread(lambda: self._excerpt(after or self._first(), until, START))
            task = self._starts[key] = asyncio.create_task(read)
            if len(self._starts) > _STARTS_MAX:
                self._starts.popitem(last=False)
        return await asyncio.shield(task)  # other viewers may wait for it too

    # -- in a thread ------------------------------------------------------------------------------
    def _view(self) -> RunView | None:
        with self._database.reading() as session:
            return views.show(session, self._run_id, self._settings)

    def _first(self) -> Position:
        trial = start_of_trial(self._files())
        return Position(trial.attempt, trial.row, 0)

    def _files(self) -> RunFiles:
        return stored_files.latest(self._settings, self._run_id, self._attempt)

    def _append(self, published: list[bytes]) -> None:
        """Add what was published to this machine's copies of the files."""
        if not published:
            return
        try:
            increments = [live_data.parse(message) for message in published]
            fits = stored_files.append(self._settings, self._run_id, increments)
        except (OSError, ValueError) as error:
            _log.warning("data_not_appended", run=self._run_id, error=str(error))
            fits = False
        self.misses_data = not fits

    def _excerpt(self, since: Position | None, until: Position | None, budget: Budget) -> Excerpt:
        try:
            files = self._files()
            until = until or _not_before(since, position_now(files))
            return Excerpt((), until) if since is None else excerpt(files, since, until, budget)
        except OSError as error:  # the storage may come back
            _log.warning("files_not_read", run=self._run_id, error=str(error))
            return Excerpt((), since or Position(0, 0, 0))

    async def _thread(self, function: Callable[[], Result]) -> Result:
        return await asyncio.get_running_loop().run_in_executor(self._threads, function)


def _not_before(last: Position | None, now: Position) -> Position:
    """Return the position now; stored, the end of a long log is older than what was published."""
    if last is None or last.attempt != now.attempt:
        return now
    return replace(now, log=max(now.log, last.log))
