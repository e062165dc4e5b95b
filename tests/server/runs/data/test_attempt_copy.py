"""What a worker publishes, added to the copy of a web machine."""

from pathlib import Path
from typing import Any

import pytest

from seamark.server.messaging.live_data import Increment, Piece
from seamark.server.runs.data import stored_files
from seamark.server.runs.data.files import RunFiles
from seamark.server.settings import Settings
from seamark.server.storage import storage

ROWS = "telemetry.f64"


class Copies:
    """The copies of run 7."""

    def __init__(self, folder: Path) -> None:
        self.settings = Settings.model_validate(
            {"data": folder / "web", "storage_url": f"file://{folder / 'shared'}"}
        )

    def add(
        self, offset: int, content: bytes, *, attempt: int = 1, generation: int = 0, base: int = 0
    ) -> bool:
        piece = Piece(ROWS, generation, base, offset, content)
        return self.append(Increment(attempt, [piece]))

    def append(self, *increments: Increment) -> bool:
        return stored_files.append(self.settings, 7, increments)

    @property
    def files(self) -> RunFiles:
        return RunFiles(storage.copies(self.settings), 7)

    def rows(self) -> bytes:
        return self.files.telemetry_path.read_bytes()


@pytest.fixture
def copies(tmp_path: Path) -> Copies:
    return Copies(tmp_path)


def test_pieces_that_overlap_are_joined(copies: Copies) -> None:
    fits = [
        copies.add(0, b"0123"),
        copies.add(2, b"2345"),
        copies.add(1, b"12"),
        copies.add(6, b""),
    ]

    assert (copies.rows(), fits) == (b"012345", [True] * 4)


@pytest.mark.parametrize("missed", [{"offset": 5, "content": b"5"}, {"offset": 5, "content": b""}])
def test_a_piece_after_a_gap_is_refused_and_changes_nothing(copies: Copies, missed: Any) -> None:
    copies.add(0, b"0123")

    assert not copies.add(**missed)
    assert copies.rows() == b"0123"


def test_what_was_taken_back_goes_even_if_nothing_follows_yet(copies: Copies) -> None:
    copies.add(0, b"0123")

    assert copies.add(2, b"", generation=1, base=2)
    assert copies.rows() == b"01"
    assert copies.add(4, b"45")  # published before it was taken back
    assert copies.rows() == b"01"


def test_a_copy_that_has_missed_a_generation_waits_for_the_storage(copies: Copies) -> None:
    copies.add(0, b"0123")

    assert not copies.add(3, b"xyz", generation=2, base=3)
    assert copies.rows() == b"0123"


def test_the_newest_attempt_replaces_the_others_and_they_add_nothing_more(copies: Copies) -> None:
    copies.add(0, b"dead", attempt=1)
    copies.add(0, b"live", attempt=2)

    assert copies.add(4, b"dead", attempt=1)
    assert (copies.rows(), copies.files.attempts()) == (b"live", [2])


def test_only_the_files_of_runs_are_written(copies: Copies, tmp_path: Path) -> None:
    outside = {"../../../outside": b"x", str(tmp_path / "outside"): b"x", "manifest.json": b"{}"}
    pieces = [Piece(name, 0, 0, 0, b"x") for name in outside]

    copies.append(Increment(1, pieces, outside))

    assert [file.name for file in copies.files.folder.iterdir()] == [".known"]
    assert list(tmp_path.rglob("outside")) == []
