"""What workers publish, received once for all streams of a web process."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Mapping
from typing import Any

from redis.asyncio import Redis
from redis.asyncio.client import PubSub
from redis.exceptions import RedisError

from seamark.server.messaging import broker, live_data, live_events
from seamark.server.monitoring.outages import Outage
from seamark.server.settings import Settings
from seamark.server.web.streams.feed import Feed

BROKER_RETRY_S = 2.0
LISTEN_S = 0.2  # before the listener looks what is watched, and whether it is to end
ASK_S = 1.0  # between two requests for data that is missing
RENEW_S = 3.0  # between two signs that a run is still watched
COMMAND_S = 10.0  # that the broker may take for a command


class Listener:
    """Passes on what is published about the runs that are followed.

    Redis sends by `asyncio.wait_for`, which in Python 3.11 drops a cancellation that comes while
    its task ends. So nothing here waits without a limit, and each wait asks again.

    Parameters
    ----------
    feeds
        Run -> its feed; it changes.
    """

    def __init__(self, settings: Settings, feeds: Mapping[int, Feed]) -> None:
        self._settings, self._feeds = settings, feeds
        self._watched = set[int]()
        self._asked_at = dict[int, float]()  # run -> when its worker was last asked for data

    async def listen(self) -> None:
        """Listen; while the broker is away, have the feeds look at the database more often."""
        outage = Outage("broker")
        while not _cancelled():
            try:
                async with broker.connect_async(self._settings) as redis, redis.pubsub() as channel:
                    await channel.subscribe(live_events.CHANNEL)
                    self._watched.clear()
                    self._missed()
                    outage.over()
                    await self._receive(redis, channel)
            except (RedisError, TimeoutError) as error:
                outage.failed(error)
                self._missed()
                await asyncio.sleep(BROKER_RETRY_S)

    def _missed(self) -> None:
        """Have feeds look for what was published while nobody listened."""
        for feed in self._feeds.values():
            feed.poll()
            feed.misses_data = True

    async def _receive(self, redis: Redis, channel: PubSub) -> None:
        loop, look_at = asyncio.get_running_loop(), 0.0
        while not _cancelled():
            if loop.time() >= look_at:
                look_at = loop.time() + LISTEN_S
                async with asyncio.timeout(COMMAND_S):
                    await self._watch(redis, channel)
            message = await channel.get_message(ignore_subscribe_messages=True, timeout=LISTEN_S)
            if message is not None:
                self._pass_on(message)

    async def _watch(self, redis: Redis, channel: PubSub) -> None:
        """Receive the data of the runs that are watched now, and let their workers know."""
        watched = {run_id for run_id, feed in self._feeds.items() if feed.wants_data}
        if new := watched - self._watched:
            await channel.subscribe(*map(live_data.channel, new))
        if old := self._watched - watched:
            await channel.unsubscribe(*map(live_data.channel, old))
        self._watched = watched
        now = asyncio.get_running_loop().time()
        due = {run: self._feeds[run].misses_data for run in watched if self._is_due(run, now)}
        if due:
            await live_data.watch(redis, due)
        self._asked_at = {run: now if run in due else self._asked_at[run] for run in watched}

    def _is_due(self, run_id: int, now: float) -> bool:
        every_s = ASK_S if self._feeds[run_id].misses_data else RENEW_S
        return now - self._asked_at.get(run_id, -math.inf) >= every_s

    def _pass_on(self, message: Mapping[str, Any]) -> None:
        run_id = live_data.run_of(message["channel"])
        if run_id is not None:
            if run_id in self._feeds:
                self._feeds[run_id].on_data(message["data"])
            return
        run_id, values = live_events.parse(message["data"])
        if run_id in self._feeds:
            self._feeds[run_id].on_state(values)


def _cancelled() -> bool:
    """Return whether the running task was asked to end, even if a library dropped that."""
    task = asyncio.current_task()
    return task is not None and task.cancelling() > 0
