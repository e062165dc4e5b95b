"""Telemetry columns, downsampled for charts with their peaks kept."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from flask_openapi3.blueprint import APIBlueprint
from flask_openapi3.models.tag import Tag
from numpy.typing import NDArray

from seamark.server.api.requests.operation_ids import operation_id
from seamark.server.api.requests.schemas import (
    MomentsResponse,
    RunPath,
    SeriesQuery,
    SeriesResponse,
    TrialQuery,
)
from seamark.server.runs.data.downsampling import BLOCK_ROWS, extremes_of_rows
from seamark.server.runs.data.error_curve import error_column
from seamark.server.runs.showing.moments import moments as find_moments
from seamark.server.runs.showing.moments import stages_of
from seamark.server.web import access
from seamark.server.web.problems import Problem
from seamark.sim.recording.telemetry import INDEX

if TYPE_CHECKING:
    from collections.abc import Mapping

    from seamark.server.runs.data.files import RunFiles

COLUMNS_MAX = 96
VALUES_MAX = 320_000  # of a response: more columns have fewer points
_DIGITS = 7  # significant ones; telemetry.csv has all
_SAME_TIME_S = 1e-6
Rows = NDArray[np.float64]
Sampled = tuple[Rows, Rows]  # (m,) [s], (m, k)

api = APIBlueprint(
    "api_series",
    __name__,
    url_prefix="/api/v1",
    operation_id_callback=operation_id,
    abp_tags=[Tag(name="Data", description="The data of a run, at any time.")],
)


@api.get("/runs/<int:run_id>/series.json", responses={200: SeriesResponse})
def series(path: RunPath, query: SeriesQuery) -> dict[str, Any]:
    """Return columns of one trial on one time axis: extremes for charts, or whole rows for poses.

    Numbers have seven significant digits.
    """
    view = access.run_for(path.run_id)
    return series_of(access.files_of(view), query, final=view.state.final)


def series_of(files: RunFiles, query: SeriesQuery, *, final: bool) -> dict[str, Any]:
    """Return columns of one trial of these files; `final` says that no rows will follow.

    Raises
    ------
    Problem
        invalid-request for unknown columns.
    """
    index = {name: at for at, name in enumerate(files.columns)}
    names = _names(query.columns, index)
    first = files.rows_until(query.trial, query.start - _SAME_TIME_S)
    after = max(files.rows_until(query.trial, query.stop + _SAME_TIME_S), first)
    points = max(min(query.max_points, VALUES_MAX // len(names)), 2)
    thinned = _rows if query.sample == "rows" else extremes_of_rows
    t, columns = thinned(files, (first, after), [index[name] for name in names], points)
    return {
        "t": _numbers(t),
        "columns": {name: _numbers(columns[:, at]) for at, name in enumerate(names)},
        "rows": after - first,
        "trial": query.trial,
        "final": final,
    }


@api.get("/runs/<int:run_id>/moments.json", responses={200: MomentsResponse})
def moments(path: RunPath, query: TrialQuery) -> dict[str, Any]:
    """Return when a trial's levels began, its largest error, and when target or route was lost.

    Where an arm works on something, also when each stage of the work was reached.
    The error is that of the tracker where trackers are compared, the distance to the station where
    controllers are, and that to the route where one is followed; detectors have none.
    """
    view = access.run_for(path.run_id)
    error = error_column(view.benchmark)
    return find_moments(access.files_of(view), query.trial, error, stages_of(view))


def _numbers(values: Rows) -> list[float | None]:
    return [float(f"{v:.{_DIGITS}g}") if math.isfinite(v) else None for v in values.tolist()]


def _rows(files: RunFiles, between: tuple[int, int], columns: list[int], points: int) -> Sampled:
    """Return every n-th row and the last one, at most `points`."""
    first, after = between
    step = max(math.ceil((after - first - 1) / max(points - 1, 1)), 1)
    blocks: list[Rows] = []
    size = BLOCK_ROWS // step * step or step
    for at in range(first, after, size):
        blocks.append(files.rows(at, min(at + size, after))[::step])
    if (after - first - 1) % step:
        blocks.append(files.rows(after - 1, after))
    rows = np.concatenate(blocks) if blocks else files.rows(0, 0)
    return rows[:, INDEX["t"]], rows[:, columns]


def _names(text: str, index: Mapping[str, int]) -> list[str]:
    names = [name.strip() for name in text.split(",") if name.strip()]
    unknown = [name for name in names if name not in index]
    if unknown or not names or len(names) > COLUMNS_MAX:
        detail = f"1 to {COLUMNS_MAX} of: {', '.join(index)}."
        raise Problem("invalid-request", "No such columns.", errors={"columns": detail})
    return list(dict.fromkeys(names))
