"""Telemetry columns, downsampled for charts with their peaks kept."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from flask_openapi3.blueprint import APIBlueprint
from flask_openapi3.models.tag import Tag
from numpy.typing import NDArray

from seamark.server.api.schemas import RunPath, SeriesQuery, SeriesResponse
from seamark.server.web import access
from seamark.server.web.problems import Problem

if TYPE_CHECKING:
    from collections.abc import Mapping

COLUMNS_MAX = 16
Rows = NDArray[np.float64]

api = APIBlueprint(
    "api_series",
    __name__,
    url_prefix="/api/v1",
    abp_tags=[Tag(name="Data", description="The data of a run, at any time.")],
)


@api.get("/runs/<int:run_id>/series.json", responses={200: SeriesResponse})
def series(path: RunPath, query: SeriesQuery) -> dict[str, Any]:
    """Return columns of one trial on one time axis, downsampled with the peaks kept."""
    view = access.run_for(path.run_id)
    files = access.files_of(view)
    index = {name: at for at, name in enumerate(files.columns)}
    names = _names(query.columns, index)
    rows = files.rows_of_trial(query.trial)
    t, columns = downsample(
        rows[:, index["t"]], rows[:, [index[n] for n in names]], query.max_points
    )
    return {
        "t": t.tolist(),
        "columns": {
            name: [None if np.isnan(v) else v for v in columns[:, at].tolist()]
            for at, name in enumerate(names)
        },
        "rows": len(rows),
        "trial": query.trial,
        "final": view.state.final,
    }


def _names(text: str, index: Mapping[str, int]) -> list[str]:
    names = [name.strip() for name in text.split(",") if name.strip()]
    unknown = [name for name in names if name not in index]
    if unknown or not names or len(names) > COLUMNS_MAX:
        detail = f"1 to {COLUMNS_MAX} of: {', '.join(index)}."
        raise Problem("invalid-request", "No such columns.", errors={"columns": detail})
    return list(dict.fromkeys(names))


def downsample(t: Rows, columns: Rows, max_points: int) -> tuple[Rows, Rows]:
    """Return at most `max_points` points: the two extremes of each interval, in their order.

    Parameters
    ----------
    t : (n,) [s]
    columns : (n, k)
    max_points
        At least 2.

    Returns
    -------
    t : (m,) [s], columns : (m, k)
        The rows themselves if there are no more than `max_points`.
    """
    if len(t) <= max_points:
        return t, columns
    edges = np.linspace(0, len(t), max_points // 2 + 1).astype(int)
    times: list[float] = []
    values: list[Rows] = []
    for start, stop in pairwise(edges):
        interval = columns[start:stop]
        times += [t[start], t[stop - 1]]
        values += _extremes(interval)
    return np.array(times), np.array(values)


def _extremes(interval: Rows) -> tuple[Rows, Rows]:
    """Return two rows: minimum and maximum of each column, in the order of their occurrence."""
    # NaN would win every comparison; it stays only where there is nothing else.
    low = np.where(np.isnan(interval), np.inf, interval).argmin(axis=0)
    high = np.where(np.isnan(interval), -np.inf, interval).argmax(axis=0)
    every = np.arange(interval.shape[1])
    return interval[np.minimum(low, high), every], interval[np.maximum(low, high), every]
