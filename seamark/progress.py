"""The progress of a run on standard error: a bar on a terminal with Rich, else plain lines."""

from __future__ import annotations

import sys
import time
from importlib.util import find_spec
from types import TracebackType
from typing import Any

from typing_extensions import Self

LINE_INTERVAL = 0.1  # fraction of the whole between two plain lines


class Progress:
    """A context manager that shows the progress of a run on standard error.

    A bar on a terminal where Rich is installed, else plain lines; nothing if `quiet`.
    """

    def __init__(self, title: str, *, quiet: bool = False) -> None:
        self._title = title
        self._quiet = quiet
        self._bar: Any = None
        self._task: Any = None
        self._next_line = 0.0
        self._last = ""
        self._started = time.monotonic()

    def __enter__(self) -> Self:
        """Start the bar if this is a terminal."""
        if not self._quiet and sys.stderr.isatty() and find_spec("rich"):
            from rich.console import Console
            from rich.progress import BarColumn, TaskProgressColumn, TextColumn, TimeElapsedColumn
            from rich.progress import Progress as Bar

            self._bar = Bar(
                TextColumn("{task.description}"),
                BarColumn(),
                TaskProgressColumn(),
                TimeElapsedColumn(),
                TextColumn("{task.fields[note]}"),
                console=Console(stderr=True),
            )
            self._task = self._bar.add_task(self._title, total=1.0, note="")
            self._bar.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Stop the bar."""
        if self._bar is not None:
            self._bar.stop()

    def show(self, fraction: float, note: str = "", *, state: str = "") -> None:
        """Show that `fraction` (0 to 1) is done; a change of `state` always prints a line."""
        if self._quiet:
            return
        if self._bar is not None:
            self._bar.update(self._task, completed=min(fraction, 1.0), note=note)
            return
        if fraction < self._next_line and state == self._last:
            return
        self._last = state
        self._next_line = min(fraction + LINE_INTERVAL, 1.0) if fraction < 1.0 else 2.0
        elapsed = time.monotonic() - self._started
        text = f"{self._title}: {100 * fraction:3.0f} % after {elapsed:.1f} s {note}".rstrip()
        print(text, file=sys.stderr, flush=True)
