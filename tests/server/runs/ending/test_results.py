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


def test_the_reason_of_the_benchmark_is_kept(backend: Backend) -> None:
    metrics = {"score": 1.0, "rankable": False, "not_ranked": "Trial 9: It drove away."}
    claim = backend.running("ann", kind="ranked")
    backend.finish(claim, metrics=metrics)

    view = backend.show(claim.run_id)

    assert (view.rankable, view.not_ranked) == (False, "Trial 9: It drove away.")


def test_a_submission_has_a_digest_where_it_decides_the_seeds(backend: Backend) -> None:
    runs = [
        backend.queue("ann", benchmark=benchmark, kind=kind)
        for benchmark, kind in ((V2, "ranked"), (V2, "practice"), ("currents-v1", "ranked"))
    ]

    digests = [backend.show(run_id).submission for run_id in runs]

    assert [len(digest or "") for digest in digests] == [64, 0, 0]


def test_the_same_submission_with_the_same_result_ranks_again(backend: Backend) -> None:
    program = backend.store_program()
    runs = [_ended(backend, "ann", DIGESTS[0], program) for _ in range(2)]

    assert [backend.show(run_id).rankable for run_id in runs] == [True, True]


@pytest.mark.parametrize("who", ["ann", "ben"])
def test_another_result_of_the_same_submission_does_not_rank(backend: Backend, who: str) -> None:
    program = backend.store_program()
    first = _ended(backend, "ann", DIGESTS[0], program)
    second = _ended(backend, who, DIGESTS[1], program)

    assert backend.show(first).rankable is True
    view = backend.show(second)
    assert view.rankable is False
    named = f"Run {first}" if who == "ann" else "A run of another account"  # which is private
    assert (view.not_ranked or "").startswith(f"{named} was of the same program")


def test_a_submission_whose_first_run_failed_does_not_rank(backend: Backend) -> None:
    program = backend.store_program()
    failed: dict[str, Any] = {"state": RunState.FAILED, "cause": "user_error", "metrics": None}
    _ended(backend, "ann", DIGESTS[0], program, **failed)
    second = _ended(backend, "ann", DIGESTS[1], program)

    assert backend.show(second).rankable is False


def test_a_published_run_is_named_as_the_first_one(backend: Backend) -> None:
    program = backend.store_program()
    first = backend.publish(_ended(backend, "eva", DIGESTS[0], program))

    second = _ended(backend, "ben", DIGESTS[1], program)

    assert f"Run {first} was of the same program" in (backend.show(second).not_ranked or "")


@pytest.mark.parametrize("how", ["cancelled", "time_limit"])
def test_a_run_whose_fresh_trials_nobody_saw_uses_a_submission_up_for_its_account_alone(
    backend: Backend, how: str
) -> None:
    program = backend.store_program()
    claim = backend.running(
        "ann", benchmark=V2, kind="ranked", controller="upload", program=program
    )
    if how == "cancelled":
        backend.cancel(claim.run_id)
    else:
        backend.finish(claim, state=RunState.FAILED, cause=how, metrics=None)
    honest = _ended(backend, "ben", DIGESTS[1], program)
    changed = _ended(backend, "ann", DIGESTS[0], backend.store_program(PROGRAM + b"# changed\n"))

    assert backend.show(honest).rankable is True
    assert backend.show(changed).rankable is True


def test_who_cancelled_a_run_after_its_start_cannot_rank_with_the_same_program(
    backend: Backend,
) -> None:
    program = backend.store_program()
    claim = backend.running(
        "ann", benchmark=V2, kind="ranked", controller="upload", program=program
    )
    backend.cancel(claim.run_id)
    again = _ended(backend, "ann", DIGESTS[1], program)

    view = backend.show(again)
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
def test_what_a_deleted_account_saw_still_counts(backend: Backend, digest: str) -> None:
    program = backend.store_program()
    _ended(backend, "ann", DIGESTS[0], program)
    with backend.database.writing() as session:
        account_deletion.close(session, backend.user_id("ann"), keep_published=False)
    while account_deletion.step(backend.database, backend.settings):
        pass
    later = backend.show(_ended(backend, "ben", digest, program))

    assert later.rankable is (digest == DIGESTS[0])
    assert "Run" not in (later.not_ranked or "")


def test_failures_of_the_platform_do_not_spoil_a_submission(backend: Backend) -> None:
    program = backend.store_program()
    broken: dict[str, Any] = {"state": RunState.FAILED, "cause": "platform_error", "metrics": None}
    _ended(backend, "ann", DIGESTS[0], program, **broken)
    second = _ended(backend, "ann", DIGESTS[1], program)

    assert backend.show(second).rankable is True


def test_another_program_has_a_first_result_of_its_own(backend: Backend) -> None:
    _ended(backend, "ann", DIGESTS[0], backend.store_program())
    changed = backend.store_program(PROGRAM + b"# changed\n")
    second = _ended(backend, "ann", DIGESTS[1], changed)

    assert backend.show(second).rankable is True


def test_a_baseline_is_on_the_leaderboard_whatever_the_rules_of_the_benchmark(
    backend: Backend,
) -> None:
    with backend.database.writing() as session:
        session.get_one(User, backend.user_id("ann")).is_baseline = True
    claim = backend.running("ann", kind="ranked")
    backend.finish(claim, metrics={"score": 0.1, "rankable": False, "not_ranked": "It drove away."})

    with backend.database.reading() as session:
        ranks = leaderboard.page(session, "currents-v1")

    assert [rank.run_id for rank in ranks] == [claim.run_id]
    assert backend.show(claim.run_id).not_ranked is None
