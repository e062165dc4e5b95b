"""Link previews: what other sites show of a page that somebody links to (Open Graph)."""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from pkgutil import resolve_name
from typing import Any

from flask import Blueprint, Response, request, url_for

from seamark.server.pages import benchmarks
from seamark.server.runs import leaderboard
from seamark.server.runs.leaderboard import Rank
from seamark.server.runs.side_by_side import RUNS_MIN
from seamark.server.runs.solutions import solution
from seamark.server.runs.views import RunView
from seamark.server.web import access, caching, compared_runs
from seamark.server.web.problems import Problem
from seamark.server.web.services import services
from seamark.server.web.template_filters import score, score_unit
from seamark.sim import registry
from seamark.sim.benchmarks.benchmark import Benchmark

ROWS = 6  # of a leaderboard that decide its picture
page = Blueprint("link_previews", __name__)


@dataclass(frozen=True, slots=True)
class LinkPreview:
    """Title and sentence of a page, its path and that of its picture."""

    title: str
    description: str
    path: str
    picture: str

    def absolute(self, path: str) -> str:
        """Return an address on the host of the settings; empty without one.

        Never on the host that a client sent, which may be anything.
        """
        return f"{services().settings.url}{path}" if services().settings.url else ""


def of_run(run: RunView) -> LinkPreview:
    """Return the preview of a run."""
    name = registry.benchmark(run.benchmark).title
    return LinkPreview(
        title=f"Run {run.id}: {run.title or solution(run)}",
        description=f"{solution(run)} in {run.benchmark} ({name}): {_result(run)}.",
        path=url_for("run.show", run_id=run.id),
        picture=url_for("link_previews.run_picture", run_id=run.id),
    )


def of_comparison(runs: Sequence[RunView], path: str) -> LinkPreview:
    """Return the preview of a comparison with its address."""
    shown = "; ".join(f"#{run.id} {solution(run)}, {_result(run)}" for run in runs)
    ids = ",".join(str(run.id) for run in runs)
    return LinkPreview(
        title=f"{len(runs)} runs side by side",
        description=f"{shown}.",
        path=path,
        picture=f"{url_for('link_previews.comparison_picture')}?runs={ids}",
    )


def of_leaderboard(benchmark: Benchmark, ranks: Sequence[Rank]) -> LinkPreview:
    """Return the preview of a leaderboard whose first rows are `ranks`."""
    best = next((rank for rank in ranks if not rank.is_baseline), None)
    unit = benchmark.headline.unit
    leader = f" {best.user} leads with {score(best.score)} {unit}." if best is not None else ""
    return LinkPreview(
        title=f"Leaderboard: {benchmark.title}",
        description=f"{benchmark.summary}{leader}",
        path=url_for("leaderboard.show", name=benchmark.name),
        picture=url_for("link_previews.leaderboard_picture", name=benchmark.name),
    )


def _result(run: RunView) -> str:
    if run.score is None:
        return run.state.value
    interval = ""
    if run.score_low is not None and run.score_high is not None:
        interval = f" ({score(run.score_low)} to {score(run.score_high)})"
    return f"{score(run.score)} {score_unit(run)}{interval}"


@page.get("/runs/<row:run_id>/preview.jpg")
def run_picture(run_id: int) -> Response:
    """Draw the picture of a run that the viewer may see."""
    run = access.run_for(run_id)
    benchmarks.by_name(run.benchmark)
    return _answer(_pictures().of_run(services().settings, run))


@page.get("/compare/preview.jpg")
def comparison_picture() -> Response:
    """Draw the picture of a comparison of runs that the viewer may see."""
    runs = compared_runs.runs_of(compared_runs.ids_of(request.args.getlist("runs")))
    if len(runs) < RUNS_MIN:
        raise Problem("invalid-request", "Name the runs, such as runs=12,17.")
    return _answer(_pictures().of_comparison(services().settings, runs))


@page.get("/leaderboards/<name>/preview.jpg")
def leaderboard_picture(name: str) -> Response:
    """Draw the picture of a leaderboard."""
    benchmark = benchmarks.by_name(name)
    with services().database.reading() as session:
        ranks = leaderboard.page(session, name, limit=ROWS)
    return _answer(_pictures().of_leaderboard(benchmark, ranks))


def _pictures() -> Any:
    """Return the module that draws; it loads OpenCV."""
    return resolve_name("seamark.server.runs.preview_pictures")


def _answer(picture: bytes) -> Response:
    answer = Response(picture, content_type="image/jpeg")
    # Pages of other sites show it. Whether it may be seen has been decided already.
    answer.headers["Cross-Origin-Resource-Policy"] = "cross-origin"
    answer.set_etag(hashlib.sha256(picture).hexdigest()[:24])
    return caching.conditional(answer)
