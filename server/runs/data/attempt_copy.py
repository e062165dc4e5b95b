"""The copy of the files of one attempt, and how much of each it has."""

import json
from pathlib import Path
from typing import Any

from seamark.server.messaging.live_data import Increment, Piece
from seamark.server.runs.data import run_objects
from seamark.server.runs.data.run_objects import GROWING, REPLACED, Attempt, Part
from seamark.server.storage.objects import Objects

_KNOWN = ".known"  # tags of whole files; generation and size of those that grow


class AttemptCopy:
    """A folder with copies; only one process at a time may write to it."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._known: dict[str, Any] = {}
        if (folder / _KNOWN).exists():
            self._known = json.loads((folder / _KNOWN).read_bytes())

    @property
    def is_whole(self) -> bool:
        """Whether it was copied after the end of the attempt."""
        return any(name in self._known for name in GROWING)

    def take_whole(self, stored: Objects, attempt: Attempt) -> None:
        """Copy the whole files that have changed. Raises ObjectsAway."""
        for name, one in attempt.files.items():
            if name != run_objects.COMPLETE and self._known.get(name) != one.tag:
                stored.fetch(one.path, self._folder / name)
                self._known[name] = one.tag
        self._remember()

    def take_parts(self, stored: Objects, attempt: Attempt) -> None:
        """Copy the parts that are missing. Raises ObjectsAway."""
        for name in GROWING:
            for part in attempt.parts.get(name, ()):
                self._take_part(stored, name, part)

    def take_increment(self, increment: Increment) -> bool:
        """Add what was published; False if something before it is missing."""
        for name, content in increment.whole.items():
            if name in REPLACED:
                self._replace(name, content)
                self._known.pop(name, None)
        pieces = [piece for piece in increment.pieces if piece.file in GROWING]
        fits = all([self._take_piece(piece) for piece in pieces])
        self._remember()
        return fits

    def _take_part(self, stored: Objects, name: str, part: Part) -> None:
        generation, size = self._grown(name)
        if part.generation > generation:
            generation, size = part.generation, min(size, part.offset)
        is_new = part.generation == generation and part.offset <= size < part.offset + part.size
        content = stored.get(part.path) if is_new else None
        if content is not None:  # else it is known, or meanwhile replaced by the whole file
            self._write(name, generation, size, content[size - part.offset :])

    def _take_piece(self, piece: Piece) -> bool:
        generation, size = self._grown(piece.file)
        if piece.generation < generation:
            return True  # the storage knew first that these rows were taken back
        cut = piece.generation == generation + 1
        if cut:
            size = min(size, piece.base)
        elif piece.generation > generation:
            return False
        if piece.offset > size:
            return False
        if cut or piece.end > size:
            self._write(piece.file, piece.generation, size, piece.content[size - piece.offset :])
        return True

    def _grown(self, name: str) -> tuple[int, int]:
        generation, size = self._known.get(_growth(name), (0, 0))
        return generation, size

    def _write(self, name: str, generation: int, size: int, content: bytes) -> None:
        """Have `size` bytes of a file followed by some content."""
        file = self._folder / name
        with file.open("r+b" if file.exists() else "wb") as copy:
            copy.truncate(size)
            copy.seek(size)
            copy.write(content)
        self._known[_growth(name)] = generation, size + len(content)
        self._remember()

    def _remember(self) -> None:
        self._replace(_KNOWN, json.dumps(self._known).encode())

    def _replace(self, name: str, content: bytes) -> None:
        draft = self._folder / f".{name}.draft"
        draft.write_bytes(content)
        draft.replace(self._folder / name)


def _growth(name: str) -> str:
    return f"{name} parts"
