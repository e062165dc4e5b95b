"""What bubblewrap tells about itself: the pid of its inner init, and how the program ended.

Both are lines of JSON on its `--json-status-fd`. The end is known from here, and not by waiting for
the process, because only its parent could do that: a box may be used by a fork of its maker.
"""

import json
import os
import select
import time


class Information:
    """The reading end; does not block."""

    def __init__(self, descriptor: int) -> None:
        self._descriptor = descriptor
        self._told = b""

    def init_pid(self, within_s: float = 0.0) -> int | None:
        """Return the pid when it is told; None if it does not come within the time.

        A box that is closed right after its start is asked while bubblewrap still writes: half a
        line is waited for, and kept for the next call.
        """
        deadline = time.monotonic() + within_s
        while b"\n" not in self._told:
            if not _readable(self._descriptor, max(deadline - time.monotonic(), 0.0)):
                return None
            if not self._read():  # bubblewrap ended before it came so far
                return None
        return int(json.loads(self._told.partition(b"\n")[0])["child-pid"])

    def exit_code(self) -> int | None:
        """Return how the program ended (128 + signal if by one); None if that was not told.

        To be asked when bubblewrap has ended: what it told is there then.
        """
        while _readable(self._descriptor, 0.0) and self._read():
            pass
        for line in self._told.splitlines()[1:]:
            return int(json.loads(line)["exit-code"])
        return None

    def _read(self) -> bool:
        """Take what is there; False at the end."""
        piece = os.read(self._descriptor, 4096)
        self._told += piece
        return bool(piece)

    def close(self) -> None:
        """Close the descriptor; a second call does nothing."""
        if self._descriptor >= 0:
            os.close(self._descriptor)
            self._descriptor = -1


def _readable(descriptor: int, within_s: float) -> bool:
    poll = select.poll()
    poll.register(descriptor, select.POLLIN)
    return bool(poll.poll(within_s * 1000))
