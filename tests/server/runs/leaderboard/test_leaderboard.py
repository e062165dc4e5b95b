import time
from concurrent.futures import ThreadPoolExecutor

import pytest
from hypothesis import HealthCheck, example, given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st
from sqlalchemy import select
from sqlalchemy.exc import IntegrityError
from sqlalchemy.orm import Session

from seamark.server.database.publication_tables import ScoreCount
from seamark.server.database.tables import Best, User
from seamark.server.runs.leaderboard import best_runs, leaderboard, score_counts
from seamark.server.runs.leaderboard.board_rows import Cursor
from seamark.server.runs.publication import publications
from seamark.server.runs.publication.publications import Terms
from seamark.server.runs.record.states import RunKind, RunState
from seamark.sim.numerics.ranking import Estimate
from tests.cast import Backend

NAME = "currents-v1"


def _ranked(both: Backend, who: str, score: float, **changes: object) -> int:
    """A ranked run that ended, private yet."""
    claim = both.running(who, kind=RunKind.RANKED)
    assert both.finish(claim, score=score, **changes)
    return claim.run_id


def _publish(both: Backend, run_id: int) -> bool:
    with both.database.writing() as session:
        return publications.publish(session, run_id, Terms())


def _board(both: Backend) -> list[tuple[str, float]]:
    with both.database.reading() as session:
        return [(rank.user, rank.score) for rank in leaderboard.page(session, NAME)]


@pytest.mark.slow
def test_only_published_ranked_runs_that_succeeded_are_ranked(backend: Backend) -> None:
    run_id = _ranked(backend, "ann", 60.0)
    practice = backend.running("ann")
    backend.finish(practice, score=99.0)
    failed = _ranked(
        backend, "ann", 98.0, state=RunState.FAILED, cause="user_error", metrics={"score": 98.0}
    )
    hidden = _ranked(backend, "ann", 97.0, metrics={"score": 97.0, "rankable": False})

    assert _board(backend) == []
    assert all(_publish(backend, each) for each in (run_id, practice.run_id, failed, hidden))
    assert _board(backend) == [("ann", 60.0)]


def test_the_best_run_of_a_user_counts_and_withdrawing_it_ranks_the_next_one(
    backend: Backend,
) -> None:
    low, high, other = (
        _ranked(backend, who, score) for who, score in (("ann", 40.0), ("ann", 80.0), ("ben", 60.0))
    )
    for run_id in (low, high, other):
        _publish(backend, run_id)
    assert _board(backend) == [("ann", 80.0), ("ben", 60.0)]

    with backend.database.writing() as session:
        assert publications.withdraw(session, high)

    assert _board(backend) == [("ben", 60.0), ("ann", 40.0)]


def test_the_pages_by_cursor_are_the_whole_leaderboard(both: Backend) -> None:
    scores = [50.0, 50.0, 70.0, 30.0, 50.0]
    for index, score in enumerate(scores):
        both.sign_up(f"user{index}")
        _publish(both, _ranked(both, f"user{index}", score))

    with both.database.reading() as session:
        whole = leaderboard.page(session, NAME)
        parts, after = [], None
        while page := leaderboard.page(session, NAME, after=after, limit=2):
            parts += page
            after = Cursor.parse(page[-1].cursor.text())
        own = leaderboard.rank_of(session, NAME, whole[3].user_id)

    assert parts == whole
    assert [rank.rank for rank in whole] == [1, 2, 3, 4, 5]
    assert [rank.user for rank in whole] == ["user2", "user0", "user1", "user4", "user3"]
    ranges = [(rank.rank_low, rank.rank_high) for rank in whole]
    assert ranges == [(1, 1), (2, 4), (2, 4), (2, 4), (5, 5)]
    assert own == whole[3]


def test_publications_at_the_same_time_leave_the_best_run_of_the_user(both: Backend) -> None:
    scores = [float(score) for score in range(50, 58)]
    run_ids = [_ranked(both, "ann", score) for score in scores]

    with ThreadPoolExecutor(4) as pool:
        published = list(pool.map(lambda run_id: _publish(both, run_id), run_ids))

    assert published == [True] * len(run_ids)
    assert _board(both) == [("ann", max(scores))]


_acts = st.lists(
    st.tuples(
        st.sampled_from(["run", "publish", "withdraw"]), st.integers(0, 2), st.integers(0, 99)
    ),
    max_size=12,
)


