"""The leaderboard of a benchmark."""

from collections.abc import Collection, Mapping
from typing import Any

from flask import Blueprint, abort, g, redirect, render_template, request, url_for
from flask.typing import ResponseReturnValue
from sqlalchemy.orm import Session

from seamark.sandbox.languages import LANGUAGES
from seamark.server.pages.charts import plots
from seamark.server.pages.leaderboard import leader_replay
from seamark.server.pages.leaderboard.rank_plot import rank_plot
from seamark.server.pages.previews import link_previews
from seamark.server.pages.run.player_data import player_data
from seamark.server.runs.leaderboard import (
    leaderboard,
    leaderboard_filters,
    rank_history,
    reference_entries,
    score_counts,
)
from seamark.server.runs.leaderboard.board_rows import Cursor, Rank
from seamark.server.runs.leaderboard.leaderboard import Kind
from seamark.server.runs.leaderboard.leaderboard_filters import (
    BUILT_IN,
    HIDE,
    ONLY,
    SORTED_MAX,
    UPLOADED,
    BoardFilter,
    BoardPage,
)
from seamark.server.runs.leaderboard.per import Per
from seamark.server.runs.leaderboard.reference_entries import ReferenceEntry
from seamark.server.runs.recomputation import verifications
from seamark.server.runs.record.solutions import entry_name
from seamark.server.web import known_benchmarks
from seamark.server.web.services import services
from seamark.sim.benchmarks.benchmark import Benchmark
from seamark.sim.metrics.metric import Metric
from seamark.sim.numerics.ranking import Population
from seamark.sim.settings.setting import schema_extras

SIZE = 50
FILTERS = ("program", "language", "vehicle", "tracker", "baselines")
Labels = dict[str, dict[str, str]]  # filter -> value -> label
page = Blueprint("leaderboard", __name__, url_prefix="/leaderboards")


@page.get("/")
def first() -> ResponseReturnValue:
    """Go to the leaderboard of the first benchmark."""
    return redirect(url_for("leaderboard.show", name=known_benchmarks.first().name))


@page.get("/<name>")
def show(name: str) -> ResponseReturnValue:
    """Show a page of the ranks of a benchmark."""
    benchmark = known_benchmarks.by_name(name)
    after, chosen = _after(), _filter()
    metric = next((m for m in benchmark.board_metrics if m.name == request.args.get("sort")), None)
    begin, labels = after is None, _labels(benchmark)
    with services().database.reading() as session:
        numbers = score_counts.numbers(session, name)
        population = score_counts.population(session, name, chosen.per, number=numbers[chosen.per])
        board = _page(session, benchmark, chosen, metric, after=after, population=population)
        marks = reference_entries.entries(session, benchmark)
        pending = reference_entries.are_pending(session, benchmark, marks)
        leaders = leader_replay.leaders(session, board.ranks) if begin and not metric else ()
        own = _own(session, name, chosen.per, population)
        verified = verifications.newest(session, [rank.run_id for rank in board.ranks])
        offered = _choices(session, name, chosen.per, board, labels)
    leader = leader_replay.first_replayable(leaders)
    return render_template(
        "leaderboard/show.html",
        benchmark=benchmark,
        benchmarks=known_benchmarks.menu(),
        newer=known_benchmarks.newer_than(name),
        ranks=board.ranks,
        verified=verified,
        next=board.next.text() if board.next else None,
        first=begin,
        count=population.size,
        marks=marks,
        pending=pending,
        per_method=chosen.per is Per.METHOD,
        several_methods="per" in request.args or numbers[Per.METHOD] > numbers[Per.PERSON],
        labels=labels,
        filters=_filters(labels, offered),
        sortable=bool(benchmark.board_metrics) and population.size > 1,
        query={key: value for key, value in request.args.items() if key != "after"},
        metric=metric,
        shown_metric=metric or next(iter(benchmark.board_metrics), None),
        sorted_max=SORTED_MAX,
        axis=plots.score_axis(board.ranks, marks, whole="whole" in request.args),
        whole_axis=plots.score_axis(board.ranks[:1], marks, whole=True),
        pareto=_pareto(benchmark, chosen.per, board.ranks, marks),
        leader=leader,
        replay=leader and player_data(leader, leader_replay.files(leader)),
        preview=link_previews.of_leaderboard(benchmark, board.ranks if begin else ()),
        **own,
    )


