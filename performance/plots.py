"""Plots: one style, small files, the same bytes for the same numbers."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

COLOURS = ("#c2410c", "#1d4ed8", "#15803d", "#7e22ce")
DPI = 100


@contextmanager
def figure(out: Path, *, rows: int = 1, height: float = 4.0, share_x: bool = True) -> Iterator[Any]:
    """Yield the axes of a new figure (an array if `rows` > 1); write it to `out` at the end.

    Matplotlib is a development dependency and imported only here.
    """
    import matplotlib  # noqa: PLC0415

    matplotlib.use("Agg")
    from matplotlib import pyplot  # noqa: PLC0415

    drawing, axes = pyplot.subplots(rows, 1, sharex=share_x, figsize=(8.0, height), dpi=DPI)
    yield axes
    for panel in axes if rows > 1 else [axes]:
        panel.grid(alpha=0.3)
    out.parent.mkdir(parents=True, exist_ok=True)
    drawing.tight_layout()
    drawing.savefig(out, metadata={"Software": None})  # no version: same bytes
    pyplot.close(drawing)
