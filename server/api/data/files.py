"""The data of a run as files, at any time, also while it is running."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from flask import Response, jsonify
from flask_openapi3.blueprint import APIBlueprint
from flask_openapi3.models.tag import Tag

from seamark.server.accounts.permissions import Action
from seamark.server.api.requests.file_answers import answers_with
from seamark.server.api.requests.operation_ids import operation_id
from seamark.server.api.requests.schemas import (
    CameraQuery,
    LogQuery,
    PartPath,
    RunPath,
    TelemetryQuery,
)
from seamark.server.programs import own_files, store
from seamark.server.runs.data.files import RunFiles
from seamark.server.runs.record.seeds import seeds_hidden
from seamark.server.runs.showing.views import RunView
from seamark.server.storage import storage
from seamark.server.web import access, caching
from seamark.server.web.citation import with_publication
from seamark.server.web.problems import Problem
from seamark.server.web.services import services
from seamark.sim import registry
from seamark.sim.recording import telemetry
from seamark.sim.settings import grid

CHUNK_ROWS = 500
HIDDEN, DISCLOSED = "hidden", "of each trial in manifest.json"
_SEED_KEYS = frozenset({"seed", "seeds", "hidden_seed", "trial_seed", "trial_seeds"})

api = APIBlueprint(
    "api_files",
    __name__,
    url_prefix="/api/v1",
    operation_id_callback=operation_id,
    abp_tags=[Tag(name="Data", description="The data of a run, at any time.")],
)


@api.get("/runs/<int:run_id>/telemetry.csv", responses=answers_with("text/csv"))
def telemetry_csv(path: RunPath, query: TelemetryQuery) -> Response:
    """Download all rows so far: comment lines with #, the header row, one row per 0.05 s."""
    view = access.run_for(path.run_id)
    files = access.files_of(view)
    stop = files.row_count()
    answer = Response(
        _csv(files, comments(view, files, stop), query.start, stop),
        content_type="text/csv; charset=utf-8",
    )
    as_attachment(answer, view, "telemetry.csv")
    answer.headers["X-Next-Row"] = str(max(stop, query.start))
    return answer


def _csv(files: RunFiles, lines: list[str], start: int, stop: int) -> Iterator[str]:
    yield telemetry.header(lines, width=len(files.columns))
    for at in range(start, stop, CHUNK_ROWS):
        yield telemetry.csv_lines(files.rows(at, min(at + CHUNK_ROWS, stop)))


def comments(view: RunView, files: RunFiles, rows: int) -> list[str]:
    """Return the lines above the rows of a CSV."""
    benchmark = registry.benchmark(view.benchmark)
    solution = view.program_name or benchmark.solution_label_of(view.controller, view.config)
    seed = view.seed if view.seed is not None else HIDDEN if seeds_hidden(view) else DISCLOSED
    return [
        f"Seamark run {view.id}: {view.benchmark}, {benchmark.role} {solution}",
        f"kind {view.kind}, seed {seed}, trials {view.trials}",
        f"state {view.state.value} at the time of the download, {rows} rows",
        *grid.level_comments(benchmark.restore(view.config)),
        telemetry.units(len(files.columns)),
    ]


@api.get("/runs/<int:run_id>/telemetry.f64", responses=answers_with("application/octet-stream"))
def telemetry_f64(path: RunPath, query: TelemetryQuery) -> Response:
    """Download all rows so far as little-endian float64.

    X-Columns names the columns, X-Units their units; a column without one has an empty unit.
    """
    view = access.run_for(path.run_id)
    files = access.files_of(view)
    stop = files.row_count()
    pieces = (
        files.rows(at, min(at + CHUNK_ROWS, stop)).astype("<f8").tobytes()
        for at in range(query.start, stop, CHUNK_ROWS)
    )
    answer = Response(pieces, content_type="application/octet-stream")
    answer.headers["X-Columns"] = ",".join(files.columns)
    units = (column.unit for column in telemetry.columns(len(files.columns)))
    answer.headers["X-Units"] = ",".join(units)
    answer.headers["X-Next-Row"] = str(max(stop, query.start))
    as_attachment(answer, view, "telemetry.f64")
    return answer


@api.get("/runs/<int:run_id>/metrics.json", responses=answers_with("application/json", "object"))
def metrics(path: RunPath) -> Response:
    """Return the metrics; 404 until there are some."""
    view = access.run_for(path.run_id)
    document = view.metrics or access.files_of(view).metrics()
    if document is None:
        raise Problem("not-found", f"Run {view.id} has no metrics yet: it is {view.state.value}.")
    return jsonify(without_hidden_seeds(document, view))


