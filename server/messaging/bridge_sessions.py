"""Sessions of connected programs: how a web process and a worker find each other and talk.

1. The web process that has the connection offers a session; a worker with a free slot answers with
   the name of that slot.
2. The web process inserts the run, which starts at this slot, and sends its number.
3. Messages of the program go into one list of the broker and those for it into another, both of
   bounded length: whoever fills one waits until the other side has read.

The keys end by themselves, so that nothing is left of a process that was killed.
"""

import json
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, cast

from redis import Redis, asyncio

OFFERS = "seamark.bridge.offers"  # sessions, the oldest at the left end
OFFERS_MAX = 100
START_S = 60  # that a session may take to start
PRESENT_S = 8  # after which a side counts as gone, unless its process says otherwise
RENEW_S = 2.0
KEPT_S = 60  # of messages that nobody reads
PENDING_MAX = 32  # messages in a list: those of two control steps
READ_S = 1.0  # that a call waits for messages
_MANY = 64
END = b"E"  # nothing follows
_TEXT, _HEAD = b"T", b"H"


@dataclass(frozen=True, slots=True)
class Keys:
    """The keys of a session."""

    session: str

    @property
    def up(self) -> str:
        """Messages of the program, after the number of its run."""
        return f"seamark.bridge.{self.session}.up"

    @property
    def down(self) -> str:
        """Messages for the program, after the name of the slot that it has."""
        return f"seamark.bridge.{self.session}.down"

    @property
    def present(self) -> str:
        """Exists while the program is connected."""
        return f"seamark.bridge.{self.session}.present"

    @property
    def served(self) -> str:
        """Exists while a worker has the session."""
        return f"seamark.bridge.{self.session}.served"


def user_key(user_id: int) -> str:
    """Return the key that lets an account have one session at a time; its value is the session."""
    return f"seamark.bridge.user.{user_id}"


def text(message: str) -> bytes:
    """Return the item of a message."""
    return _TEXT + message.encode()


def message_of(item: bytes) -> str | None:
    """Return the message of an item; None if it is none."""
    return item[1:].decode() if item[:1] == _TEXT else None


def head(value: str | int) -> bytes:
    """Return the item that precedes the messages: the name of a slot, or the number of a run."""
    return _HEAD + json.dumps(value).encode()


def value_of(item: bytes) -> Any:
    """Return the value of a head; None if the item is none."""
    return json.loads(item[1:]) if item[:1] == _HEAD else None


# -- the worker's side ---------------------------------------------------------------------------
def take_offer(redis: "Redis", wait_s: float) -> str | None:
    """Take the oldest session whose program is still connected; None without one. RedisError."""
    until = time.monotonic() + wait_s
    while (left_s := until - time.monotonic()) > 0.0:
        offer = cast("tuple[bytes, bytes] | None", redis.blpop([OFFERS], timeout=max(left_s, 0.01)))
        if offer is None:
            return None
        session = offer[1].decode()
        if is_present(redis, session):
            return session
    return None


def accept(redis: "Redis", session: str, slot: str) -> None:
    """Say that a slot has taken the session. Raises RedisError."""
    redis.set(Keys(session).served, 1, ex=START_S)
    push(redis, Keys(session).down, head(slot))


def serve(redis: "Redis", session: str) -> None:
    """Say that a worker still has the session. Raises RedisError."""
    redis.set(Keys(session).served, 1, ex=PRESENT_S)


def is_present(redis: "Redis", session: str) -> bool:
    """Return whether the program is still connected. Raises RedisError."""
    return bool(redis.exists(Keys(session).present))


def push(redis: "Redis", key: str, item: bytes) -> int:
    """Append an item and return how many wait. Raises RedisError."""
    with redis.pipeline(transaction=False) as commands:
        commands.rpush(key, item)
        commands.expire(key, KEPT_S)
        length, _ = commands.execute()
    return int(length)


def waiting(redis: "Redis", key: str) -> int:
    """Return how many items wait. Raises RedisError."""
    return redis.llen(key)


def read(redis: "Redis", key: str, *, at_most: int = _MANY) -> Sequence[bytes]:
    """Return the items that wait, after waiting for the first one a while. Raises RedisError."""
    return _items(redis.blmpop(READ_S, 1, key, direction="LEFT", count=at_most))


def _items(answer: Any) -> Sequence[bytes]:
    """Return the items in the answer to BLMPOP: a key with its items, or nothing."""
    items: Sequence[bytes] = () if answer is None else answer[1]
    return items


# -- the side of the web process, on its event loop ----------------------------------------------
async def offer(redis: "asyncio.Redis", session: str, user_id: int) -> bool:
    """Offer a session of an account; False if it has one already. Raises RedisError."""
    if not await redis.set(user_key(user_id), session, nx=True, ex=START_S):
        return False
    await redis.set(Keys(session).present, 1, ex=START_S)
    await redis.rpush(OFFERS, session)
    await redis.ltrim(OFFERS, -OFFERS_MAX, -1)
    return True


async def take_back(redis: "asyncio.Redis", session: str) -> bool:
    """Take an offer back; False if a worker has taken it. Raises RedisError."""
    removed: int = await redis.lrem(OFFERS, 0, session)
    return removed > 0


async def renew(redis: "asyncio.Redis", session: str, user_id: int) -> bool:
    """Say that the program is still connected; False if the worker is gone. Raises RedisError."""
    keys = Keys(session)
    async with redis.pipeline(transaction=False) as commands:
        commands.expire(user_key(user_id), PRESENT_S)
        commands.expire(keys.present, PRESENT_S)
        commands.exists(keys.served)
        *_, served = await commands.execute()
    return bool(served)


async def withdraw(redis: "asyncio.Redis", session: str, user_id: int) -> None:
    """Say that the program is gone. Raises RedisError."""
    keys = Keys(session)
    async with redis.pipeline(transaction=False) as commands:
        commands.lrem(OFFERS, 0, session)
        commands.delete(keys.present, keys.down, user_key(user_id))
        commands.rpush(keys.up, END)
        commands.expire(keys.up, KEPT_S)
        await commands.execute()


async def push_up(redis: "asyncio.Redis", session: str, item: bytes) -> int:
    """Append an item of the program and return how many wait. Raises RedisError."""
    key = Keys(session).up
    async with redis.pipeline(transaction=False) as commands:
        commands.rpush(key, item)
        commands.expire(key, KEPT_S)
        length, _ = await commands.execute()
    return int(length)


async def read_down(
    redis: "asyncio.Redis", session: str, wait_s: float = READ_S
) -> Sequence[bytes]:
    """Return the items for the program, after waiting for the first one. Raises RedisError."""
    key = Keys(session).down
    return _items(await redis.blmpop(wait_s, 1, key, direction="LEFT", count=_MANY))
