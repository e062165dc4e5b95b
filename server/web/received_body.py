"""Bodies of requests, received in full before a thread works on them.

A body waits in memory, a larger one in a temporary file, so that a client that sends slowly costs a
connection and never a thread.
"""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from tempfile import SpooledTemporaryFile
from typing import IO, Any

IN_MEMORY_BYTES = 128 * 1024  # of one body; the rest goes to a temporary file
PATIENCE_S = 30.0  # for a small body, and for the first byte of a large one
SLOWEST_BYTES_PER_S = 16 * 1024  # of a large body, on average

Receive = Callable[[], Awaitable[dict[str, Any]]]


class ClientGone(Exception):
    """The client closed the connection before its request was complete."""


class BodyTooSlow(Exception):
    """The body did not arrive in time."""


@dataclass(frozen=True, slots=True)
class ReceivedBody:
    """The body of a request; empty if it is larger than the limit."""

    file: IO[bytes]
    length: int  # as declared or as received; more than the limit if it is too large


async def receive_body(
    receive: Receive,
    slot: Callable[[], Awaitable[object]],
    *,
    declared: int | None,
    limit: int,
    patience_s: float,
) -> ReceivedBody:
    """Return the body; one beyond the limit is not received any further.

    Parameters
    ----------
    slot
        Waits until one more body may take space on the disk.

    Raises
    ------
    ClientGone, BodyTooSlow
        There will be no complete body.
    """
    file: IO[bytes] = SpooledTemporaryFile(max_size=IN_MEMORY_BYTES)
    if declared is not None and declared > limit:
        return ReceivedBody(file, declared)
    length, more = 0, True
    started_at = asyncio.get_running_loop().time()
    try:
        while more:
            allowed_s = patience_s + length / SLOWEST_BYTES_PER_S
            async with asyncio.timeout_at(started_at + allowed_s):
                message = await receive()
                if length <= IN_MEMORY_BYTES < length + len(message.get("body", b"")):
                    await slot()
            if message["type"] == "http.disconnect":
                raise ClientGone
            chunk, more = message.get("body", b""), message.get("more_body", False)
            length += len(chunk)
            if length > limit:
                file.truncate(0)
                break
            await _write(file, chunk, length)
    except TimeoutError:
        file.close()
        raise BodyTooSlow from None
    except BaseException:
        file.close()
        raise
    file.seek(0)
    return ReceivedBody(file, length)


async def _write(file: IO[bytes], chunk: bytes, length: int) -> None:
    """Write a chunk; to a disk, which may be busy, from a thread."""
    if length > IN_MEMORY_BYTES:
        await asyncio.to_thread(file.write, chunk)
    else:
        file.write(chunk)
