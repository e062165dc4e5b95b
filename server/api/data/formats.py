"""Runs in the formats of other programs, at any time, also while they are running."""

from __future__ import annotations

import hashlib
from typing import Any

from flask import Response, g, request
from flask_openapi3.blueprint import APIBlueprint
from flask_openapi3.models.tag import Tag

from seamark.formats.registry import FORMATS, REVISION, Format
from seamark.formats.ros import layout
from seamark.server.accounts.permissions import Action, Viewer, can
from seamark.server.api.data import files as run_files
from seamark.server.api.requests.file_answers import answers_with
from seamark.server.api.requests.operation_ids import operation_id
from seamark.server.api.requests.schemas import RunPath
from seamark.server.programs import own_files, store
from seamark.server.runs.data.files import RunFiles
from seamark.server.runs.downloads.conversions import Job
from seamark.server.runs.publication import citations
from seamark.server.runs.record.seeds import trial_seeds
from seamark.server.runs.showing.views import RunView
from seamark.server.web import access, caching, rate_limits
from seamark.server.web.citation import citation_of, with_publication
from seamark.server.web.problems import Problem
from seamark.server.web.services import services
from seamark.sim.recording.manifest import versions

api = APIBlueprint(
    "api_formats",
    __name__,
    url_prefix="/api/v1",
    operation_id_callback=operation_id,
    abp_tags=[Tag(name="Data", description="The data of a run, at any time.")],
)


def _add(kind: Format) -> None:
    """Add the download of a format; its name and text are those of the registry."""

    def download(path: RunPath) -> Response:
        return _converted(path.run_id, FORMATS[kind.name])

    named = kind.file.startswith(kind.name)
    download.__name__ = kind.name if named else kind.file.replace(".", "_")
    download.__doc__ = kind.document
    rule = f"/runs/<int:run_id>/{kind.file}"
    api.get(rule, responses=answers_with(kind.media_type))(download)


for _kind in FORMATS.values():
    if _kind.converted:
        _add(_kind)


@api.get("/foxglove-layout.json", responses=answers_with("application/json", "object"))
def foxglove_layout() -> Response:
    """Download the layout with which Foxglove shows a run that was downloaded as MCAP."""
    answer = Response(layout.TEXT, content_type="application/json")
    answer.headers.set("Content-Disposition", "attachment", filename=layout.FILE)
    answer.add_etag()
    return caching.conditional(answer)


def _converted(run_id: int, kind: Format) -> Response:
    view = access.run_for(run_id)
    files = access.files_of(view)
    job, programs = _job(view, files, kind)
    if reason := kind.refusal(job.rows):
        raise Problem("conflict", reason)
    line = job.request(kind, files)
    version = f"{versions()['seamark']} {REVISION}"
    answer = Response(content_type=kind.media_type)
    answer.set_etag(hashlib.sha256(line + version.encode()).hexdigest())
    run_files.as_attachment(answer, view, kind.file)
    if request.if_none_match.contains(answer.get_etag()[0] or ""):
        return caching.conditional(answer)
    conversion = services().conversions.start(line + programs, owner=rate_limits.client())
    answer.response = conversion  # which is closed with it
    return answer


def _job(view: RunView, files: RunFiles, kind: Format) -> tuple[Job, bytes]:
    """Return what is to be written, and the programs if the archive has them."""
    count = files.row_count()
    settings = services().settings
    manifest = view.manifest or files.manifest()
    metrics = view.metrics or files.metrics()
    program = _program(view, view.program_sha256) if kind.whole else None
    parts = _parts(view) if kind.whole else {}
    job = Job(
        title=f"Run {view.id}",
        benchmark=view.benchmark,
        config=view.config,
        rows=count,
        seeds=list(map(trial_seeds(view, settings), range(view.trials))) if kind.images else None,
        comments=run_files.comments(view, files, count),
        manifest=_manifest(view, manifest),
        files=_files(view),
        metrics=run_files.without_hidden_seeds(metrics, view),
        program=None if program is None else view.program_name or "program",
        parts=[
            (part.role, part.program_name or part.role, len(parts[part.role]))
            for part in view.parts
            if part.role in parts
        ],
        extra_files=_citation(view) if kind.whole else {},
    )
    return job, b"".join((program or b"", *parts.values()))


def _manifest(view: RunView, manifest: Any) -> Any:
    """Return the manifest as it may be shown; a run that has not ended has none."""
    if manifest is None:
        return None
    whole = own_files.with_texts(manifest, view, services().settings)
    return with_publication(run_files.without_hidden_seeds(whole, view), view)


def _files(view: RunView) -> dict[str, str]:
    """Return setting -> file of the run's own, those that were not deleted."""
    contents = own_files.contents_of(view, services().settings)
    return {setting: content.decode("utf-8") for setting, content in contents.items()}


def _citation(view: RunView) -> dict[str, str]:
    """Return the files by which the archive of a public run is cited and deposited."""
    return dict(citations.files(citation_of(view))) if view.public else {}


def _parts(view: RunView) -> dict[str, bytes]:
    """Return role -> further program, those that the viewer may have."""
    found = {part.role: _program(view, part.program_sha256) for part in view.parts}
    return {role: content for role, content in found.items() if content is not None}


def _program(view: RunView, sha256: str | None) -> bytes | None:
    """Return an uploaded program if the viewer may have it; None too if it was deleted."""
    viewer: Viewer = g.viewer
    if sha256 is None or not can(viewer, Action.VIEW_PROGRAM, view):
        return None
    try:
        return store.read(services().settings, sha256)
    except FileNotFoundError:
        return None
