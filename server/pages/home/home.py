"""The home page: what Seamark is, how to begin, live numbers, leaders and new runs."""

from collections.abc import Sequence
from dataclasses import dataclass

from flask import Blueprint, g, render_template
from flask.typing import ResponseReturnValue
from sqlalchemy.orm import Session

from seamark.sandbox.languages import LANGUAGES, kinds
from seamark.server.messaging import workers
from seamark.server.pages.home import demo
from seamark.server.pages.previews import link_previews
from seamark.server.runs.leaderboard import leaderboard, reference_entries
from seamark.server.runs.leaderboard.board_rows import Rank
from seamark.server.runs.leaderboard.reference_entries import ReferenceEntry
from seamark.server.runs.record import totals
from seamark.server.runs.record.states import LIVE, RunState
from seamark.server.runs.showing import run_lists
from seamark.server.runs.showing.run_lists import RunFilter
from seamark.server.web.services import services
from seamark.sim import registry
from seamark.sim.benchmarks.benchmark import Benchmark

NEWEST = 8
BEST = 3
page = Blueprint("home", __name__)


@dataclass(frozen=True, slots=True)
class Board:
    """The leaders of a benchmark, and the reference entries to judge them by."""

    benchmark: Benchmark
    leaders: Sequence[Rank]
    references: Sequence[ReferenceEntry]


@page.get("/")
def show() -> ResponseReturnValue:
    """Show the home page."""
    with services().database.reading() as session:
        public = run_lists.page(session, g.viewer, RunFilter(which="public"), limit=NEWEST)
        boards = _boards(session)
        counts, simulated_s = totals.counts_and_simulated_s(session)
        live = sum(counts[state] for state in LIVE) - reference_entries.live_count(session)
        alive = workers.alive_count(session)
    return render_template(
        "home/index.html",
        public=public.runs,
        boards=boards,
        replay=demo.recording(),
        done=counts[RunState.SUCCEEDED],
        live=max(0, live),
        simulated_h=simulated_s / 3600,
        workers=alive,
        kinds=kinds(LANGUAGES),
        preview=link_previews.of_home(),
    )


def _boards(session: Session) -> list[Board]:
    benchmarks = [registry.benchmark(name) for name in registry.BENCHMARKS]
    leaders = leaderboard.leaders_of(session, benchmarks, BEST)
    references = reference_entries.of_benchmarks(session, benchmarks)
    return [
        Board(
            benchmark,
            leaders[benchmark.name],
            [entry for entry in references[benchmark.name] if not entry.is_bound][:BEST],
        )
        for benchmark in benchmarks
    ]
