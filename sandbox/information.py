"""What bubblewrap tells about itself: the pid of its inner init, as JSON in several pieces."""

import json
import os
import select
import time

END = b"}\n"  # the object is flat, so that its only closing brace is its last


class Information:
    """The reading end of bubblewrap's `--info-fd`."""

    def __init__(self, descriptor: int) -> None:
        self._descriptor = descriptor
        self._told = b""

    def init_pid(self, within_s: float = 0.0) -> int | None:
        """Return the pid when everything is told; None if it does not come within the time.

        A box that is closed right after its start is asked while bubblewrap still writes: half an
        object is waited for, and kept for the next call.
        """
        deadline = time.monotonic() + within_s
        while not self._told.endswith(END):
            if not _readable(self._descriptor, max(deadline - time.monotonic(), 0.0)):
                return None
            piece = os.read(self._descriptor, 4096)
            if not piece:  # bubblewrap ended before it came so far
                return None
            self._told += piece
        return int(json.loads(self._told)["child-pid"])

    def close(self) -> None:
        """Close the descriptor; a second call does nothing."""
        if self._descriptor >= 0:
            os.close(self._descriptor)
            self._descriptor = -1


def _readable(descriptor: int, within_s: float) -> bool:
    poll = select.poll()
    poll.register(descriptor, select.POLLIN)
    return bool(poll.poll(within_s * 1000))
