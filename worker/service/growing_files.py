"""The files of one attempt that grow while others follow them, and how much of each is stored."""

import threading
from dataclasses import dataclass

from seamark.server.messaging.live_data import Piece
from seamark.server.runs.data.files import RunFiles
from seamark.server.runs.data.run_objects import GROWING


@dataclass(slots=True)
class _Growth:
    """How much of a file has been stored; a generation begins when rows are taken back."""

    generation: int = 0
    base: int = 0  # size when the generation began
    stored: int = 0
    earlier: int = 0  # `stored` before the newest parts


class GrowingFiles:
    """Pieces of the files as they grow, for those that take them elsewhere, each in its thread."""

    def __init__(self, files: RunFiles) -> None:
        self.files = files
        self._growth = {name: _Growth() for name in GROWING}
        self._lock = threading.Lock()  # between reading a file and taking rows back

    def truncate_rows(self, count: int) -> None:
        """Keep only the first rows of the telemetry; see `RunFiles.truncate_rows`."""
        name = self.files.telemetry_path.name
        with self._lock:
            before = self._size(name)
            self.files.truncate_rows(count)
            size = self._size(name)
            if size < before:
                growth = self._growth[name]
                growth.generation, growth.base = growth.generation + 1, size
                growth.stored, growth.earlier = min(growth.stored, size), min(growth.earlier, size)

    def unstored(self, name: str, *, limit: int) -> Piece:
        """Return the next bytes to store, at most `limit`; empty if there are none."""
        with self._lock:
            return self._piece(name, self._growth[name].stored, limit)

    def stored(self, piece: Piece) -> None:
        """Remember that a piece has been stored."""
        with self._lock:
            growth = self._growth[piece.file]
            if growth.generation == piece.generation:
                growth.stored = piece.end

    def begin_parts(self) -> None:
        """Remember what has been stored before the parts that come now."""
        with self._lock:
            for growth in self._growth.values():
                growth.earlier = growth.stored

    def following(self, name: str, last: Piece | None, *, limit: int) -> Piece:
        """Return the bytes after the last piece, at most `limit`; maybe empty.

        Without a last one, and if it is far behind, they are those since the parts before the
        newest, which whoever has looked at the storage just now has.
        """
        with self._lock:
            growth = self._growth[name]
            at = growth.earlier if last is None else max(last.end, growth.earlier)
            if last is not None and last.generation != growth.generation:
                at = min(at, growth.base)
            return self._piece(name, at, limit)

    def _piece(self, name: str, offset: int, limit: int) -> Piece:
        growth = self._growth[name]
        try:
            with (self.files.folder / name).open("rb") as file:
                file.seek(offset)
                content = file.read(limit)
        except FileNotFoundError:
            content = b""
        return Piece(name, growth.generation, growth.base, offset, content)

    def _size(self, name: str) -> int:
        try:
            return (self.files.folder / name).stat().st_size
        except FileNotFoundError:
            return 0
