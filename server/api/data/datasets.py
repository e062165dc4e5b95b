"""The camera images of a run with ground truth as a data set, rendered during the download."""

from __future__ import annotations

from collections.abc import Generator, Iterator
from typing import Any

from flask import Response
from flask_openapi3.blueprint import APIBlueprint
from flask_openapi3.models.tag import Tag

from seamark.server.api.requests.operation_ids import operation_id
from seamark.server.api.requests.schemas import DatasetQuery, RunPath
from seamark.server.programs import own_files
from seamark.server.runs.data.files import RunFiles
from seamark.server.runs.downloads.slow_readers import DownloadSlot, SlotTaken
from seamark.server.runs.record.seeds import seeds_hidden, trial_seeds
from seamark.server.runs.showing.views import RunView
from seamark.server.settings import Settings
from seamark.server.web import access
from seamark.server.web.problems import Problem
from seamark.server.web.services import services
from seamark.sim import registry

IMAGES_MAX = 1200  # per download: a minute of CPU time, a few hundred megabytes
_BUSY_RETRY_S = 20
# Rendering keeps a core busy, and the other threads have pages to serve. A trial may take 250 MB.
_one_at_a_time = DownloadSlot()

api = APIBlueprint(
    "api_datasets",
    __name__,
    url_prefix="/api/v1",
    operation_id_callback=operation_id,
    abp_tags=[Tag(name="Data", description="Data of runs, also while they are live.")],
)


_CONTENT: Any = {200: {"content": {"application/zip": {"schema": {"type": "string"}}}}}


@api.get("/runs/<int:run_id>/dataset.zip", responses=_CONTENT)
def dataset(path: RunPath, query: DatasetQuery) -> Response:
    """Download images with poses, true corners, intrinsics and water properties.

    Not available for ranked runs of the first benchmark versions, whose seeds are hidden.
    `seamark dataset` renders larger data sets, also without a run.
    """
    view = access.run_for(path.run_id)
    if seeds_hidden(view):
        raise Problem(
            "conflict",
            f"The images of a ranked run would reveal the hidden seeds of {view.benchmark}, which "
            "other runs have too. Start a practice run with the same configuration instead.",
        )
    benchmark = registry.benchmark(view.benchmark)
    if benchmark.lacks_images:
        raise Problem(
            "conflict",
            f"A run of {view.benchmark} has no data set: {benchmark.lacks_images}.",
        )
    if benchmark.role == "detector":
        raise Problem(
            "conflict",
            f"A run of {view.benchmark} has no data set. "
            f"`seamark dataset {view.benchmark} --images 1000` draws as many images as you want.",
        )
    files = access.files_of(view)
    try:
        download = _one_at_a_time.take()
    except SlotTaken:
        raise Problem(
            "unavailable",
            "Another data set is being rendered.",
            headers={"Retry-After": str(_BUSY_RETRY_S)},
        ) from None
    try:
        response = Response(
            download.of(_pieces(view, files, query)), content_type="application/zip"
        )
    except BaseException:
        download.close()
        raise
    name = f"seamark-run-{view.id}-dataset.zip"
    response.headers.set("Content-Disposition", "attachment", filename=name)
    return response


def _pieces(view: RunView, files: RunFiles, query: DatasetQuery) -> Generator[bytes, None, None]:
    """Return the pieces of the archive; raises Problem if the selection has none or too many."""
    from seamark.sim.engine.dataset import Selection, archive  # noqa: PLC0415 (it loads OpenCV)

    rows = files.rows_of_trial(query.trial)
    end = float("inf") if query.until is None else query.until
    selection = Selection(every=query.every, begin_s=query.begin, end_s=end, colour=query.colour)
    count = len(selection.of(rows))
    if count == 0:
        raise Problem("not-found", "There is no telemetry for this trial and time yet.")
    if count > IMAGES_MAX:
        raise Problem(
            "invalid-request",
            f"This selects {count} images; the limit is {IMAGES_MAX} per download. Choose a larger "
            "`every` or a shorter time, or render all images with `seamark dataset`.",
        )
    config = registry.benchmark(view.benchmark).restore(view.config)
    seed = trial_seeds(view, services().settings)(query.trial)
    pieces = archive(
        *(view.benchmark, config, rows),
        seed=seed,
        selection=selection,
        program_sha256=view.program_sha256,
    )
    return _each(pieces, view, services().settings)


def _each(
    pieces: Iterator[bytes], view: RunView, settings: Settings
) -> Generator[bytes, None, None]:
    while True:
        with own_files.lent_to(settings, view):  # not across a yield, where others work
            piece = next(pieces, None)
        if piece is None:
            return
        yield piece
