"""The UDP socket to one ArduPilot: each frame is received once and answered once."""

import socket
import time
from collections.abc import Callable

from seamark.bridge import failures
from seamark.bridge.ardusub.packets import LONGEST_PACKET, NoServos, Servos, read_servos

POLL_S = 0.5  # [s] between two looks at the clock
Address = tuple[str, int]


class Restarted(Exception):
    """ArduPilot counts its frames from the beginning again."""


class Link:
    """A socket that listens for ArduPilot; use it as a context manager."""

    def __init__(
        self, host: str, port: int, *, answer_within_s: float, say: Callable[[str], None]
    ) -> None:
        """Listen; port 0: one that is free.

        Parameters
        ----------
        answer_within_s : float [s]
            Wall time until the next frame, once there was one.

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
        self._refused = False

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
            None came in time.
        Restarted
            ArduPilot counts from the beginning again; `receive` returns that frame next time.
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
        """Return a frame that is new; None for all else."""
        try:
            servos = read_servos(packet)
        except NoServos as reason:
            if not self._refused:
                self._say(f"Ignored {reason}: not from ArduPilot's JSON interface.")
            self._refused = True
            return None
        if self._peer is None:
            self._say(f"ArduPilot at {sender[0]}:{sender[1]}, {servos.rate_hz} frames per second.")
        if sender == self._peer and servos.frame == self._frame:
            self._socket.sendto(self._last_reply, sender)
            return None
        restarted = self._peer is not None and servos.frame < self._frame
        if sender != self._peer and not restarted and self._peer is not None:
            return None  # another one, while this one goes on
        self._peer, self._frame = sender, servos.frame
        if restarted:
            raise Restarted
        return servos

    def reply(self, line: bytes) -> None:
        """Answer the last frame."""
        if self._peer is not None:
            self._last_reply = line
            self._socket.sendto(line, self._peer)
