"""The UDP socket to one ArduPilot: each frame is received once and answered once."""

import socket
import time
from collections.abc import Callable

from seamark.bridge import failures
from seamark.bridge.ardusub.packets import LONGEST_PACKET, NoServos, Servos, read_servos

POLL_S = 0.5  # [s] longest wait for a packet before the deadline is checked
Address = tuple[str, int]


class Restarted(Exception):
    """ArduPilot counts its frames from the beginning again."""


class Link:
    """A socket that listens for ArduPilot; use it as a context manager."""

    def __init__(
        self, host: str, port: int, *, answer_within_s: float, say: Callable[[str], None]
    ) -> None:
        """Listen; port 0 takes one that is free.

        Parameters
        ----------
        answer_within_s : float [s]
            Longest wall time between two frames.

        Raises
        ------
        OSError
            The address cannot be used.
        """
        self._answer_within_s, self._say = answer_within_s, say
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        self._socket = socket.socket(family, socket.SOCK_DGRAM)
        self._socket.settimeout(POLL_S)
        try:
            self._socket.bind((host, port))
        except OSError:
            self._socket.close()
            raise
        self.port: int = self._socket.getsockname()[1]
        self._peer: Address | None = None
        self._frame = -1
        self._last_reply = b""
        self._has_warned = False

    def __enter__(self) -> "Link":
        """Return the link."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close the socket."""
        self._socket.close()

    def receive(self) -> Servos:
        """Return the next frame, and answer repetitions of the last one as before.

        Raises
        ------
        ProgramEnded
            No frame came in time.
        Restarted
            ArduPilot counts from the beginning again. That frame is received and not returned:
            `reply` answers it, and `receive` waits for the one after it.
        """
        deadline = time.monotonic() + self._answer_within_s
        while True:
            try:
                packet, sender = self._socket.recvfrom(LONGEST_PACKET)
            except TimeoutError:
                if self._peer is not None and time.monotonic() > deadline:
                    raise failures.no_answer(
                        f"ArduPilot sent no frame within {self._answer_within_s:g} s."
                    ) from None
                continue
            frame = self._frame_of(packet, sender)
            if frame is not None:
                return frame

    def _frame_of(self, packet: bytes, sender: Address) -> Servos | None:
        """Return the frame of a packet if it is a new one of this ArduPilot, else None."""
        try:
            servos = read_servos(packet)
        except NoServos as reason:
            if not self._has_warned:
                self._say(f"Ignored {reason}: not from ArduPilot's JSON interface.")
            self._has_warned = True
            return None
        if self._peer is None:
            self._say(f"ArduPilot at {sender[0]}:{sender[1]}, {servos.rate_hz} frames per second.")
        if sender == self._peer and servos.frame == self._frame:
            self._socket.sendto(self._last_reply, sender)
            return None
        restarted = self._peer is not None and servos.frame < self._frame
        if sender != self._peer and not restarted and self._peer is not None:
            return None  # another ArduPilot, while the first one goes on
        self._peer, self._frame = sender, servos.frame
        if restarted:
            raise Restarted
        return servos

    def reply(self, line: bytes) -> None:
        """Answer the last frame."""
        if self._peer is not None:
            self._last_reply = line
            self._socket.sendto(line, self._peer)
