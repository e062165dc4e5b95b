"""Why a run does not rank, and that the first result of a submission counts."""

from typing import Any

import pytest

from seamark.server.database.tables import User
from seamark.server.programs.store import StoredProgram
from seamark.server.runs.ending import account_deletion
from seamark.server.runs.leaderboard import leaderboard
from seamark.server.runs.record.states import RunState
from tests.cast import PROGRAM, Backend

V2 = "currents-v2"
DIGESTS = ("1" * 64, "2" * 64)


def _ended(both: Backend, who: str, digest: str, program: StoredProgram, **changes: Any) -> int:
    """A ranked run of a program on fresh trials that ended."""
    claim = both.running(who, benchmark=V2, kind="ranked", controller="upload", program=program)
    assert both.finish(claim, digest=digest, **changes)
    return claim.run_id


def test_the_reason_of_the_benchmark_is_kept(both: Backend) -> None:
    metrics = {"score": 1.0, "rankable": False, "not_ranked": "Trial 9: It drove away."}
    claim = both.running("ann", kind="ranked")
    both.finish(claim, metrics=metrics)

    view = both.show(claim.run_id)

    assert (view.rankable, view.not_ranked) == (False, "Trial 9: It drove away.")


def test_a_submission_has_a_digest_where_it_decides_the_seeds(both: Backend) -> None:
    runs = [
        both.queue("ann", benchmark=benchmark, kind=kind)
        for benchmark, kind in ((V2, "ranked"), (V2, "practice"), ("currents-v1", "ranked"))
    ]

    digests = [both.show(run_id).submission for run_id in runs]

    assert [len(digest or "") for digest in digests] == [64, 0, 0]


def test_the_same_submission_with_the_same_result_ranks_again(both: Backend) -> None:
    program = both.store_program()
    runs = [_ended(both, "ann", DIGESTS[0], program) for _ in range(2)]

    assert [both.show(run_id).rankable for run_id in runs] == [True, True]


@pytest.mark.parametrize("who", ["ann", "ben"])
def test_another_result_of_the_same_submission_does_not_rank(both: Backend, who: str) -> None:
    program = both.store_program()
    first = _ended(both, "ann", DIGESTS[0], program)
    second = _ended(both, who, DIGESTS[1], program)

    assert both.show(first).rankable is True
    view = both.show(second)
    assert view.rankable is False
    named = f"Run {first}" if who == "ann" else "A run of another account"  # which is private
    assert (view.not_ranked or "").startswith(f"{named} was of the same program")


def test_a_submission_whose_first_run_failed_does_not_rank(both: Backend) -> None:
    program = both.store_program()
    failed: dict[str, Any] = {"state": RunState.FAILED, "cause": "user_error", "metrics": None}
    _ended(both, "ann", DIGESTS[0], program, **failed)
    second = _ended(both, "ann", DIGESTS[1], program)

    assert both.show(second).rankable is False


def test_a_published_run_is_named_as_the_first_one(both: Backend) -> None:
    program = both.store_program()
    first = both.publish(_ended(both, "eva", DIGESTS[0], program))

    second = _ended(both, "ben", DIGESTS[1], program)

    assert f"Run {first} was of the same program" in (both.show(second).not_ranked or "")


@pytest.mark.parametrize("how", ["cancelled", "time_limit"])
def test_a_run_whose_fresh_trials_nobody_saw_uses_a_submission_up_for_its_account_alone(
    both: Backend, how: str
) -> None:
    program = both.store_program()
    claim = both.running("ann", benchmark=V2, kind="ranked", controller="upload", program=program)
    if how == "cancelled":
        both.cancel(claim.run_id)
    else:
        both.finish(claim, state=RunState.FAILED, cause=how, metrics=None)
    honest = _ended(both, "ben", DIGESTS[1], program)
    changed = _ended(both, "ann", DIGESTS[0], both.store_program(PROGRAM + b"# changed\n"))

    assert both.show(honest).rankable is True
    assert both.show(changed).rankable is True


def test_who_cancelled_a_run_after_its_start_cannot_rank_with_the_same_program(
    both: Backend,
) -> None:
    program = both.store_program()
    claim = both.running("ann", benchmark=V2, kind="ranked", controller="upload", program=program)
    both.cancel(claim.run_id)
    again = _ended(both, "ann", DIGESTS[1], program)

    view = both.show(again)
    assert view.rankable is False
    assert f"Run {claim.run_id} was of the same program" in (view.not_ranked or "")


def test_of_two_runs_at_the_same_time_the_first_to_end_counts_whoever_began(both: Backend) -> None:
    program = both.store_program()
    wanted: dict[str, Any] = {"benchmark": V2, "kind": "ranked", "controller": "upload"}
    began, overlapping = (both.running(who, program=program, **wanted) for who in ("ann", "ben"))
    both.finish(overlapping, digest=DIGESTS[1])
    both.finish(began, digest=DIGESTS[0])

    assert both.show(overlapping.run_id).rankable is True
    assert both.show(began.run_id).rankable is False


@pytest.mark.parametrize("digest", DIGESTS)
def test_what_a_deleted_account_saw_still_counts(both: Backend, digest: str) -> None:
    program = both.store_program()
    _ended(both, "ann", DIGESTS[0], program)
    with both.database.writing() as session:
        account_deletion.close(session, both.user_id("ann"), keep_published=False)
    while account_deletion.step(both.database, both.settings):
        pass
    later = both.show(_ended(both, "ben", digest, program))

    assert later.rankable is (digest == DIGESTS[0])
    assert "Run" not in (later.not_ranked or "")


def test_failures_of_the_platform_do_not_spoil_a_submission(both: Backend) -> None:
    program = both.store_program()
    broken: dict[str, Any] = {"state": RunState.FAILED, "cause": "platform_error", "metrics": None}
    _ended(both, "ann", DIGESTS[0], program, **broken)
    second = _ended(both, "ann", DIGESTS[1], program)

    assert both.show(second).rankable is True


def test_another_program_has_a_first_result_of_its_own(both: Backend) -> None:
    _ended(both, "ann", DIGESTS[0], both.store_program())
    changed = both.store_program(PROGRAM + b"# changed\n")
    second = _ended(both, "ann", DIGESTS[1], changed)

    assert both.show(second).rankable is True


def test_a_baseline_is_on_the_leaderboard_whatever_the_rules_of_the_benchmark(
    both: Backend,
) -> None:
    with both.database.writing() as session:
        session.get_one(User, both.user_id("ann")).is_baseline = True
    claim = both.running("ann", kind="ranked")
    both.finish(claim, metrics={"score": 0.1, "rankable": False, "not_ranked": "It drove away."})

    with both.database.reading() as session:
        ranks = leaderboard.page(session, "currents-v1")

    assert [rank.run_id for rank in ranks] == [claim.run_id]
    assert both.show(claim.run_id).not_ranked is None
