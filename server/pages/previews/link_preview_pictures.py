"""The pictures of link previews, as JPEG for the crawlers of other sites."""

import hashlib
from pkgutil import resolve_name
from typing import Any

from flask import Blueprint, Response, request

from seamark.server.pages.previews.link_previews import HOME_SENTENCE, HOME_TITLE
from seamark.server.runs.leaderboard import leaderboard
from seamark.server.runs.showing.side_by_side import RUNS_MIN
from seamark.server.web import access, caching, compared_runs, known_benchmarks
from seamark.server.web.problems import Problem
from seamark.server.web.services import services

ROWS = 6  # of a leaderboard that decide its picture
page = Blueprint("link_preview_pictures", __name__)


@page.get("/preview.jpg")
def home_picture() -> Response:
    """Draw the picture of the home page."""
    return _answer(_pictures().of_home(HOME_TITLE, HOME_SENTENCE))


@page.get("/benchmarks/<name>/preview.jpg")
def benchmark_picture(name: str) -> Response:
    """Draw the picture of a benchmark."""
    return _answer(_pictures().of_benchmark(known_benchmarks.by_name(name)))


@page.get("/runs/<row:run_id>/preview.jpg")
def run_picture(run_id: int) -> Response:
    """Draw the picture of a run that the viewer may see."""
    run = access.run_for(run_id)
    known_benchmarks.by_name(run.benchmark)
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
    benchmark = known_benchmarks.by_name(name)
    with services().database.reading() as session:
        ranks = leaderboard.page(session, name, limit=ROWS)
    return _answer(_pictures().of_leaderboard(benchmark, ranks))


def _pictures() -> Any:
    """Return the module that draws; it loads OpenCV."""
    return resolve_name("seamark.server.runs.showing.preview_pictures")


def _answer(picture: bytes) -> Response:
    answer = Response(picture, content_type="image/jpeg")
    # Pages of other sites show it. Whether it may be seen has been decided already.
    answer.headers["Cross-Origin-Resource-Policy"] = "cross-origin"
    answer.set_etag(hashlib.sha256(picture).hexdigest()[:24])
    return caching.conditional(answer)
