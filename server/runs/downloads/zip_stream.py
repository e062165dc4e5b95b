"""Zip archives that are made while they are sent."""

import zipfile
from collections.abc import Callable, Iterator
from io import RawIOBase
from typing import Any


def pieces(write: Callable[[zipfile.ZipFile], Iterator[None]]) -> Iterator[bytes]:
    """Yield an archive in the pieces in which `write` makes it: one for each of its steps."""
    sink = _Sink()
    with zipfile.ZipFile(sink, "w", zipfile.ZIP_DEFLATED) as file:
        for _ in write(file):
            yield sink.take()
    yield sink.take()


class _Sink(RawIOBase):
    """A file that keeps what is written until it is taken."""

    def __init__(self) -> None:
        self._pieces: list[bytes] = []

    def writable(self) -> bool:
        """Return True: it cannot be read or positioned."""
        return True

    def write(self, data: Any) -> int:
        """Keep the data."""
        self._pieces.append(bytes(data))
        return len(data)

    def take(self) -> bytes:
        """Return what has been written since the last time."""
        taken = b"".join(self._pieces)
        self._pieces.clear()
        return taken
