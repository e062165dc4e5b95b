"""A run as a figure, as `seamark plot` draws it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from seamark.client import tables
from seamark.client.documents import RunDocument
from seamark.failures import UsageRefused

if TYPE_CHECKING:
    import numpy as np
    from matplotlib.figure import Figure
    from numpy.typing import NDArray


def figure(document: RunDocument, rows: NDArray[np.void], *, title: str, trial: int) -> Figure:
    """Return a figure of one trial, counted from 1.

    It has the error over time, the current, the path from above, and the metric of each level as
    soon as there are metrics.

    Raises
    ------
    PackageMissing
        Matplotlib is not installed.
    ValueError
        There is no such trial, or this version does not know the benchmark.
    """
    tables.package("matplotlib")
    tables.package("seamark.plots")
    from seamark.plots import charts, picture
    from seamark.plots.result import Result
    from seamark.programs import parameters

    settings, _ = parameters.split(document["config"])
    result = Result(
        name=f"run {document['id']}",
        manifest={"benchmark": document["benchmark"], "configuration": settings},
        metrics=document["metrics"],
        rows=rows,
    )
    kinds = [kind for kind in charts.KINDS if kind != "levels" or document["metrics"]]
    try:
        drawn = charts.charts([result], kinds=kinds, trial=trial - 1, points=charts.PICTURE_POINTS)
    except UsageRefused as refusal:
        raise ValueError(refusal.message) from None
    return picture.figure(drawn, title=title)
