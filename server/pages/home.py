"""The home page: what Seamark is, how to begin, live numbers and new runs."""

from flask import Blueprint, g, render_template
from flask.typing import ResponseReturnValue

from seamark.server import workers
from seamark.server.pages import benchmarks, leader_replay
from seamark.server.pages.player_data import player_data
from seamark.server.runs import leaderboard, totals, views
from seamark.server.runs.states import LIVE, RunState
from seamark.server.runs.views import RunFilter
from seamark.server.web.services import services
from seamark.sim import registry

NEWEST = 8
BEST = 3
page = Blueprint("home", __name__)


@page.get("/")
def show() -> ResponseReturnValue:
    """Show the home page."""
    with services().database.reading() as session:
        public = views.page(session, g.viewer, RunFilter(which="public"), limit=NEWEST)
        boards = [
            (registry.benchmark(name), leaderboard.page(session, name, limit=BEST))
            for name in registry.BENCHMARKS
        ]
        leader = leader_replay.leader(session, [rank for _, best in boards for rank in best])
        counts, simulated_s = totals.counts(session), totals.simulated_s(session)
        alive = workers.alive_count(session)
    return render_template(
        "home/index.html",
        benchmark=benchmarks.first(),
        public=public.runs,
        boards=boards,
        leader=leader,
        replay=None if leader is None else player_data(leader, leader_replay.files(leader)),
        done=counts[RunState.SUCCEEDED],
        live=sum(counts[state] for state in LIVE),
        simulated_h=simulated_s / 3600,
        workers=alive,
    )
