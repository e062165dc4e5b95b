"""The home page: what Seamark is, how to begin, live numbers, leaders and new runs."""

from collections.abc import Sequence
from dataclasses import dataclass

from flask import Blueprint, flash, g, redirect, render_template, url_for
from flask.typing import ResponseReturnValue
from sqlalchemy.orm import Session

from seamark.server import workers
from seamark.server.accounts.permissions import Action
from seamark.server.pages import benchmarks, leader_replay
from seamark.server.pages.player_data import player_data
from seamark.server.runs import leaderboard, reference_entries, run_lists, submission, totals
from seamark.server.runs.leaderboard import Rank
from seamark.server.runs.quota import QuotaExceeded
from seamark.server.runs.reference_entries import ReferenceEntry
from seamark.server.runs.run_lists import RunFilter
from seamark.server.runs.states import LIVE, RunKind, RunState
from seamark.server.runs.submission import Submission
from seamark.server.runs.views import RunView
from seamark.server.storage import StorageUnavailable
from seamark.server.web import access, authentication
from seamark.server.web.rate_limits import SUBMISSIONS, client, limiter
from seamark.server.web.services import services
from seamark.sim import registry
from seamark.sim.benchmarks.benchmark import Benchmark

NEWEST = 8
BEST = 3
DEMO_CONTROLLER = "pi"
DEMO_TITLE = "Demo: the built-in PI controller"
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
        candidates = _candidates(session, boards)
        counts, simulated_s = totals.counts_and_simulated_s(session)
        live = sum(counts[state] for state in LIVE) - reference_entries.live_count(session)
        alive = workers.alive_count(session)
    replay = leader_replay.first_replayable(candidates)
    return render_template(
        "home/index.html",
        public=public.runs,
        boards=boards,
        replayed=replay,
        replay=None if replay is None else player_data(replay, leader_replay.files(replay)),
        done=counts[RunState.SUCCEEDED],
        live=max(0, live),
        simulated_h=simulated_s / 3600,
        workers=alive,
    )


@page.post("/demo")
@limiter.limit(SUBMISSIONS, key_func=client)
def demo() -> ResponseReturnValue:
    """Start a run of a built-in controller; show a finished one if no worker is free for it."""
    access.require_scope(Action.SUBMIT)
    with services().database.reading() as session:
        candidates = _candidates(session, _boards(session))
        free = workers.slot_count(session) - totals.counts(session)[RunState.RUNNING]
    replay = leader_replay.first_replayable(candidates)
    if free <= 0 and replay is not None:
        flash("All workers are busy, so this is a replay. Press Play.")
        return redirect(url_for("run.show", run_id=replay.id), code=303)
    run_id: int | None
    try:
        run_id = _start_demo()
    except (QuotaExceeded, StorageUnavailable) as refusal:
        flash(str(refusal), "warn")
        run_id = None if replay is None else replay.id
    else:
        services().wake_worker()  # only after the commit: the worker must find the row
    if run_id is None:
        return redirect(url_for("home.show"), code=303)
    return redirect(url_for("run.show", run_id=run_id), code=303)


def _start_demo() -> int:
    run = Submission(
        viewer=authentication.become_guest(),
        benchmark=benchmarks.first().name,
        config={},
        kind=RunKind.PRACTICE,
        controller=DEMO_CONTROLLER,
        title=DEMO_TITLE,
    )
    valid = submission.validate(run, services().settings)
    with services().database.writing() as session:
        return submission.submit(session, valid, services().settings)


def _boards(session: Session) -> list[Board]:
    found = [registry.benchmark(name) for name in registry.BENCHMARKS]
    leaders = leaderboard.leaders_of(session, found, BEST)
    references = reference_entries.of_benchmarks(session, found)
    return [
        Board(
            benchmark,
            leaders[benchmark.name],
            [entry for entry in references[benchmark.name] if not entry.is_bound][:BEST],
        )
        for benchmark in found
    ]


def _candidates(session: Session, boards: Sequence[Board]) -> list[RunView]:
    """Return the runs that may be replayed: of leaders, then of reference entries."""
    leaders = [rank.run_id for board in boards for rank in board.leaders]
    references = [entry.run_id for board in boards for entry in board.references]
    return leader_replay.first(session, filter(None, (*leaders, *references)))