@pytest.mark.slow
@given(acts=_acts)
@example(acts=[("run", 0, 60), ("publish", 0, 0), ("run", 0, 40), ("publish", 0, 1)])
@example(acts=[("run", 1, 60), ("publish", 0, 0), ("withdraw", 0, 0)])
@hypothesis_settings(
    max_examples=10, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
def test_a_rebuild_gives_the_rows_that_were_maintained(
    both: Backend, acts: list[tuple[str, int, int]]
) -> None:
    users = [both.sign_up(f"u{time.time_ns()}") for _ in range(3)]
    made: list[int] = []
    for act, who, number in acts:
        if act == "run":
            made.append(_ranked(both, users[who].name, float(number)))
        elif made:
            with both.database.writing() as session:
                run_id = made[number % len(made)]
                if act == "publish":
                    publications.publish(session, run_id, Terms())
                else:
                    publications.withdraw(session, run_id)

    user_ids = [user.user_id for user in users]
    with both.database.writing() as session:
        kept = _rows(session, user_ids)
        best_runs.rebuild(session)
        rebuilt = _rows(session, user_ids)

    assert rebuilt == kept


def _rows(session: Session, users: list[int | None]) -> set[tuple[object, ...]]:
    query = select(Best.benchmark, Best.user_id, Best.run_id, Best.score, Best.reached_at)
    query = query.add_columns(Best.standard_error, Best.degrees, Best.is_baseline)
    rows = {tuple(row) for row in session.execute(query.where(Best.user_id.in_(users)))}
    counts = select(ScoreCount.score_class, ScoreCount.error_class, ScoreCount.people)
    return rows | {tuple(row) for row in session.execute(counts)}


def test_a_baseline_is_a_mark_without_a_rank_and_moves_nobody_down(backend: Backend) -> None:
    _publish(backend, _ranked(backend, "ann", 60.0))
    _publish(backend, _ranked(backend, "ben", 40.0))
    for name, score in (("oracle", 90.0), ("pi", 50.0)):
        backend.sign_up(name)
        with backend.database.writing() as session:
            session.get_one(User, backend.user_id(name)).is_baseline = True
        _publish(backend, _ranked(backend, name, score))

    with backend.database.reading() as session:
        whole = leaderboard.page(session, NAME)
        rest = leaderboard.page(session, NAME, after=whole[2].cursor)
        own = leaderboard.rank_of(session, NAME, backend.user_id("ben"))
        mark = leaderboard.rank_of(session, NAME, backend.user_id("oracle"))

    assert [rank.user for rank in whole] == ["oracle", "ann", "pi", "ben"]
    assert [rank.rank for rank in whole] == [None, 1, None, 2]
    assert [rank.rank_high for rank in whole] == [None, 1, None, 2]
    assert rest == whole[3:] == [own]
    assert mark == whole[0]


def test_a_board_of_many_people_is_ranked_by_classes_of_scores(both: Backend) -> None:
    scores = [30.0 + 2.0 * index for index in range(6)]
    for index, score in enumerate(scores):
        both.sign_up(f"user{index}")
        trials = [{"score": score - 0.3}, {"score": score + 0.3}, {"score": score}]
        metrics = {"score": score, "trials": trials}
        _publish(both, _ranked(both, f"user{index}", score, metrics=metrics))

    with both.database.reading() as session:
        single = score_counts.population(session, NAME)
        classes = score_counts.population(session, NAME, single_rows=5)

    assert (single.size, classes.size) == (6, 6)
    row = Estimate(score=36.0, standard_error=0.3 / 3**0.5, degrees=2)
    low, high = single.rank_range(row)
    assert 1 < low <= 3 <= high < 6
    assert classes.rank_range(row)[0] <= low
    assert high <= classes.rank_range(row)[1]


def test_ranges_come_from_the_fresh_trials_alone(backend: Backend) -> None:
    trials = [{"score": 99.0, "part": "reference"}, {"score": 10.0, "part": "reference"}]
    trials += [{"score": score, "part": "fresh"} for score in (50.0, 51.0, 52.0)]
    _publish(backend, _ranked(backend, "ann", 51.0, metrics={"score": 51.0, "trials": trials}))

    with backend.database.reading() as session:
        (best,) = session.scalars(select(Best))

    assert best.standard_error == pytest.approx(1.0 / 3**0.5)
    assert best.degrees == 2


def test_a_score_that_is_nan_cannot_be_stored(backend: Backend) -> None:
    run_id = _ranked(backend, "ann", 1.0)

    with pytest.raises(IntegrityError), backend.database.writing() as session:
        session.add(
            Best(
                benchmark=NAME,
                user_id=backend.user_id("ann"),
                run_id=run_id,
                score=float("nan"),
                score_low=0.0,
                score_high=0.0,
                reached_at=0.0,
            )
        )


def _submissions(both: Backend) -> dict[str, int | None]:
    with both.database.reading() as session:
        return {rank.user: rank.submissions for rank in leaderboard.page(session, NAME)}


def test_a_row_has_the_number_of_ranked_submissions_public_or_not(backend: Backend) -> None:
    for score in (40.0, 60.0, 50.0):
        run_id = _ranked(backend, "ann", score)
    _publish(backend, run_id)
    _publish(backend, _ranked(backend, "ben", 45.0))
    backend.succeeded("ann")
    backend.cancel(backend.queue("ann", kind="ranked"))

    assert _submissions(backend) == {"ann": 3, "ben": 1}


def test_later_submissions_count_when_they_end(backend: Backend) -> None:
    _publish(backend, _ranked(backend, "ann", 60.0))
    failed = backend.running("ann", kind="ranked")
    assert _submissions(backend) == {"ann": 1}

    backend.finish(failed, state=RunState.FAILED, cause="user_error", metrics=None)
    assert _submissions(backend) == {"ann": 2}

    cancelled = backend.running("ann", kind="ranked")
    backend.cancel(cancelled.run_id)
    backend.finish(cancelled, state=RunState.CANCELLED)
    assert _submissions(backend) == {"ann": 3}


def test_a_rebuilt_leaderboard_has_the_same_numbers_of_submissions(backend: Backend) -> None:
    for who, score in (("ann", 40.0), ("ann", 60.0), ("ben", 50.0)):
        _publish(backend, _ranked(backend, who, score))
    before = _submissions(backend)

    with backend.database.writing() as session:
        best_runs.rebuild(session)

    assert _submissions(backend) == before == {"ann": 2, "ben": 1}
