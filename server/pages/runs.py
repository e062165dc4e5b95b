"""My runs: newest first, by state, in parts of a fixed size."""

from flask import Blueprint, g, render_template, request
from flask.typing import ResponseReturnValue

from server import runs
from server.pages import benchmarks
from server.pages.row_numbers import row_number
from server.services import services

SIZE = 25
page = Blueprint("runs", __name__, url_prefix="/runs")


@page.get("/")
def mine() -> ResponseReturnValue:
    """Show the viewer's own runs; an admin may look at everybody's."""
    wanted = request.args.get("state", "")
    states = (runs.RunState(wanted),) if wanted in list(runs.RunState) else ()
    everybody = g.viewer.is_admin and request.args.get("of") == "all"
    settings = services().settings
    with services().database.reading() as session:
        part = runs.listing(
            session,
            g.viewer,
            which="all" if everybody else "mine",
            states=states,
            after=request.args.get("after", type=row_number),
            limit=SIZE,
        )
        quota = None if g.viewer.owner is None else runs.quota(session, g.viewer, settings)
    return render_template(
        "runs/mine.html",
        part=part,
        states=list(runs.RunState),
        chosen=states[0] if states else "",
        everybody=everybody,
        first="after" not in request.args,
        quota=quota,
        labels=benchmarks.labels(),
    )
