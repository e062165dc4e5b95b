"""A run's pictures with their truth as a data set, made while it is downloaded."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from typing import Any

from flask import Response
from flask_openapi3.blueprint import APIBlueprint
from flask_openapi3.models.tag import Tag

from seamark.server.api import authorization
from seamark.server.api.schemas import DatasetQuery, RunPath
from seamark.server.runs.files import RunFiles
from seamark.server.web.problems import Problem
from seamark.server.web.services import services
from seamark.sim import registry

PICTURES_MAX = 1200  # in one download: a minute of a core, some hundred megabytes
_BUSY_RETRY_S = 20
# Drawing keeps a core busy; the other threads have pages to serve.
_one_at_a_time = threading.Lock()

api = APIBlueprint(
    "api_datasets",
    __name__,
    url_prefix="/api/v1",
    abp_tags=[Tag(name="Data", description="A run's data, at any time.")],
)


_CONTENT: Any = {200: {"content": {"application/zip": {"schema": {"type": "string"}}}}}


@api.get("/runs/<int:run_id>/dataset.zip", responses=_CONTENT)
def dataset(path: RunPath, query: DatasetQuery) -> Response:
    """Download pictures with poses, true corners, intrinsics and water, at most 1200 at once.

    Only runs whose seed is known have one: hidden seeds stay hidden. More pictures at once, and
    data sets without a run, come from `seamark dataset`.
    """
    from seamark.sim.engine.dataset import Selection, archive  # noqa: PLC0415 (it loads OpenCV)

    view = authorization.run_for(path.run_id)
    if view.seed is None:
        raise Problem(
            "conflict",
            "A ranked run's pictures would give its hidden seeds away. Make a practice run with "
            "the same configuration.",
        )
    rows = RunFiles(services().settings.data, view.id).rows_of_trial(query.trial)
    end = float("inf") if query.until is None else query.until
    selection = Selection(every=query.every, begin_s=query.begin, end_s=end, colour=query.colour)
    wanted = len(selection.of(rows))
    if wanted == 0:
        raise Problem("not-found", "There is no telemetry of that trial at that time (yet).")
    if wanted > PICTURES_MAX:
        raise Problem(
            "invalid-request",
            f"These would be {wanted} pictures; one download has at most {PICTURES_MAX}. Choose a "
            "larger `every` or a shorter time, or make all of them with `seamark dataset`.",
        )
    if _one_at_a_time.locked():
        raise Problem(
            "unavailable",
            "Another data set is being made at the moment.",
            headers={"Retry-After": str(_BUSY_RETRY_S)},
        )
    config = registry.benchmark(view.benchmark).read(view.config)
    pieces = archive(view.benchmark, config, rows, seed=view.seed, selection=selection)
    answer = Response(_alone(pieces), content_type="application/zip")
    name = f"seamark-run-{view.id}-dataset.zip"
    answer.headers.set("Content-Disposition", "attachment", filename=name)
    return answer


def _alone(pieces: Iterator[bytes]) -> Iterator[bytes]:
    """Yield the pieces while nobody else makes a data set in this process."""
    with _one_at_a_time:
        yield from pieces
