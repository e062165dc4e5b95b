"""The leaderboard of a benchmark."""

from flask import Blueprint, abort, g, redirect, render_template, request, url_for
from flask.typing import ResponseReturnValue

from seamark.server.pages import benchmarks, link_previews
from seamark.server.runs import leaderboard, score_counts
from seamark.server.web.services import services

SIZE = 50
page = Blueprint("leaderboard", __name__, url_prefix="/leaderboards")


@page.get("/")
def first() -> ResponseReturnValue:
    """Go to the leaderboard of the first benchmark."""
    return redirect(url_for("leaderboard.show", name=benchmarks.first().name))


@page.get("/<name>")
def show(name: str) -> ResponseReturnValue:
    """Show a page of the ranks of a benchmark."""
    benchmark = benchmarks.by_name(name)
    after = None
    if text := request.args.get("after"):
        try:
            after = leaderboard.Cursor.parse(text)
        except (ValueError, OverflowError):
            abort(404)
    with services().database.reading() as session:
        ranks = leaderboard.page(session, name, after=after, limit=SIZE + 1)
        count = score_counts.size(session, name)
        mine = None
        if g.viewer.user_id is not None:
            mine = leaderboard.rank_of(session, name, g.viewer.user_id)
    shown = ranks[:SIZE]
    return render_template(
        "leaderboard/show.html",
        benchmark=benchmark,
        benchmarks=benchmarks.labels(),
        ranks=shown,
        next=shown[-1].cursor.text() if len(ranks) > SIZE else None,
        first=after is None,
        count=count,
        mine=mine,
        preview=link_previews.of_leaderboard(benchmark, shown if after is None else ()),
    )
