"""The queue of checks, on both databases: one at a time, replaced, leased, fenced, forgotten."""

import time

import pytest
from sqlalchemy import update

from seamark.server.database.tables import Check
from seamark.server.programs import check_queue
from seamark.server.programs.check_queue import CheckRefused, CheckState
from seamark.server.programs.store import StoredProgram
from tests.cast import Backend

PROGRAM = StoredProgram("0" * 64, "mine.py", "python", 9)
ANSWER = {"ok": True}


def order(service: Backend, user_id: int) -> int:
    with service.database.writing() as session:
        return check_queue.enqueue(session, user_id, "currents-v1", {}, PROGRAM)


def claim(service: Backend, *languages: str) -> check_queue.CheckClaim | None:
    with service.database.writing() as session:
        return check_queue.claim(
            session, "w1/checks", languages=languages or ("python",), lease_s=30.0
        )


def state(service: Backend, check_id: int, user_id: int) -> CheckState | None:
    with service.database.reading() as session:
        view = check_queue.show(session, check_id, user_id)
    return None if view is None else view.state


def test_a_new_check_replaces_a_queued_one_but_not_a_running_one(both: Backend) -> None:
    ann = both.user_id("ann")
    first = order(both, ann)
    second = order(both, ann)

    assert (state(both, first, ann), state(both, second, ann)) == (None, CheckState.QUEUED)
    assert claim(both) is not None
    with pytest.raises(CheckRefused, match="still running"):
        order(both, ann)


def test_checks_are_claimed_in_order_by_workers_with_their_language(both: Backend) -> None:
    ann, ben = both.user_id("ann"), both.user_id("ben")
    made = [order(both, ann), order(both, ben)]

    assert claim(both, "c") is None
    taken = [claim(both), claim(both), claim(both)]

    assert [one.check_id for one in taken if one is not None] == made


def test_a_check_is_visible_only_to_its_owner(both: Backend) -> None:
    ann, ben = both.user_id("ann"), both.user_id("ben")
    check_id = order(both, ann)

    assert state(both, check_id, ben) is None


def test_a_worker_whose_lease_has_expired_cannot_finish_the_check(both: Backend) -> None:
    ann = both.user_id("ann")
    check_id = order(both, ann)
    late = claim(both)
    assert late is not None
    with both.database.writing() as session:
        check_queue.recover(session, check_queue.leases(session))
    again = claim(both)
    assert again is not None

    with both.database.writing() as session:
        assert not check_queue.finish(session, late, ANSWER)
        assert check_queue.finish(session, again, ANSWER)
    assert state(both, check_id, ann) is CheckState.DONE


def test_a_check_that_breaks_two_workers_is_a_platform_failure(both: Backend) -> None:
    ann = both.user_id("ann")
    check_id = order(both, ann)
    for _ in range(2):
        taken = claim(both)
        assert taken is not None
        with both.database.writing() as session:
            check_queue.release(session, taken.check_id, taken.attempt, attempts_max=2)

    with both.database.reading() as session:
        view = check_queue.show(session, check_id, ann)

    assert view is not None
    assert view.report is not None
    assert not view.report["ok"]
    assert "did not cause this" in view.report["problems"][0]["sentence"]


def test_old_checks_are_deleted(both: Backend) -> None:
    ann = both.user_id("ann")
    check_id = order(both, ann)
    taken = claim(both)
    assert taken is not None
    with both.database.writing() as session:
        check_queue.finish(session, taken, ANSWER)
        session.execute(update(Check).values(finished_at=time.time() - check_queue.DONE_KEPT_S - 1))

    with both.database.writing() as session:
        check_queue.recover(session, {})

    assert state(both, check_id, ann) is None


def test_a_check_is_released_when_its_process_has_ended_or_its_lease_is_not_renewed(
    both: Backend,
) -> None:
    ann = both.user_id("ann")
    check_id = order(both, ann)
    states = []
    assert claim(both) is not None
    for worker in ("w1/0", "w1/checks"):
        with both.database.writing() as session:
            check_queue.recover_from(session, worker)
        states.append(state(both, check_id, ann))
    held = claim(both)
    assert held is not None
    with both.database.reading() as session:
        read_before = check_queue.leases(session)
    with both.database.writing() as session:
        assert check_queue.renew(session, held)
        check_queue.recover(session, read_before)

    assert states == [CheckState.RUNNING, CheckState.QUEUED]
    assert state(both, check_id, ann) is CheckState.RUNNING


def test_the_number_of_queued_checks_is_limited(both: Backend) -> None:
    for number in range(check_queue.WAITING_MAX):
        both.sign_up(f"user{number}")
        order(both, both.user_id(f"user{number}"))

    with pytest.raises(CheckRefused, match="full"):
        order(both, both.user_id("ann"))