@api.get("/runs/<int:run_id>/manifest.json", responses=answers_with("application/json", "object"))
def manifest(path: RunPath) -> Response:
    """Return the manifest: versions, configuration, seed and digest; 404 until there is one.

    `seeds` has the seed of each trial of a ranked run of a benchmark with fresh trials. Those of
    the first benchmark versions stay hidden, because all of their ranked runs have the same ones.
    """
    view = access.run_for(path.run_id)
    document = view.manifest or access.files_of(view).manifest()
    if document is None:
        raise Problem("not-found", f"Run {view.id} has no manifest yet: it is {view.state.value}.")
    whole = own_files.with_texts(document, view, services().settings)
    return jsonify(with_publication(without_hidden_seeds(whole, view), view))


def without_hidden_seeds(value: Any, view: RunView) -> Any:
    """Return the document, without its seeds if they are hidden."""
    return _without_seeds(value) if seeds_hidden(view) else value


def _without_seeds(value: Any) -> Any:
    if isinstance(value, dict):
        return {
            key: None if key in _SEED_KEYS else _without_seeds(item) for key, item in value.items()
        }
    return [_without_seeds(item) for item in value] if isinstance(value, list) else value


@api.get("/runs/<int:run_id>/config.json", responses=answers_with("application/json", "object"))
def config(path: RunPath) -> Response:
    """Download the configuration; `seamark run --config` reads it."""
    view = access.run_for(path.run_id)
    answer = jsonify(view.config)
    as_attachment(answer, view, "config.json")
    return answer


@api.get("/runs/<int:run_id>/log", responses=answers_with("text/plain"))
def log(path: RunPath, query: LogQuery) -> Response:
    """Return the output of the program from byte `after` on; X-Next-Offset is the next `after`."""
    view = access.run_for(path.run_id, Action.VIEW_LOG)
    part = access.files_of(view).log(query.after)
    answer = Response(part.text, content_type="text/plain; charset=utf-8")
    answer.headers["X-Next-Offset"] = str(max(part.next, query.after))
    answer.headers["X-Dropped-Bytes"] = str(part.dropped)
    return answer


@api.get("/runs/<int:run_id>/program", responses=answers_with("text/plain"))
def program(path: RunPath) -> Response:
    """Download the uploaded program of your own or of a public run."""
    view = access.run_for(path.run_id, Action.VIEW_PROGRAM)
    if view.program_sha256 is None:
        raise Problem("not-found", f"Run {view.id} has no uploaded program.")
    return _source(view, view.program_sha256, view.program_name or "program")


@api.get("/runs/<int:run_id>/parts/<role>", responses=answers_with("text/plain"))
def part(path: PartPath) -> Response:
    """Download a further program of your own or of a public run, by its role."""
    view = access.run_for(path.run_id, Action.VIEW_PROGRAM)
    found = next((one for one in view.parts if one.role == path.role), None)
    if found is None:
        raise Problem("not-found", f"Run {view.id} has no uploaded {path.role}.")
    return _source(view, found.program_sha256, found.program_name or found.role)


def _source(view: RunView, sha256: str, name: str) -> Response:
    """Return a program of a run as a file."""
    storage.require_readable(services().settings)
    try:
        source = store.read(services().settings, sha256)
    except FileNotFoundError:
        raise Problem("not-found", "The program has been deleted.") from None
    answer = Response(source, content_type="text/plain; charset=utf-8")
    as_attachment(answer, view, name)
    answer.set_etag(sha256)
    return caching.conditional(answer)


@api.get("/runs/<int:run_id>/camera.jpg", responses=answers_with("image/jpeg"))
def camera(path: RunPath, query: CameraQuery) -> Response:
    """Render the camera image at a simulated time; with neither outline it is the bare image."""
    from seamark.server.runs.showing import camera_view  # noqa: PLC0415 (it loads OpenCV)
    from seamark.sim.engine.replay import NoCameraOnArm, NoSonar  # noqa: PLC0415 (it loads OpenCV)

    view = access.run_for(path.run_id)
    access.require_data(view)
    drawn = camera_view.Drawn(tracked=query.tracked, truth=query.truth)
    if query.camera == "arm":
        drawn = camera_view.ON_ARM
    elif query.camera == "sonar":
        drawn = camera_view.SONAR
    try:
        image = camera_view.render(
            services().settings, view, trial=query.trial, t=query.t, drawn=drawn
        )
    except (NoCameraOnArm, NoSonar) as missing:
        raise Problem("not-found", str(missing)) from None
    if image is None:
        raise Problem("not-found", "There is no telemetry of that trial yet.")
    answer = Response(image, content_type="image/jpeg")
    answer.add_etag()
    return caching.conditional(answer)


def as_attachment(answer: Response, view: RunView, name: str) -> None:
    """Name the file as which a browser stores the answer."""
    answer.headers.set(
        "Content-Disposition", "attachment", filename=f"seamark-run-{view.id}-{name}"
    )
