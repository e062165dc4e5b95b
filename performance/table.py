"""Rows of a comparison, and how they are measured and printed.

Timings are noisy: every figure is a median of repeated measurements of CPU time, and what counts
is the ratio to a reference measured in the same run.
"""

import statistics
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """One figure and its reference; a `ratio` above 1 means that the reference needs more."""

    what: str
    value: float
    unit: str
    baseline: str = ""
    baseline_value: float | None = None

    @property
    def ratio(self) -> float | None:
        """Return the reference's figure as a multiple of ours."""
        return None if self.baseline_value is None else self.baseline_value / self.value


def cpu_us(call: Callable[[], object], *, inner: int = 1, repeats: int = 9) -> float:
    """Return the median CPU time [us] of one call; each measurement makes `inner` calls."""
    call()
    measured = []
    for _ in range(repeats):
        start = time.process_time_ns()
        for _ in range(inner):
            call()
        measured.append((time.process_time_ns() - start) / inner / 1e3)
    return statistics.median(measured)


def text(rows: Sequence[Row]) -> str:
    """Return the rows as an aligned table."""
    head = ("what", "ours", "unit", "baseline", "its value", "ratio")
    cells = [
        (
            row.what,
            f"{row.value:.3g}",
            row.unit,
            row.baseline,
            "" if row.baseline_value is None else f"{row.baseline_value:.3g}",
            "" if row.ratio is None else f"{row.ratio:.1f}",
        )
        for row in rows
    ]
    widths = [max(len(line[i]) for line in (head, *cells)) for i in range(len(head))]
    lines = [
        "  ".join(c.ljust(w) for c, w in zip(line, widths, strict=True)) for line in (head, *cells)
    ]
    return "\n".join(line.rstrip() for line in lines)


def aligned(lines: list[tuple[str, ...]]) -> str:
    """Return lines of cells as columns."""
    widths = [max(len(line[at]) for line in lines) for at in range(len(lines[0]))]
    return "\n".join(
        "  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip()
        for line in lines
    )
