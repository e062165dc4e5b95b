"""Runs side by side: what differs, and their telemetry on one axis."""

from __future__ import annotations

import hashlib
import math
from dataclasses import asdict
from functools import partial
from typing import Any

from flask import Response, jsonify
from flask_openapi3.blueprint import APIBlueprint
from flask_openapi3.models.tag import Tag
from pydantic import Field

from seamark.server.api.requests.operation_ids import operation_id
from seamark.server.api.requests.query import Query
from seamark.server.api.requests.schemas import ResponseModel, RunResponse, run_answer
from seamark.server.runs.record.seeds import trial_seeds
from seamark.server.runs.showing import overlaid_series
from seamark.server.runs.showing.overlaid_series import Part
from seamark.server.runs.showing.side_by_side import (
    COLUMNS_MAX,
    RUNS_MAX,
    RUNS_MIN,
    SideBySide,
    side_by_side,
)
from seamark.server.runs.showing.views import RunView
from seamark.server.web import access, caching, compared_runs
from seamark.server.web.problems import Problem
from seamark.server.web.services import services

_DIGITS = 7  # significant ones of the series; telemetry.csv has all

api = APIBlueprint(
    "api_compare",
    __name__,
    url_prefix="/api/v1",
    operation_id_callback=operation_id,
    abp_tags=[Tag(name="Runs", description="Submit runs and follow them.")],
)


class CompareQuery(Query):
    """The runs, and what is returned of their telemetry."""

    runs: str = Field(
        max_length=200,
        description=f"{RUNS_MIN} to {RUNS_MAX} ids with commas; differences are to the first run",
    )
    columns: str = Field(
        "",
        max_length=400,
        description=f"Names of up to {COLUMNS_MAX} telemetry columns with commas; none: no series",
    )
    trial: int = Field(0, ge=0, le=10000)
    level: int | None = Field(None, ge=0, le=10000, description="Whole trials if omitted")
    max_points: int = Field(1000, ge=10, le=4000, description="Of the series of each run")


class SettingRowResponse(ResponseModel):
    """A setting in which the runs differ."""

    name: str
    title: str
    unit: str
    values: list[str | None] = Field(description="one per run; null where it has no effect")


class ScoreDifferenceResponse(ResponseModel):
    """The score of a run minus that of the first run."""

    run: int
    other: int
    difference: float | None
    low: float | None = Field(description="of the 95 % interval")
    high: float | None
    paired_trials: int = Field(description="trials in the same conditions; 0: independent trials")
    sentence: str = Field(description="how the difference was computed, or why there is none")


class MetricRowResponse(ResponseModel):
    """A metric of all runs."""

    label: str
    unit: str
    level: str = Field(description="empty: over all levels")
    values: list[float | None]
    best: list[int] = Field(description="positions of the best values")


class RunSeriesResponse(ResponseModel):
    """Columns of one run, thinned with their peaks kept."""

    run: int
    start_s: float | None = Field(
        description="simulated time in the trial at which t is 0; null: the run has no such part"
    )
    t: list[float]
    columns: dict[str, list[float | None]]


class CompareResponse(ResponseModel):
    """Runs side by side; the values of all rows are in the order of `runs`."""

    runs: list[RunResponse]
    note: str = Field(description="what cannot be compared; empty if everything can")
    settings: list[SettingRowResponse]
    scores: list[ScoreDifferenceResponse]
    metrics: list[MetricRowResponse]
    levels: list[str] = Field(description="names of the levels, if they are the same in all runs")
    series: list[RunSeriesResponse]


@api.get("/compare", responses={200: CompareResponse, 304: None})
def compare(query: CompareQuery) -> Response:
    """Compare runs: the settings that differ, scores, metrics, and series on one axis. Has an ETag.

    Differences of scores are paired where trials have the same conditions: reference trials, or the
    same seed in the same scenario.
    """
    ids = compared_runs.ids_of([query.runs])
    runs = compared_runs.runs_of(ids)
    if len(runs) < RUNS_MIN:
        detail = f"Name {RUNS_MIN} to {RUNS_MAX} different runs, such as runs=12,17."
        raise Problem("invalid-request", detail, errors={"runs": detail})
    part = Part(trial=query.trial, level=query.level)
    columns = _columns(query.columns, runs)
    answer = jsonify(
        _document(runs, side_by_side(runs, partial(trial_seeds, settings=services().settings)))
        | {"series": [_series(run, columns, part, query.max_points) for run in runs if columns]}
    )
    answer.set_etag(hashlib.sha256(answer.get_data()).hexdigest()[:24])
    return caching.conditional(answer)


def _columns(text: str, runs: list[RunView]) -> list[str]:
    names = list(dict.fromkeys(name.strip() for name in text.split(",") if name.strip()))
    known = [set(access.files_of(run).columns) for run in runs]
    common = set.intersection(*known)
    if len(names) > COLUMNS_MAX or not set(names) <= common:
        detail = f"Up to {COLUMNS_MAX} of: {', '.join(sorted(common))}."
        raise Problem("invalid-request", "No such columns.", errors={"columns": detail})
    return names


def _document(runs: list[RunView], comparison: SideBySide) -> dict[str, Any]:
    return {
        "runs": [run_answer(run, whole=False) for run in runs],
        "note": comparison.note,
        "settings": [asdict(row) for row in comparison.settings],
        "scores": [asdict(each) for each in comparison.scores],
        "metrics": [asdict(row) for row in comparison.metrics],
        "levels": comparison.levels,
    }


def _series(run: RunView, columns: list[str], part: Part, max_points: int) -> dict[str, Any]:
    overlaid = overlaid_series.series(run, access.files_of(run), columns, part, max_points)
    return {
        "run": run.id,
        "start_s": overlaid.start_s,
        "t": overlaid.t.tolist(),
        "columns": {
            name: [_number(value) for value in overlaid.values[:, at].tolist()]
            for at, name in enumerate(columns)
        },
    }


def _number(value: float) -> float | None:
    return float(f"{value:.{_DIGITS}g}") if math.isfinite(value) else None
