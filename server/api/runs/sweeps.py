"""Sweeps: start one, show one, cancel its runs."""

from __future__ import annotations

import time
from typing import Annotated, Any

from flask import Response, jsonify
from flask_openapi3.blueprint import APIBlueprint
from flask_openapi3.models.tag import Tag
from pydantic import BaseModel, ConfigDict, Field

from seamark.server.accounts.permissions import Action
from seamark.server.api.requests import refusals, request_body
from seamark.server.api.requests.operation_ids import operation_id
from seamark.server.api.requests.request_body import SubmissionHeaders
from seamark.server.api.requests.schemas import (
    ResponseModel,
    RunRequest,
    RunResponse,
    Text,
    run_answer,
)
from seamark.server.api.runs.runs import as_what_counts, submission_of
from seamark.server.runs.ending import cancellation
from seamark.server.runs.submission import submission_keys, sweep_axes, sweeps
from seamark.server.runs.submission.sweeps import SweepView
from seamark.server.web import access, rate_limits
from seamark.server.web.services import services
from seamark.server.web.url_converters import ROW_ID_MAX

RETRY_S = 2  # [s] until a client should ask again

api = APIBlueprint(
    "api_sweeps",
    __name__,
    url_prefix="/api/v1",
    operation_id_callback=operation_id,
    abp_tags=[Tag(name="Sweeps", description="Runs over a range of settings or parameters.")],
)


class SweepAxis(BaseModel):
    """What is swept."""

    model_config = ConfigDict(extra="forbid")

    name: Text = Field(min_length=1, max_length=80, description="A setting or parameter")
    values: (
        Annotated[str, Field(max_length=sweep_axes.TEXT_MAX)]
        | Annotated[
            list[
                Annotated[bool, Field(strict=True)]
                | Annotated[int, Field(strict=True)]
                | Annotated[float, Field(strict=True)]
                | Annotated[str, Field(max_length=80)]
            ],
            Field(max_length=sweep_axes.RUNS_MAX),
        ]
    ) = Field(description='A list, or a text: "0.1, 0.2, 0.5", or "from:to:count"')


class SweepPath(BaseModel):
    """Path parameter of a sweep."""

    sweep_id: int = Field(ge=1, le=ROW_ID_MAX, description="Id of the sweep")


class SweepRequest(RunRequest):
    """A sweep to start: a run, and what is swept."""

    sweep: list[SweepAxis] = Field(min_length=1, max_length=sweep_axes.AXES_MAX)


class CellResponse(ResponseModel):
    """A combination of values."""

    values: dict[str, Any] = Field(description="name -> value")
    run: RunResponse | None = Field(description="null if it has been deleted")


class SweepResponse(ResponseModel):
    """A sweep."""

    id: int
    benchmark: str
    title: str
    axes: list[dict[str, Any]]
    created_at: float
    live: int = Field(description="runs that are waiting or running")
    best: int | None = Field(description="the run with the highest score so far")
    cells: list[CellResponse]
    links: dict[str, str]


@api.post("/sweeps", responses={202: SweepResponse})
@rate_limits.limiter.limit(rate_limits.SUBMISSIONS, key_func=rate_limits.client)
def create(header: SubmissionHeaders) -> Response:
    """Start a sweep: a practice run for each combination of values, all of them or none.

    The request body is that of `POST /runs` with `sweep`. All runs have the same seed.
    """
    body, files = request_body.run_request(SweepRequest)
    access.require_scope(Action.SUBMIT)
    settings = services().settings
    with refusals.as_problems():
        axes = [sweep_axes.read_axis(axis.name, axis.values) for axis in body.sweep]
        sent = submission_of(body, files)
        with services().database.reading() as database:
            sent = as_what_counts(database, body, sent)
        planned, key = sweeps.plan(sent, axes, settings), header.submission_key(body, sent)
        with services().database.writing() as database:
            sweep_id = submission_keys.once(
                database,
                key,
                lambda: sweeps.submit(database, planned, axes, settings, title=body.title),
                now=time.time(),
            )
    services().wake_worker()
    with services().database.reading() as database:
        view = sweeps.show(database, sweep_id)
    answer = jsonify(_answer(view) if view is not None else {})
    answer.status_code = 202
    answer.headers["Location"] = f"/api/v1/sweeps/{sweep_id}"
    answer.headers["Retry-After"] = str(RETRY_S)
    return answer


@api.get("/sweeps/<int:sweep_id>", responses={200: SweepResponse})
def show(path: SweepPath) -> Response:
    """Show a sweep with its runs, cell by cell."""
    view = access.sweep_for(path.sweep_id)
    answer = jsonify(_answer(view))
    if view.live:
        answer.headers["Retry-After"] = str(RETRY_S)
    return answer


@api.post("/sweeps/<int:sweep_id>/cancel", responses={200: SweepResponse})
def cancel(path: SweepPath) -> dict[str, Any]:
    """Cancel the runs of a sweep that have not ended. What they recorded so far is kept."""
    access.sweep_for(path.sweep_id, Action.CANCEL)
    cancellation.cancel_sweep(services().database, services().redis, path.sweep_id)
    return _answer(access.sweep_for(path.sweep_id, Action.CANCEL))


def _answer(view: SweepView) -> dict[str, Any]:
    best = view.best
    return {
        "id": view.id,
        "benchmark": view.benchmark,
        "title": view.title,
        "axes": [{"name": axis.name, "values": list(axis.values)} for axis in view.axes],
        "created_at": view.created_at,
        "live": view.live,
        "best": None if best is None or best.run is None else best.run.id,
        "cells": [
            {
                "values": dict(zip([axis.name for axis in view.axes], cell.values, strict=True)),
                "run": None if cell.run is None else run_answer(cell.run, whole=False),
            }
            for cell in view.cells
        ],
        "links": {"self": f"/api/v1/sweeps/{view.id}", "page": f"/sweeps/{view.id}"},
    }
