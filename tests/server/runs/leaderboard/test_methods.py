"""The leaderboard with one row for each named method of a person."""

import time
from collections import Counter

import pytest
from hypothesis import HealthCheck, example, given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st
from sqlalchemy import select
from sqlalchemy.orm import Session

from seamark.server.database.publication_tables import ScoreCount
from seamark.server.database.tables import Best, BestMethod, User
from seamark.server.runs.leaderboard import (
    best_runs,
    leaderboard,
    leaderboard_filters,
    score_counts,
)
from seamark.server.runs.leaderboard.board_rows import Cursor, Rank
from seamark.server.runs.leaderboard.leaderboard_filters import BoardFilter
from seamark.server.runs.leaderboard.per import Per
from seamark.server.runs.publication import publications
from seamark.server.runs.publication.publications import Terms
from seamark.server.runs.record.states import RunKind
from tests.cast import Backend

NAME = "currents-v1"
METHODS = BoardFilter(per=Per.METHOD)


def _ranked(both: Backend, who: str, score: float, **changes: str) -> int:
    claim = both.running(who, kind=RunKind.RANKED, **changes)
    assert both.finish(claim, score=score)
    return claim.run_id


def _published(both: Backend, who: str, method: str, score: float, **terms: bool) -> int:
    return both.publish(_ranked(both, who, score), method=method, **terms)


def _board(both: Backend, per: Per = Per.METHOD) -> list[Rank]:
    with both.database.reading() as session:
        return leaderboard.page(session, NAME, per=per)


def _told(ranks: list[Rank]) -> list[tuple[str, str, float, int | None]]:
    return [(rank.user, rank.method, rank.score, rank.rank) for rank in ranks]


def test_each_named_method_of_a_person_has_a_row_with_its_best_run(both: Backend) -> None:
    for who, method, score in (
        ("ann", "PI", 40.0),
        ("ann", "Observer", 60.0),
        ("ann", "PI", 55.0),
        ("ben", "PI", 50.0),
    ):
        _published(both, who, method, score)

    assert _told(_board(both)) == [
        ("ann", "Observer", 60.0, 1),
        ("ann", "PI", 55.0, 2),
        ("ben", "PI", 50.0, 3),
    ]
    assert _told(_board(both, Per.PERSON)) == [
        ("ann", "Observer", 60.0, 1),
        ("ben", "PI", 50.0, 2),
    ]


def test_names_that_differ_in_case_and_spaces_are_one_method_called_as_its_best_run(
    backend: Backend,
) -> None:
    for method, score in (("Straße  A", 40.0), ("STRASSE a", 60.0), (" strasse\tA", 50.0)):
        _published(backend, "ann", method, score)

    assert _told(_board(backend)) == [("ann", "STRASSE a", 60.0, 1)]


def test_withdrawing_a_run_leaves_the_next_one_of_its_method_and_no_other_row_changes(
    backend: Backend,
) -> None:
    _published(backend, "ann", "Observer", 60.0)
    best = _published(backend, "ann", "PI", 50.0)
    _published(backend, "ann", "PI", 40.0)

    with backend.database.writing() as session:
        assert publications.withdraw(session, best)

    assert _told(_board(backend)) == [("ann", "Observer", 60.0, 1), ("ann", "PI", 40.0, 2)]


def test_ranges_of_ranks_are_among_methods(backend: Backend) -> None:
    for who, method, score in (("ann", "A", 70.0), ("ann", "B", 50.0), ("ben", "C", 50.0)):
        _published(backend, who, method, score)

    ranges = [(rank.rank_low, rank.rank_high) for rank in _board(backend)]
    assert ranges == [(1, 1), (2, 3), (2, 3)]
    assert [rank.rank_high for rank in _board(backend, Per.PERSON)] == [1, 2]


