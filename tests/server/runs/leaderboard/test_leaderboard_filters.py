"""Leaderboards with filters, in other orders, and the history of ranks."""

from typing import Any

import pytest
from sqlalchemy import select, update

from seamark.server.database.tables import Best, User
from seamark.server.runs.leaderboard import (
    best_runs,
    leaderboard,
    leaderboard_filters,
    rank_history,
)
from seamark.server.runs.leaderboard.board_rows import Rank
from seamark.server.runs.leaderboard.leaderboard_filters import BoardFilter
from seamark.server.runs.publication import publications
from seamark.server.runs.publication.publications import Terms
from seamark.server.runs.record.states import RunKind
from seamark.sim import registry
from seamark.sim.metrics.metric import Metric
from tests.cast import Backend

NAME = "currents-v1"
RMSE, ENERGY = registry.benchmark(NAME).pareto or pytest.fail("currents-v1 has a Pareto plot")


def _entry(
    both: Backend,
    who: str,
    score: float,
    *,
    uploaded: bool = False,
    rmse_m: float = 1.0,
    energy: float = 1.0,
) -> int:
    """Publish a ranked run of somebody new."""
    if who not in both.viewers:
        both.sign_up(who)
    program = {"controller": "upload", "program": both.store_program()} if uploaded else {}
    claim = both.running(who, kind=RunKind.RANKED, **program)
    levels = [{RMSE.name: rmse_m, ENERGY.name: energy}] * 2
    assert both.finish(claim, score=score, metrics={"score": score, "levels": levels})
    with both.database.writing() as session:
        # baselines are public already
        publications.publish(session, claim.run_id, Terms(method="Steady hand"))
    return claim.run_id


def _mark(both: Backend, who: str, score: float) -> None:
    """Publish a ranked run of a new baseline."""
    both.sign_up(who)
    with both.database.writing() as session:
        session.get_one(User, both.user_id(who)).is_baseline = True
    _entry(both, who, score)


def _shown(both: Backend, limit: int = 50, **chosen: Any) -> list[tuple[str, int | None]]:
    """Return users and ranks of all pages."""
    found: list[Rank] = []
    after = None
    with both.database.reading() as session:
        while True:
            page = leaderboard_filters.page(
                session, NAME, BoardFilter(**chosen), after=after, limit=limit
            )
            found += page.ranks
            after = page.next
            if after is None:
                return [(rank.user, rank.rank) for rank in found]


@pytest.fixture
def board(both: Backend) -> Backend:
    """Four people and a baseline."""
    _entry(both, "ann", 90.0, uploaded=True)
    _entry(both, "ben", 80.0)
    _entry(both, "eva", 70.0, uploaded=True)
    _entry(both, "tim", 60.0)
    _mark(both, "oracle", 95.0)
    with both.database.writing() as session:
        for who in ("eva", "tim"):
            session.execute(
                update(Best).where(Best.user_id == both.user_id(who)).values(vehicle="other")
            )
    return both


def test_filters_keep_the_ranks_among_all_people(board: Backend) -> None:
    eva = board.user_id("eva")

    assert _shown(board, program="uploaded") == [("ann", 1), ("eva", 3)]
    assert _shown(board, language="python", vehicle="other") == [("eva", 3)]
    assert _shown(board, program="built-in", baselines="hide") == [("ben", 2), ("tim", 4)]
    assert _shown(board, baselines="only") == [("oracle", None)]
    assert _shown(board, user_id=eva) == [("eva", 3)]
    assert _shown(board, user_id=eva, program="built-in") == []


@pytest.mark.parametrize("limit", [1, 2])
def test_the_pages_of_a_filter_are_all_rows_that_pass_it(board: Backend, limit: int) -> None:
    filters: tuple[dict[str, Any], ...] = ({"vehicle": "other"}, {"baselines": "hide"}, {})
    for chosen in filters:
        assert _shown(board, limit=limit, **chosen) == _shown(board, **chosen)


@pytest.mark.slow
def test_a_filter_that_few_rows_pass_goes_on_behind_the_rows_it_looked_at(
    board: Backend, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(leaderboard_filters, "SEEN_MAX", 2)

    assert _shown(board, vehicle="other") == [("eva", 3), ("tim", 4)]


def test_another_metric_sorts_the_rows_and_leaves_the_ranks(both: Backend) -> None:
    _entry(both, "ann", 90.0, energy=5.0)
    _entry(both, "ben", 80.0, energy=1.0)
    _entry(both, "eva", 70.0, energy=3.0)

    with both.database.reading() as session:
        found = leaderboard_filters.by_metric(session, NAME, ENERGY, BoardFilter())

    # the energy of a run is the sum over its levels
    shown = [(rank.user, rank.rank, rank.metrics[ENERGY.name]) for rank in found]
    assert shown == [("ben", 2, 2.0), ("eva", 3, 6.0), ("ann", 1, 10.0)]


def test_only_rows_that_no_other_one_beats_in_both_are_on_the_front(backend: Backend) -> None:
    _entry(backend, "ann", 90.0, rmse_m=0.1, energy=9.0)
    _entry(backend, "ben", 80.0, rmse_m=0.2, energy=2.0)
    _entry(backend, "eva", 70.0, rmse_m=0.3, energy=3.0)
    _entry(backend, "tim", 60.0, rmse_m=0.4, energy=1.0)

    with backend.database.reading() as session:
        ranks = leaderboard.page(session, NAME)

    front = leaderboard_filters.undominated(ranks, RMSE, ENERGY)
    assert [rank.user for rank in front] == ["ann", "ben", "tim"]
    none = Metric("no_such_metric", "", "", "lower")
    assert leaderboard_filters.undominated(ranks, RMSE, none) == []


def test_the_history_of_a_rank_has_a_point_for_each_change_of_the_own_row(backend: Backend) -> None:
    _entry(backend, "ann", 50.0)
    first = _entry(backend, "ben", 40.0)
    second = _entry(backend, "ben", 60.0)
    _entry(backend, "ben", 30.0)  # not the best: nothing changes
    for run_id in (second, first):
        with backend.database.writing() as session:
            publications.withdraw(session, run_id)
    with backend.database.reading() as session:
        points = rank_history.of_user(session, backend.user_id("ben"), NAME)

    assert [(point.rank, point.people, point.score) for point in points] == [
        (2, 2, 40.0),
        (1, 2, 60.0),
        (2, 2, 40.0),
        (2, 2, 30.0),
    ]


def test_a_history_keeps_its_newest_points(
    backend: Backend, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(rank_history, "KEPT", 3)
    ann = backend.user_id("ann")
    with backend.database.writing() as session:
        for rank in range(1, 7):
            rank_history.record(session, ann, NAME, rank=rank, score=1.0)
        points = rank_history.of_user(session, ann, NAME)

    assert [point.rank for point in points] == [4, 5, 6]


def test_metrics_of_rows_of_an_earlier_version_are_completed(both: Backend) -> None:
    _entry(both, "ann", 50.0, energy=2.0)
    with both.database.writing() as session:
        kept = session.scalar(select(Best.metrics))
        session.execute(update(Best).values(metrics=None))

    with both.database.writing() as session:
        assert best_runs.complete(session) == 1
    with both.database.writing() as session:
        assert best_runs.complete(session) == 0
        assert session.scalar(select(Best.metrics)) == kept == {RMSE.name: 1.0, ENERGY.name: 4.0}
