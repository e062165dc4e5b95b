"""Episodes on the disk before they have their final layout, so that a recording can go on.

A folder beside the output has an `.npz` for each episode that is kept and a `.json` with the
outcome of each attempt. The `.json` comes last: with it an attempt is complete.
"""

from __future__ import annotations

import fcntl
import io
import json
import shutil
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seamark import drafts
from seamark.demonstrations.episodes import Outcome

Arrays = Mapping[str, NDArray[Any]]
_PLAN, _LOCK, _LAYOUT = "plan.json", "lock", "layout"


class OutputRefused(Exception):
    """The output cannot be written; the text says why and what to do."""


class Spool:
    """The episodes of one recording; a process that stores and one that reads may share it."""

    def __init__(self, output: Path) -> None:
        """`output` is where the demonstrations will be in the end."""
        self._output = output.resolve()
        self.folder = self._output.parent / f"{self._output.name}.part"

    @contextmanager
    def opened(self, plan: Mapping[str, Any]) -> Iterator[None]:
        """Provide the folder, to this process alone.

        Parameters
        ----------
        plan
            All that decides what the episodes are, as plain JSON values.

        Raises
        ------
        OutputRefused
            There is something already, of another plan, or of a process that is at it.
        """
        if self._output.exists() and (not self._output.is_dir() or any(self._output.iterdir())):
            raise OutputRefused(f"{self._output} is there already. Choose another folder.")
        self.folder.mkdir(parents=True, exist_ok=True)
        with (self.folder / _LOCK).open("w") as lock:
            try:
                fcntl.lockf(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)  # which forks do not inherit
            except (BlockingIOError, PermissionError):  # EAGAIN or EACCES, fcntl(2)
                raise OutputRefused(f"Another process is writing to {self.folder}.") from None
            self._check(plan)
            yield

    def _check(self, plan: Mapping[str, Any]) -> None:
        file = self.folder / _PLAN
        text = json.dumps(plan, indent=2) + "\n"
        if not file.exists():
            drafts.replace_file(file, text.encode())
        elif file.read_text(encoding="utf-8") != text:
            raise OutputRefused(
                f"{self.folder} has episodes of an interrupted command with other options. Give "
                "the same options to go on with it, or delete it to begin anew."
            )

    def store(self, outcome: Outcome, arrays: Arrays | None) -> None:
        """Keep what came of an attempt, and its episode if there are arrays."""
        if arrays is not None:
            content = io.BytesIO()
            np.savez(content, **arrays)  # type: ignore[arg-type]
            drafts.replace_file(self._file(outcome.number, "npz"), content.getvalue())
        text = json.dumps(outcome.as_dict(), allow_nan=False)
        drafts.replace_file(self._file(outcome.number, "json"), text.encode())

    def outcome(self, number: int) -> Outcome | None:
        """Return what came of an attempt; None if it is not complete."""
        file = self._file(number, "json")
        return Outcome(**json.loads(file.read_text("utf-8"))) if file.exists() else None

    def arrays(self, number: int) -> dict[str, NDArray[Any]]:
        """Return the episode of an attempt that was kept."""
        with np.load(self._file(number, "npz"), allow_pickle=False) as stored:
            return dict(stored)

    def finish(self, write: Callable[[Path], None]) -> None:
        """Have `write` fill a folder, which then becomes the output; nothing else stays."""
        layout = self.folder / _LAYOUT
        shutil.rmtree(layout, ignore_errors=True)
        layout.mkdir()
        write(layout)
        layout.replace(self._output)
        shutil.rmtree(self.folder)

    def _file(self, number: int, suffix: str) -> Path:
        return self.folder / f"{number:06d}.{suffix}"
