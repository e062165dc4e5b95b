"""Plots: one look, small files, the same bytes for the same numbers."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

COLOURS = ("#c2410c", "#1d4ed8", "#15803d", "#7e22ce")
DPI = 100


@contextmanager
def figure(out: Path, *, rows: int = 1, height: float = 4.0) -> Iterator[Any]:
    """Give the axes of a new figure, one or an array of `rows`, and write it to `out` at the end.

    Matplotlib is of the development group and loaded only here.
    """
    import matplotlib  # noqa: PLC0415

    matplotlib.use("Agg")
    from matplotlib import pyplot  # noqa: PLC0415

    drawing, axes = pyplot.subplots(rows, 1, sharex=True, figsize=(8.0, height), dpi=DPI)
    yield axes
    for panel in axes if rows > 1 else [axes]:
        panel.grid(alpha=0.3)
    out.parent.mkdir(parents=True, exist_ok=True)
    drawing.tight_layout()
    drawing.savefig(out, metadata={"Software": None})  # no version inside: bytes stay the same
    pyplot.close(drawing)