def _after() -> Cursor | None:
    text = request.args.get("after")
    if not text:
        return None
    try:
        return Cursor.parse(text)
    except (ValueError, OverflowError):
        abort(404)


def _filter() -> BoardFilter:
    values = {key: request.args.get(key, "") for key in FILTERS}
    mine = g.viewer.user_id if request.args.get("mine") else None
    per = Per.METHOD if request.args.get("per") == Per.METHOD else Per.PERSON
    return BoardFilter(**values, per=per, user_id=mine)


def _page(
    session: Session,
    benchmark: Benchmark,
    chosen: BoardFilter,
    metric: Metric | None,
    *,
    after: Cursor | None,
    population: Population,
) -> BoardPage:
    name = benchmark.name
    if metric is None:
        return leaderboard_filters.page(
            session, name, chosen, after=after, limit=SIZE, population=population
        )
    ranks = leaderboard_filters.by_metric(
        session, name, metric, chosen, limit=SIZE, population=population
    )
    return BoardPage(ranks, None)


def _own(session: Session, name: str, per: Per, population: Population) -> dict[str, Any]:
    """Return the viewer's best row and, of the one per person, the history of its rank."""
    user_id = g.viewer.user_id
    if user_id is None:
        return {"mine": None, "history": None}
    mine = leaderboard.rank_of(session, name, user_id, per=per, population=population)
    if per is Per.METHOD:
        return {"mine": mine, "history": None}
    points = rank_history.of_user(session, user_id, name)
    return {"mine": mine, "history": rank_plot(points, None if mine is None else mine.rank)}


def _pareto(
    benchmark: Benchmark, per: Per, ranks: list[Rank], marks: list[ReferenceEntry]
) -> plots.ParetoPlot | None:
    """Return the plot of the rows of this page and of all reference entries."""
    if benchmark.pareto is None:
        return None
    named = [
        (entry_name(rank) if per is Per.METHOD else rank.user, rank)
        for rank in ranks
        if not rank.is_baseline
    ]
    entries: list[tuple[str, plots.Plotted]] = [*named, *((mark.title, mark) for mark in marks)]
    front = leaderboard_filters.undominated([entry for _, entry in entries], *benchmark.pareto)
    return plots.pareto_plot(entries, front, benchmark.pareto)


def _choices(
    session: Session, name: str, per: Per, board: BoardPage, labels: Labels
) -> Mapping[str, Collection[str]]:
    """Return filter -> values of which some rows pass and others do not.

    Of a leaderboard of several pages all values are offered: looking for them would take too long.
    """
    if request.args:
        kinds = leaderboard.kinds(session, name, per=per, limit=leaderboard_filters.SEEN_MAX)
        return leaderboard_filters.choices(kinds)
    if board.next is not None:
        return {name: list(values) for name, values in labels.items()}
    rows = ((one.language, one.vehicle, one.tracker, one.is_baseline) for one in board.ranks)
    return leaderboard_filters.choices(Kind(*row) for row in rows)


def _filters(labels: Labels, offered: Mapping[str, Collection[str]]) -> Labels:
    """Return filter -> value -> label, of what is offered and of what has been chosen."""
    chosen = {name: [value] for name in FILTERS if (value := request.args.get(name))}
    values = {name: sorted({*offered.get(name, ()), *chosen.get(name, ())}) for name in labels}
    return {
        name: {value: labels[name].get(value, value) for value in choices}
        for name, choices in values.items()
        if choices
    }


def _labels(benchmark: Benchmark) -> Labels:
    """Return filter -> value -> label."""
    choices = {
        "program": {UPLOADED: "Uploaded", BUILT_IN: "Built in"},
        "language": {name: each.short_label for name, each in LANGUAGES.items()},
    }
    settings = benchmark.configuration.model_fields
    for name in ("vehicle", "tracker"):
        if name in settings:
            labels: dict[str, str] = schema_extras(settings[name]).get("x-labels", {})
            choices[name] = {key: _short(label) for key, label in labels.items()}
    choices["baselines"] = {HIDE: "Hidden", ONLY: "Nothing else"}
    return choices


def _short(label: str) -> str:
    """Return a label of the form without what it explains."""
    return label.partition(";")[0].partition(" (")[0]
