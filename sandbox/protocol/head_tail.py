"""Bounded storage of what a program prints: the middle is dropped, and counted."""


class HeadTail:
    """A byte stream of any length in bounded memory: its beginning and its end."""

    def __init__(self, keep: int) -> None:
        self._half = max(keep // 2, 1)
        self._head = bytearray()
        self._tail = bytearray()
        self.total = 0  # [B] everything that was fed

    @property
    def dropped(self) -> int:
        """Return the number of bytes in the middle that were dropped."""
        return self.total - len(self._head) - min(len(self._tail), self._half)

    def feed(self, data: bytes) -> None:
        """Append bytes."""
        self.total += len(data)
        room = self._half - len(self._head)
        self._head += data[:room] if room > 0 else b""
        self._tail += data[max(room, 0) :]
        if len(self._tail) > 4 * self._half:  # rarely, so that a flood costs little
            del self._tail[: -self._half]

    def text(self) -> bytes:
        """Return head, a line with the number of dropped bytes, and tail."""
        if not self.dropped:
            return bytes(self._head + self._tail)
        notice = f"\n... {self.dropped} bytes dropped ...\n".encode()
        return bytes(self._head) + notice + bytes(self._tail[-self._half :])
