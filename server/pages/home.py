"""The home page: what Seamark is, how to begin, live numbers and new runs."""

from collections.abc import Sequence

from flask import Blueprint, g, render_template
from flask.typing import ResponseReturnValue
from sqlalchemy.orm import Session

from seamark.server import workers
from seamark.server.accounts.permissions import Action, can
from seamark.server.pages import benchmarks
from seamark.server.pages.player_data import player_data
from seamark.server.runs import leaderboard, totals, views
from seamark.server.runs.files import RunFiles
from seamark.server.runs.leaderboard import Rank
from seamark.server.runs.states import LIVE, RunState
from seamark.server.runs.views import RunFilter, RunView
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
        leader = _leader(session, [rank for _, best in boards for rank in best])
        counts, simulated_s = totals.counts(session), totals.simulated_s(session)
        alive = workers.alive_count(session)
    return render_template(
        "home/index.html",
        benchmark=benchmarks.first(),
        public=public.runs,
        boards=boards,
        leader=leader,
        replay=None if leader is None else player_data(leader, _files(leader)),
        done=counts[RunState.SUCCEEDED],
        live=sum(counts[state] for state in LIVE),
        simulated_h=simulated_s / 3600,
        workers=alive,
    )


def _leader(session: Session, ranks: Sequence[Rank]) -> RunView | None:
    """Return the run of the first of these ranks that can be replayed, marks last; else None."""
    for rank in sorted(ranks, key=lambda one: one.is_baseline):
        run = views.show(session, rank.run_id)
        if run is not None and can(g.viewer, Action.VIEW, run) and _files(run).row_count():
            return run
    return None


def _files(run: RunView) -> RunFiles:
    return RunFiles(services().settings.data, run.id)
