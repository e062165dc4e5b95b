"""What waits for one viewer of a run."""

from __future__ import annotations

import asyncio
from collections import deque

from seamark.server.web.streams.events import Frame

WAITING_MAX = 256 * 1024  # [byte] for one viewer: ten seconds of a stream, and more in the kernel


class TooSlow(Exception):
    """The viewer does not read as fast as events come. It may connect again and resume."""


class Inbox:
    """Frames shared with other viewers, in their order.

    Parameters
    ----------
    without
        The type of frames that this viewer must not see; empty: all may be seen.
    waiting_max
        Bytes that may wait.
    """

    def __init__(self, without: str = "", *, waiting_max: int = WAITING_MAX) -> None:
        self._without, self._waiting_max = without, waiting_max
        self._frames: deque[Frame] = deque()
        self._bytes = 0
        self._closed = False
        self._changed = asyncio.Event()

    def put(self, frame: Frame) -> None:
        """Add a frame.

        Raises
        ------
        TooSlow
            Too much is waiting already.
        """
        if frame.type == self._without or self._closed:
            return
        if self._bytes + len(frame.data) > self._waiting_max:
            raise TooSlow
        self._frames.append(frame)
        self._bytes += len(frame.data)
        self._changed.set()

    def close(self) -> None:
        """Let `take` return None once nothing is waiting any more."""
        self._closed = True
        self._changed.set()

    async def take(self) -> Frame | None:
        """Return the next frame; None after the last one."""
        while not self._frames:
            if self._closed:
                return None
            self._changed.clear()
            await self._changed.wait()
        frame = self._frames.popleft()
        self._bytes -= len(frame.data)
        return frame
