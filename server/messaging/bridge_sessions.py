"""Sessions of connected programs: how a web process and a worker find each other and talk.

The web process that has the connection offers a session; a worker with a free place takes it. Then
each message of the program goes into one list of the broker and each message for it into another,
both of bounded length: whoever fills one waits until the other side has read. The keys end by
themselves, so that nothing is left of a process that was killed.
"""

import json
import secrets
import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any, Self, cast

from redis import Redis, asyncio

OFFERS = "seamark.bridge.offers"  # the oldest is at its left end
OFFERS_MAX = 100
PRESENT_S = 8  # after which a side counts as gone, unless its process says otherwise
RENEW_S = 2.0
KEPT_S = 60  # of messages that nobody reads
PENDING_MAX = 32  # messages in a list: those of two control steps
READ_S = 1.0  # that a call waits for messages
_MANY = 64
END = b"E"  # nothing follows
_TEXT, _ANSWER = b"T", b"A"


@dataclass(frozen=True, slots=True, kw_only=True)
class Offer:
    """A session that waits for a worker: the run to be started for an account."""

    user_id: int
    benchmark: str
    config: Mapping[str, Any] = field(default_factory=dict)
    seed: int | None = None
    trials: int | None = None
    title: str = ""
    session: str = field(default_factory=lambda: secrets.token_hex(16))

    def encoded(self) -> bytes:
        """Return what `decoded` reads."""
        return json.dumps(asdict(self)).encode()

    @classmethod
    def decoded(cls, item: bytes) -> Self:
        """Return the offer; raises ValueError if it is of another version."""
        try:
            return cls(**json.loads(item))
        except TypeError as error:
            raise ValueError(str(error)) from error


@dataclass(frozen=True, slots=True)
class Keys:
    """The keys of a session."""

    session: str

    @property
    def up(self) -> str:
        """Messages of the program."""
        return f"seamark.bridge.{self.session}.up"

    @property
    def down(self) -> str:
        """Messages for the program; the first one is the answer to the offer."""
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


def answer_of(item: bytes) -> dict[str, Any]:
    """Return the answer to an offer: `run`, or else `refused` with `slug` and `retry_after_s`."""
    if item[:1] != _ANSWER:
        raise ValueError("no answer to an offer")
    answer: dict[str, Any] = json.loads(item[1:])
    return answer


# -- the worker's side ---------------------------------------------------------------------------
def take_offer(redis: "Redis", wait_s: float) -> Offer | None:
    """Take the oldest offer whose program is still connected; None without one. RedisError."""
    until = time.monotonic() + wait_s
    while (left_s := until - time.monotonic()) > 0.0:
        found = cast("tuple[bytes, bytes] | None", redis.blpop([OFFERS], timeout=left_s))
        if found is None:
            return None
        try:
            offer = Offer.decoded(found[1])
        except ValueError:  # of a web process of another version, which gives it up by itself
            continue
        if is_present(redis, offer.session):
            return offer
    return None


def answer(redis: "Redis", session: str, values: Mapping[str, Any]) -> None:
    """Answer an offer. Raises RedisError."""
    serve(redis, session)
    push(redis, Keys(session).down, _ANSWER + json.dumps(values).encode())


def serve(redis: "Redis", session: str) -> None:
    """Say that a worker has the session. Raises RedisError."""
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


def read(redis: "Redis", key: str) -> Sequence[bytes]:
    """Return the items that wait, after waiting for the first one a while. Raises RedisError."""
    first = cast("tuple[bytes, bytes] | None", redis.blpop([key], timeout=READ_S))
    if first is None:
        return ()
    return [first[1], *(cast("list[bytes] | None", redis.lpop(key, _MANY)) or ())]


# -- the side of the web process, on its event loop ----------------------------------------------
async def offer_session(redis: "asyncio.Redis", offer: Offer) -> bool:
    """Offer a session of an account; False if it has one already. Raises RedisError."""
    account, keys = user_key(offer.user_id), Keys(offer.session)
    if not await redis.set(account, offer.session, nx=True, ex=PRESENT_S):
        return False
    await redis.set(keys.present, 1, ex=PRESENT_S)
    await redis.rpush(OFFERS, offer.encoded())
    await redis.ltrim(OFFERS, -OFFERS_MAX, -1)
    return True


async def take_back(redis: "asyncio.Redis", offer: Offer) -> bool:
    """Take an offer back; False if a worker has taken it. Raises RedisError."""
    removed: int = await redis.lrem(OFFERS, 0, offer.encoded().decode())
    return removed > 0


async def renew(redis: "asyncio.Redis", offer: Offer) -> bool:
    """Say that the program is still connected; False if the worker is gone. Raises RedisError."""
    keys = Keys(offer.session)
    async with redis.pipeline(transaction=False) as commands:
        commands.expire(user_key(offer.user_id), PRESENT_S)
        commands.expire(keys.present, PRESENT_S)
        commands.exists(keys.served)
        *_, served = await commands.execute()
    return bool(served)


async def withdraw(redis: "asyncio.Redis", offer: Offer) -> None:
    """Say that the program is gone. Raises RedisError."""
    keys = Keys(offer.session)
    async with redis.pipeline(transaction=False) as commands:
        commands.lrem(OFFERS, 0, offer.encoded().decode())
        commands.delete(keys.present, keys.down, user_key(offer.user_id))
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
    first = await redis.blpop([key], timeout=wait_s)
    if first is None:
        return ()
    more = await redis.lpop(key, _MANY)
    return [first[1], *(more or ())]
