"""One client of a bridge: what it subscribes to, and what it is sent."""

import asyncio
from typing import Any

import orjson
from websockets.asyncio.server import ServerConnection
from websockets.exceptions import ConnectionClosed

from seamark.bridge.rosbridge.axes import Axes
from seamark.bridge.rosbridge.protocol import (
    LEVELS,
    SetAxes,
    SetLevel,
    StatusLevel,
    Subscribe,
    Unsubscribe,
)
from seamark.bridge.rosbridge.topics import TOPICS, Dialect, Moment, Ros, resolved

MOST_SUBSCRIPTIONS = 64
SEND_WITHIN_S = 10.0  # [s] for a client to take its messages; then it is disconnected
_NS_PER_MS = 1_000_000


class _Subscription:
    """All subscriptions of a client to a topic: it gets each message once."""

    def __init__(self, name: str, ros: Ros) -> None:
        self.name, self.ros = name, ros  # as the client wrote the name
        self.throttles: dict[str | int | None, int] = {}  # id -> [ms]
        self._last_ns: int | None = None

    def is_due(self, ns: int) -> bool:
        """Return whether a message of this time [ns] is to be sent, once, and remember it."""
        least = max(1, min(self.throttles.values()) * _NS_PER_MS)
        if self._last_ns is not None and 0 <= ns - self._last_ns < least:
            return False
        self._last_ns = ns
        return True


class Client:
    """A connection and its subscriptions."""

    def __init__(self, connection: ServerConnection, axes: Axes) -> None:
        self._connection = connection
        self.axes = axes
        self._subscriptions: dict[str, _Subscription] = {}  # by the topic's global name
        self.level: StatusLevel = "error"  # as rosbridge begins

    @property
    def address(self) -> str:
        """Host and port; behind a Unix socket there is one client only."""
        remote = self._connection.remote_address
        return f"{remote[0]}:{remote[1]}" if isinstance(remote, tuple) else "The program"

    def prefer(self, order: SetLevel | SetAxes) -> None:
        """Speak as the client wants from now on."""
        if isinstance(order, SetLevel):
            self.level = order.level
        else:
            self.axes = order.axes

    def subscribe(self, order: Subscribe, ros: Ros) -> bool:
        """Add a subscription; False if there are too many."""
        name = resolved(order.topic)
        subscription = self._subscriptions.setdefault(name, _Subscription(order.topic, ros))
        subscription.name, subscription.ros = order.topic, ros
        subscription.throttles[order.id] = order.throttle_rate
        if sum(len(one.throttles) for one in self._subscriptions.values()) > MOST_SUBSCRIPTIONS:
            self.unsubscribe(Unsubscribe(op="unsubscribe", topic=order.topic, id=order.id))
            return False
        return True

    def unsubscribe(self, order: Unsubscribe) -> None:
        """Remove one subscription, or all of a topic."""
        name = resolved(order.topic)
        subscription = self._subscriptions.get(name)
        if subscription is None:
            return
        subscription.throttles.pop(order.id, None)
        if order.id is None or not subscription.throttles:
            del self._subscriptions[name]

    async def publish(self, now: Moment, only: str | None = None) -> None:
        """Send the messages of a moment, in the order of `TOPICS`; `only` that of one topic."""
        for name, topic in TOPICS.items():
            subscription = self._subscriptions.get(name)
            wanted = only in (None, name) and topic.has_message(now)
            if subscription is not None and wanted and subscription.is_due(now.stamp.ns):
                message = topic.message(now, Dialect(subscription.ros, self.axes))
                await self.send({"op": "publish", "topic": subscription.name, "msg": message})

    async def publish_result(self, topic: str, message: dict[str, Any]) -> None:
        """Send a message of a topic that belongs to no moment, if the client subscribes to it."""
        if subscription := self._subscriptions.get(topic):
            await self.send({"op": "publish", "topic": subscription.name, "msg": message})

    async def status(
        self, level: StatusLevel, text: str, reply_to: str | int | None = None
    ) -> None:
        """Send a status message, if the client wants those of this level."""
        if LEVELS.index(level) >= LEVELS.index(self.level):
            status: dict[str, Any] = {"op": "status", "level": level, "msg": text}
            await self.send(status if reply_to is None else status | {"id": reply_to})

    async def send(self, message: dict[str, Any]) -> None:
        """Send a message; one who does not take it in time is disconnected."""
        try:
            async with asyncio.timeout(SEND_WITHIN_S):
                await self._connection.send(orjson.dumps(message).decode())
        except TimeoutError:
            self._connection.transport.abort()
        except ConnectionClosed:
            pass  # whoever reads from it notices
