"""Runs whose program was connected: they cannot be repeated, by whatever path."""

from typing import Any

import pytest
from sqlalchemy import select

from seamark.server.administration import rejudge_choice
from seamark.server.administration.rejudge_choice import RunChoice
from seamark.server.database.queue_tables import Pace
from seamark.server.runs.queue import lost_attempts
from seamark.server.runs.queue import queue as run_queue
from seamark.server.runs.queue.lost_attempts import AttemptEnd
from seamark.server.runs.queue.queue import Claim
from seamark.server.runs.record.solutions import solution
from seamark.server.runs.record.states import RunKind, RunState
from seamark.server.runs.submission.validation import SubmissionRejected
from tests.cast import Backend

CONNECTED: dict[str, Any] = {"controller": "rosbridge", "connected": True}


@pytest.fixture
def claim(backend: Backend) -> Claim:
    """The run of a connected program, at its place."""
    run_id = backend.queue(**CONNECTED)
    with backend.database.writing() as session:
        run_queue.start(session, run_id, "w1/bridges-1", backend.settings)
        found = run_queue.started(session, run_id, "w1/bridges-1", backend.settings)
    assert found is not None
    return found


def test_no_other_worker_has_the_run_that_was_started_for_one(
    backend: Backend, claim: Claim
) -> None:
    with backend.database.reading() as session:
        assert run_queue.started(session, claim.run_id, "w2/bridges-1", backend.settings) is None
    assert backend.claim() is None


@pytest.mark.parametrize("end", list(AttemptEnd))
def test_whatever_ends_its_attempt_ends_the_run(
    backend: Backend, claim: Claim, end: AttemptEnd
) -> None:
    with backend.database.writing() as session:
        state = lost_attempts.release(session, claim, end, settings=backend.settings)

    run = backend.show(claim.run_id)
    assert state is run.state is RunState.FAILED
    assert run.cause == "platform_error"
    assert "Connect it again" in run.detail["sentence"]
    assert backend.claim() is None


def test_a_worker_that_died_takes_the_run_with_it(backend: Backend, claim: Claim) -> None:
    with backend.database.writing() as session:
        recovery = lost_attempts.recover_from(session, claim.worker, backend.settings)

    assert recovery.failed == [claim.run_id]
    assert not recovery.requeued


def test_it_is_not_run_again(backend: Backend, claim: Claim) -> None:
    assert backend.finish(claim)

    with pytest.raises(SubmissionRejected, match="connect it again"):
        backend.rerun(claim.run_id)


def test_it_is_not_computed_again_by_a_rejudgement(backend: Backend, claim: Claim) -> None:
    assert backend.finish(claim)
    other = backend.succeeded()
    choice = RunChoice(benchmark="currents-v1")

    with backend.database.reading() as session:
        chosen = rejudge_choice.choose(session, choice)

    assert chosen.runs == [other]


def test_the_pace_of_its_network_is_nobody_elses(backend: Backend, claim: Claim) -> None:
    assert backend.finish(claim)

    with backend.database.reading() as session:
        assert session.scalar(select(Pace)) is None
    assert backend.show(claim.run_id).estimate_s is None


def test_it_takes_no_place_of_its_owners_other_runs(backend: Backend, claim: Claim) -> None:
    backend.settings = backend.settings.model_copy(update={"running_max": 1})
    run_id = backend.queue()

    other = backend.claim()

    assert other is not None
    assert other.run_id == run_id
    assert backend.queue()  # the limit counts the run that is not connected
    assert backend.claim() is None


def test_it_does_not_rank(backend: Backend) -> None:
    with pytest.raises(SubmissionRejected, match="does not rank"):
        backend.queue(**CONNECTED, kind=RunKind.RANKED)


def test_it_is_called_by_its_protocol(backend: Backend, claim: Claim) -> None:
    assert solution(backend.show(claim.run_id)) == "ROS program (rosbridge)"
