"""The files that commands write, whole or not at all (`seamark.drafts`)."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

from seamark import drafts
from seamark.failures import UsageRefused

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from seamark.worker.ipc.outcomes import RunOutcome

FILES = ("manifest.json", "metrics.json", "telemetry.csv", "log.txt")


@contextmanager
def draft_of(out: Path) -> Iterator[BinaryIO]:
    """Provide a file that takes the place of `out` at the end; raises UsageRefused."""
    try:
        with drafts.draft_of(out) as file:
            yield file
    except OSError as error:
        raise UsageRefused(f"{out} cannot be written: {error.strerror or error}.") from None


class RowsInMemory:
    """Collects the rows of one run."""

    def __init__(self) -> None:
        self.parts: list[NDArray[np.float64]] = []

    def add(self, rows: NDArray[np.float64]) -> None:
        """Collect rows of telemetry."""
        self.parts.append(rows.copy())

    def discard(self, trial: int) -> None:
        """Discard the rows of a trial that starts again."""
        from seamark.sim.recording.telemetry import INDEX

        at = INDEX["trial"]
        self.parts = [rows[rows[:, at] < trial] for rows in self.parts]


class OutputFolder:
    """Collects the data of one run and writes its files; without a folder it keeps nothing.

    Raises
    ------
    UsageRefused
        The folder holds other files, or is not writable.
    """

    def __init__(self, folder: Path | None) -> None:
        self._folder = folder
        self._rows = RowsInMemory()
        self._log: list[bytes] = []
        self.comments: list[str] = []  # lines for the header of the telemetry
        if folder is not None:
            _prepare(folder)

    def add_rows(self, rows: NDArray[np.float64]) -> None:
        """Collect rows of telemetry."""
        if self._folder is not None:
            self._rows.add(rows)

    def add_log(self, text: bytes) -> None:
        """Collect output of the program."""
        self._log.append(text)

    def discard(self, trial: int) -> None:
        """Discard the rows of a trial that starts again."""
        self._rows.discard(trial)

    def save(self, benchmark: str, outcome: RunOutcome | None) -> None:
        """Write the files; without `outcome` (interrupted) only telemetry and log."""
        if self._folder is None:
            return
        from seamark.sim.recording import telemetry

        comments = [f"Seamark {benchmark}", *self.comments]
        documents: dict[str, object] = {}
        if outcome is not None:
            comments.append(f"digest {outcome.digest}")
            documents = {"manifest.json": outcome.manifest, "metrics.json": outcome.metrics}
        width = self._rows.parts[0].shape[1] if self._rows.parts else telemetry.WIDTH
        with ExitStack() as drafts:  # all are complete before the first takes its place
            table = drafts.enter_context(draft_of(self._folder / "telemetry.csv"))
            table.write(telemetry.header(comments, width=width).encode())
            for rows in self._rows.parts:
                table.write(telemetry.csv_lines(rows).encode())
            log = drafts.enter_context(draft_of(self._folder / "log.txt"))
            log.write(b"".join(self._log))
            for name, value in documents.items():
                if value is not None:
                    file = drafts.enter_context(draft_of(self._folder / name))
                    file.write(f"{json.dumps(value, indent=2, allow_nan=False)}\n".encode())
        for name, value in documents.items():
            if value is None:
                (self._folder / name).unlink(missing_ok=True)  # left by an earlier run


def _prepare(folder: Path) -> None:
    """Create the folder; refuse one with files that no run wrote."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        foreign = sorted(entry.name for entry in folder.iterdir() if entry.name not in FILES)
    except OSError as error:
        raise UsageRefused(f"{folder} cannot be used: {error.strerror}.") from None
    if foreign:
        raise UsageRefused(
            f"{folder} holds other files ({', '.join(foreign[:3])}). "
            "Choose an empty or a new folder."
        )
    if not os.access(folder, os.W_OK):
        raise UsageRefused(f"{folder} cannot be written to.")
