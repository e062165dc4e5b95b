"""What a watched run records, published to all web processes at once while it goes on.

Only with object storage: otherwise web processes read the files that the worker writes. The broker
keeps nothing but one key for each watched run, which ends by itself. A message goes to those who
listen at that moment, once however many they are; whoever misses one asks for the newest data
again, and finds what is older in the storage.
"""

import json
import secrets
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, cast

from redis import Redis, asyncio

WATCHED_S = 10  # after which a run counts as watched no more, unless somebody says so again
_CHANNEL = "seamark.data."


@dataclass(frozen=True, slots=True)
class Piece:
    """A piece of a file that grows, `offset` bytes from its start.

    The file was cut to `base` bytes when its generation began: a trial that starts again takes
    rows back.
    """

    file: str
    generation: int
    base: int
    offset: int
    content: bytes

    @property
    def end(self) -> int:
        """The offset after it."""
        return self.offset + len(self.content)


@dataclass(frozen=True, slots=True)
class Increment:
    """What was added to the files of an attempt; `whole` are files that replace what was there."""

    attempt: int
    pieces: Sequence[Piece]
    whole: Mapping[str, bytes] = field(default_factory=dict)


def channel(run_id: int) -> str:
    """Return the channel of what a run records."""
    return f"{_CHANNEL}{run_id}"


def run_of(channel_name: bytes) -> int | None:
    """Return the run of a channel; None if it is one for something else."""
    number = channel_name.removeprefix(_CHANNEL.encode())
    return None if number == channel_name else int(number)


def mark(redis: "Redis", run_id: int) -> bytes | None:
    """Return the mark of those who watch a run; None if nobody does.

    It changes when somebody has missed something. Raises RedisError.
    """
    return cast("bytes | None", redis.get(_key(run_id)))


async def watch(redis: "asyncio.Redis", missing: Mapping[int, bool]) -> None:
    """Say that runs are watched, and of which something is missing.

    Raises RedisError.
    """
    async with redis.pipeline(transaction=False) as commands:
        for run_id, is_missing in missing.items():
            commands.set(_key(run_id), secrets.token_hex(4), ex=WATCHED_S, nx=not is_missing)
            commands.expire(_key(run_id), WATCHED_S)
        await commands.execute()


def publish(redis: "Redis", run_id: int, increment: Increment) -> None:
    """Publish an increment. Raises RedisError."""
    redis.publish(channel(run_id), _encoded(increment))


def parse(message: bytes) -> Increment:
    """Return the increment of a message.

    Raises
    ------
    ValueError
        It is none, or was published by another version.
    """
    line, _, content = message.partition(b"\n")
    try:
        head: Mapping[str, Any] = json.loads(line)
        at, pieces, whole = 0, list[Piece](), dict[str, bytes]()
        for file, generation, base, offset, size in head["pieces"]:
            pieces.append(Piece(file, generation, base, offset, content[at : at + size]))
            at += size
        for file, size in head["whole"]:
            whole[file] = content[at : at + size]
            at += size
        return Increment(int(head["attempt"]), pieces, whole)
    except (KeyError, TypeError, ValueError) as error:
        raise ValueError(f"no increment: {error!r}") from error


def _encoded(increment: Increment) -> bytes:
    pieces, whole = increment.pieces, increment.whole
    head = {
        "attempt": increment.attempt,
        "pieces": [(p.file, p.generation, p.base, p.offset, len(p.content)) for p in pieces],
        "whole": [(name, len(content)) for name, content in whole.items()],
    }
    contents = [piece.content for piece in pieces] + list(whole.values())
    return b"".join([json.dumps(head).encode(), b"\n", *contents])


def _key(run_id: int) -> str:
    return f"seamark.watched.{run_id}"