def test_pages_by_cursor_with_and_without_a_filter_are_the_whole_list_of_methods(
    both: Backend,
) -> None:
    for at in range(6):
        _published(both, ("ann", "ben")[at % 2], f"Method {at // 2}", 50.0 + at // 3)

    filters = (METHODS, BoardFilter(per=Per.METHOD, program="built-in"))
    mine = BoardFilter(per=Per.METHOD, user_id=both.user_id("ann"))
    with both.database.reading() as session:
        whole = leaderboard.page(session, NAME, per=Per.METHOD)
        paged = [_paged(session, board_filter) for board_filter in filters]
        own = _paged(session, mine)
        classes = score_counts.population(session, NAME, Per.METHOD, single_rows=1)

    assert len(whole) == 6
    assert paged == [whole, whole]
    assert own == [rank for rank in whole if rank.user == "ann"]
    assert len(own) == 3
    assert classes.size == 6


def _paged(session: Session, board_filter: BoardFilter) -> list[Rank]:
    ranks, after = list[Rank](), None
    while True:
        page = leaderboard_filters.page(session, NAME, board_filter, after=after, limit=2)
        ranks += page.ranks
        if page.next is None:
            return ranks
        after = Cursor.parse(page.next.text())


def test_a_baseline_has_one_row_among_methods_whatever_its_runs_were_called(
    backend: Backend,
) -> None:
    backend.sign_up("oracle")
    with backend.database.writing() as session:
        session.get_one(User, backend.user_id("oracle")).is_baseline = True
    for title, score in (("Old title", 80.0), ("Oracle", 90.0)):
        _ranked(backend, "oracle", score, title=title)  # which publishes it
    _published(backend, "ann", "PI", 50.0)

    assert _told(_board(backend)) == [("oracle", "Oracle", 90.0, None), ("ann", "PI", 50.0, 1)]
    with backend.database.reading() as session:
        only = BoardFilter(per=Per.METHOD, baselines=leaderboard_filters.ONLY)
        shown = leaderboard_filters.page(session, NAME, only).ranks
    assert [rank.user for rank in shown] == ["oracle"]


def test_rows_of_anonymous_methods_have_nothing_in_common_that_tells_of_one_author(
    backend: Backend,
) -> None:
    for method, score in (("Steady", 60.0), ("Quick", 50.0)):
        _published(backend, "ann", method, score, anonymous=True)
    _published(backend, "ben", "PI", 40.0)

    steady, quick, named = _board(backend)
    (alone, _) = _board(backend, Per.PERSON)

    assert {rank.user for rank in (steady, quick)} == {"Anonymous author"}
    assert (steady.submissions, quick.submissions, named.submissions) == (None, None, 1)
    assert alone.submissions == 2


def test_a_revealed_author_is_shown_in_the_rows_of_all_methods(backend: Backend) -> None:
    run_id = _published(backend, "ann", "Steady", 60.0, anonymous=True)
    _published(backend, "ann", "Quick", 50.0, anonymous=True)

    with backend.database.writing() as session:
        assert publications.reveal(session, run_id)

    assert [(rank.user, rank.submissions) for rank in _board(backend)] == [("ann", 2)] * 2


_acts = st.lists(
    st.tuples(
        st.sampled_from(["run", "publish", "withdraw", "rename"]),
        st.integers(0, 1),
        st.integers(0, 9),
        st.sampled_from(["PI", "pi", " Pi ", "Observer", "ÜBUNG", "übung"]),
    ),
    max_size=14,
)


@pytest.mark.slow
@given(acts=_acts)
@example(
    acts=[
        ("run", 0, 3, "PI"),
        ("publish", 0, 0, "PI"),
        ("run", 0, 2, "pi"),
        ("publish", 0, 1, "pi"),
        ("rename", 0, 0, "ÜBUNG"),
        ("withdraw", 0, 0, ""),
    ]
)
@hypothesis_settings(
    max_examples=15, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
def test_the_rows_are_what_a_plain_computation_over_the_published_runs_gives(
    both: Backend, acts: list[tuple[str, int, int, str]]
) -> None:
    users = [both.sign_up(f"m{time.time_ns()}") for _ in range(2)]
    made: list[tuple[int | None, float, int]] = []
    published: dict[int, str] = {}
    for act, who, number, method in acts:
        if act == "run":
            made.append(
                (users[who].user_id, -float(number), _ranked(both, users[who].name, number))
            )
        elif made:
            _, _, run_id = made[number % len(made)]
            with both.database.writing() as session:
                if act != "publish":
                    publications.withdraw(session, run_id)
                    published.pop(run_id, None)
                if act != "withdraw":
                    publications.publish(session, run_id, Terms(method=method))
                    published.setdefault(run_id, method)

    best: dict[tuple[int | None, str], int] = {}
    for user_id, _, run_id in sorted(made, key=lambda each: (each[1], each[2])):
        if run_id in published:
            best.setdefault((user_id, published[run_id].strip().lower()), run_id)
    user_ids = [user.user_id for user in users]
    with both.database.writing() as session:
        kept, counted = _rows(session, user_ids), _counts(session)
        people = session.scalars(select(Best).where(Best.user_id.in_(user_ids)))
        leading = {row.run_id for row in people}
        best_runs.rebuild(session)
        rebuilt, recounted = _rows(session, user_ids), _counts(session)

    assert kept == rebuilt == best
    assert leading <= set(best.values())
    assert len(leading) == len({user_id for user_id, _ in best})
    assert counted == recounted


def _rows(session: Session, users: list[int | None]) -> dict[tuple[int | None, str], int]:
    rows = session.scalars(select(BestMethod).where(BestMethod.user_id.in_(users)))
    return {(row.user_id, row.method): row.run_id for row in rows}


def _counts(session: Session) -> Counter[tuple[int, int]]:
    query = select(ScoreCount.score_class, ScoreCount.methods)
    return Counter({(row[0], row[1]) for row in session.execute(query)})
