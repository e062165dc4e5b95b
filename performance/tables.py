"""Tables: rows of a comparison, how they are measured, and how any table is printed.

Timings are noisy: every figure is a median of repeated measurements of CPU time, and what counts
is the ratio to a reference measured in the same run.
"""

import math
import statistics
import time
from collections.abc import Callable, Iterable, Sequence
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
    return aligned([head, *cells])


def aligned(lines: Sequence[Sequence[str]]) -> str:
    """Return lines of cells as columns."""
    widths = [max(len(line[at]) for line in lines) for at in range(len(lines[0]))]
    return "\n".join(
        "  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip()
        for line in lines
    )


def markdown_table(header: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """Return a Markdown table; cells are converted with `str` and their bars escaped."""
    lines = [_line(header), "|" + "---|" * len(header)]
    return "\n".join([*lines, *(_line(row) for row in rows)])


def _line(cells: Sequence[object]) -> str:
    return "| " + " | ".join(str(cell).replace("|", "\\|") for cell in cells) + " |"


def signed(value: float, digits: int = 1) -> str:
    """Return the formatted number, never as -0.0."""
    text = f"{value:.{digits}f}"
    return text[1:] if float(text) == 0.0 and text.startswith("-") else text


def below(value: float) -> str:
    """Return the next power of ten above a positive rounding error, such as "< 1e-05".

    Its digits depend on the processor, its size does not.
    """
    return f"< {10.0 ** (math.floor(math.log10(value)) + 1):.0e}" if value > 0.0 else "0"
