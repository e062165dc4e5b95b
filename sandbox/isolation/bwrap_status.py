"""What bubblewrap reports: the pid of its inner init, and the program's exit code.

Both are lines of JSON on its `--json-status-fd`. The exit code is taken from here and not from
waiting for the process, which only the parent can do: a box may be used by a fork of its parent.
"""

import json
import os
import select
import time


class BwrapStatus:
    """The reading end of the pipe; does not block."""

    def __init__(self, descriptor: int) -> None:
        self._descriptor = descriptor
        self._received = b""

    def init_pid(self, within_s: float = 0.0) -> int | None:
        """Return the pid of the inner init; None if it is not reported within the time.

        If the box is closed right after its start, bubblewrap may still be writing: an incomplete
        line is waited for, and kept for the next call.
        """
        deadline = time.monotonic() + within_s
        while b"\n" not in self._received:
            if not _readable(self._descriptor, max(deadline - time.monotonic(), 0.0)):
                return None
            if not self._read():  # bubblewrap ended before it reported the pid
                return None
        return int(json.loads(self._received.partition(b"\n")[0])["child-pid"])

    def exit_code(self) -> int | None:
        """Return the exit code (128 + signal if by one); None if it was not reported.

        Call it after bubblewrap has ended: then everything is in the pipe.
        """
        while _readable(self._descriptor, 0.0) and self._read():
            pass
        for line in self._received.splitlines()[1:]:
            return int(json.loads(line)["exit-code"])
        return None

    def _read(self) -> bool:
        """Read what is available; False at the end."""
        piece = os.read(self._descriptor, 4096)
        self._received += piece
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
