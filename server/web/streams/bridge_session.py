"""The session of a connected program, on the event loop of the web process that has the connection.

Nothing of what the program sends is looked at here: it is passed on, through lists of bounded
length, to the worker that has its run.
"""

from __future__ import annotations

import asyncio
import secrets
from collections.abc import Awaitable, Callable, Sequence
from typing import Protocol

import structlog
from redis.exceptions import RedisError

from seamark.server.messaging import bridge_sessions, broker
from seamark.server.messaging.bridge_sessions import END, PENDING_MAX, RENEW_S, Keys
from seamark.server.settings import Settings

# Clients give a handshake five seconds or more (Autobahn, of roslibpy, five).
OFFER_S = 3.0
BUSY_RETRY_S = 5
FULL_S = 0.02  # between two looks at a list that is full
# What a session may take of a web process and of the broker; 2000 answers a second, six images.
UP_BYTES_S, DOWN_BYTES_S = 2**20, 2**23
MESSAGE_COST = 512  # [byte] that a message counts at least
SECOND = "You have a session already; only one at a time."
REFUSED = "Your token is no longer accepted."
LOST = "The service lost the connection to the run."
BUSY = "All places for connected programs are taken, or no worker has any. Try again soon."
_log = structlog.get_logger()


class Socket(Protocol):
    """The connection of the program."""

    async def receive(self) -> str | None:
        """Return the next message; None when the program is gone."""

    async def send(self, text: str) -> None:
        """Send a message; raises ConnectionError if the program does not take it in time."""


class Budget:
    """Lets bytes pass at a rate, after a second's worth of them at once.

    Parameters
    ----------
    clock
        Returns the time [s].
    """

    def __init__(self, bytes_per_s: float, clock: Callable[[], float]) -> None:
        self._rate, self._clock = bytes_per_s, clock
        self._left, self._at_s = bytes_per_s, clock()

    def delay_s(self, message_bytes: int) -> float:
        """Return how long to wait after a message [s]."""
        now = self._clock()
        left = self._left + (now - self._at_s) * self._rate
        self._left = min(left, self._rate) - max(message_bytes, MESSAGE_COST)
        self._at_s = now
        return max(-self._left / self._rate, 0.0)


class SessionRefused(Exception):
    """There is no session now. The text is for the user; `slug` is that of the problem."""

    def __init__(self, slug: str, sentence: str) -> None:
        super().__init__(sentence)
        self.slug = slug


class BridgeSession:
    """The session of an account, from its offer to its end."""

    def __init__(self, settings: Settings, user_id: int) -> None:
        self.refused = False  # whoever has connected the program may do so no longer
        self._user_id, self._session = user_id, secrets.token_hex(16)
        self._redis = broker.connect_async(settings)
        self._offered = False
        self._ended = asyncio.Event()
        self._wrong = ""

    async def offer(self) -> str:
        """Return the name of the place that has taken the session.

        Raises
        ------
        SessionRefused
            No place is free, or the account has a session already.
        """
        try:
            self._offered = await bridge_sessions.offer(self._redis, self._session, self._user_id)
            if not self._offered:
                raise SessionRefused("conflict", SECOND)
            items = await self._answer()
        except RedisError as error:
            _log.warning("session_not_offered", error=str(error))
            raise SessionRefused("unavailable", BUSY) from None
        if not items:
            raise SessionRefused("unavailable", BUSY)
        return str(bridge_sessions.value_of(items[0]))

    async def _answer(self) -> Sequence[bytes]:
        """Return the answer of a worker; nothing if none takes the offer."""
        items = await bridge_sessions.read_down(self._redis, self._session, OFFER_S)
        if not items and not await bridge_sessions.take_back(self._redis, self._session):
            # One has just taken it.
            return await bridge_sessions.read_down(self._redis, self._session, OFFER_S)
        return items

    async def start(self, run_id: int, *first: str) -> None:
        """Let the place know its run, and the messages that precede those of the program.

        Raises
        ------
        SessionRefused
            The broker is away. The run fails when its lease ends.
        """
        try:
            for item in (bridge_sessions.head(run_id), *map(bridge_sessions.text, first)):
                await bridge_sessions.push_up(self._redis, self._session, item)
        except RedisError as error:
            _log.warning("session_not_started", run=run_id, error=str(error))
            raise SessionRefused("unavailable", BUSY) from None

    def refuse(self) -> None:
        """End the session: what its program sends from now on is not passed on."""
        self.refused, self._wrong = True, REFUSED
        self._ended.set()

    async def run(self, socket: Socket) -> str:
        """Pass messages on in both directions until one side ends; return what went wrong."""
        up = asyncio.create_task(self._until_end(self._pass_up(socket)))
        others = [self._until_end(self._pass_down(socket)), self._until_end(self._renew())]
        await asyncio.gather(*others)
        up.cancel()  # it may wait for the program
        return self._wrong

    async def end(self) -> None:
        """Let the worker know, and forget the session."""
        self._ended.set()
        try:
            if self._offered:
                await bridge_sessions.withdraw(self._redis, self._session, self._user_id)
        except RedisError as error:  # the keys end by themselves
            _log.warning("session_not_withdrawn", error=str(error))
        finally:
            await self._redis.aclose()

    async def _until_end(self, work: Awaitable[None]) -> None:
        """Do a part of the work; when it is over, all of it is."""
        try:
            await work
        except (RedisError, ConnectionError) as error:
            _log.warning("session_broken", error=str(error))
            self._wrong = LOST
        finally:
            self._ended.set()

    async def _pass_up(self, socket: Socket) -> None:
        budget = Budget(UP_BYTES_S, asyncio.get_running_loop().time)
        while (message := await socket.receive()) is not None and not self._ended.is_set():
            item = bridge_sessions.text(message)
            waiting = await bridge_sessions.push_up(self._redis, self._session, item)
            await asyncio.sleep(budget.delay_s(len(item)))
            while waiting >= PENDING_MAX and not self._ended.is_set():
                await asyncio.sleep(FULL_S)
                waiting = await self._redis.llen(Keys(self._session).up)

    async def _pass_down(self, socket: Socket) -> None:
        budget = Budget(DOWN_BYTES_S, asyncio.get_running_loop().time)
        while not self._ended.is_set():
            for item in await bridge_sessions.read_down(self._redis, self._session):
                if item == END:
                    return
                if (message := bridge_sessions.message_of(item)) is not None:
                    await socket.send(message)
                    await asyncio.sleep(budget.delay_s(len(item)))

    async def _renew(self) -> None:
        while not self._ended.is_set():
            if not await bridge_sessions.renew(self._redis, self._session, self._user_id):
                _log.warning("session_abandoned")
                self._wrong = LOST
                return
            try:
                async with asyncio.timeout(RENEW_S):
                    await self._ended.wait()
            except TimeoutError:
                continue
