"""What is left of somebody who deletes the account."""

from typing import Any

import pytest
from sqlalchemy import select

from seamark.server.accounts import accounts
from seamark.server.database.tables import Best, BestMethod, Run, RunFile, User
from seamark.server.runs.ending import account_deletion
from seamark.server.runs.leaderboard import best_runs, leaderboard, score_counts
from seamark.server.runs.leaderboard.per import Per
from seamark.server.runs.record.states import RunState
from seamark.server.runs.showing import views
from tests.cast import Backend


def delete_account(both: Backend, name: str, *, keep: bool) -> None:
    with both.database.writing() as session:
        account_deletion.close(session, both.user_id(name), keep_published=keep)
    while account_deletion.step(both.database, both.settings):
        pass


@pytest.mark.slow
def test_published_runs_stay_without_the_name_if_the_owner_wants_it(backend: Backend) -> None:
    shown, private = backend.published("ann", kind="ranked"), backend.succeeded("ann")
    later = backend.queue("ben")

    delete_account(backend, "ann", keep=True)

    with backend.database.reading() as session:
        (rank,) = leaderboard.page(session, "currents-v1")
        assert views.show(session, private) is None
        assert accounts.authenticate(session, "ann", "") is None
    assert (rank.run_id, rank.user) == (shown, f"Deleted user {backend.user_id('ann')}")
    assert backend.show(later).state is RunState.QUEUED


def test_otherwise_nothing_of_the_account_is_left(both: Backend) -> None:
    record = both.store_record()
    in_record: dict[str, Any] = {"files": (record,), "config": {"current_record": record.name}}
    runs = [both.published("ann", kind="ranked"), both.succeeded("ann", **in_record)]
    runs.append(both.queue("ann"))
    both.queue("ben")

    delete_account(both, "ann", keep=False)

    with both.database.reading() as session:
        assert session.scalars(select(Run.id).where(Run.id.in_(runs))).all() == []
        assert session.scalars(select(Best)).all() == []
        assert session.scalars(select(BestMethod)).all() == []
        assert session.scalars(select(RunFile)).all() == []
        assert session.get(User, both.user_id("ann")) is None


def test_the_number_of_a_deleted_run_is_not_given_to_another_one(backend: Backend) -> None:
    record = backend.store_record()
    config: dict[str, object] = {"current_record": record.name}
    newest = backend.succeeded("ann", title="mine", files=(record,), config=config)

    delete_account(backend, "ann", keep=False)

    assert backend.queue("ben") > newest
    with backend.database.reading() as session:
        left = session.get_one(Run, newest)
        assert (left.owner, left.user_id, left.title, left.public) == ("deleted", None, "", False)
        assert left.files == []
        assert views.show(session, newest) is None


@pytest.mark.parametrize(("keep", "expected"), [(True, [(50.0, 3)]), (False, [])])
def test_leaderboard_and_score_counts_are_right_after_the_deletion_of_ranked_runs(
    backend: Backend, keep: bool, expected: list[tuple[float, int]]
) -> None:
    backend.published("ann", kind="ranked")
    backend.succeeded("ann", kind="ranked")
    backend.succeeded("ann", kind="ranked")
    backend.queue("ben")

    delete_account(backend, "ann", keep=keep)

    with backend.database.writing() as session:
        kept = [(rank.score, rank.submissions) for rank in leaderboard.page(session, "currents-v1")]
        assert score_counts.numbers(session, "currents-v1") == dict.fromkeys(Per, len(expected))
        best_runs.rebuild(session)
        again = leaderboard.page(session, "currents-v1")
        assert score_counts.numbers(session, "currents-v1") == dict.fromkeys(Per, len(expected))
    assert kept == expected
    assert [(rank.score, rank.submissions) for rank in again] == expected


def test_a_deletion_waits_for_no_batch_of_somebody_elses(both: Backend) -> None:
    both.succeeded("ann")
    with both.database.writing() as session:
        for name in ("ann", "eva"):
            account_deletion.close(session, both.user_id(name), keep_published=False)

    steps = [account_deletion.step(both.database, both.settings) for _ in range(3)]

    assert steps == [True, True, False]
    with both.database.reading() as session:
        left = [user.name for user in accounts.people(session)]
    assert not {"ann", "eva"} & set(left)


@pytest.mark.parametrize("name", ["Deleted user 1", "deleted user 1"])
def test_nobody_can_take_the_name_of_a_deleted_account(backend: Backend, name: str) -> None:
    with (
        pytest.raises(accounts.AccountRejected),
        backend.database.writing() as session,
    ):
        accounts.sign_up(session, name, "a long pass phrase")
