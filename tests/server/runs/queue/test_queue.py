import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor

import pytest
from hypothesis import HealthCheck, given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st
from sqlalchemy import select, update
from sqlalchemy.orm import Session

from seamark.programs.failure_reasons import FailureReason
from seamark.server.database.queue_tables import Turn
from seamark.server.database.tables import Run, Worker
from seamark.server.messaging import workers
from seamark.server.runs.ending import results
from seamark.server.runs.ending.results import ResultInvalid
from seamark.server.runs.queue import lost_attempts, wait_estimate
from seamark.server.runs.queue import queue as run_queue
from seamark.server.runs.queue.lost_attempts import AttemptEnd, Recovery
from seamark.server.runs.queue.queue import Claim, LeaseStatus
from seamark.server.runs.record import turns
from seamark.server.runs.record.states import NEXT_STATES, RunKind, RunState
from seamark.server.runs.showing import views
from seamark.worker.service.lease_watch import LeaseWatch
from tests.cast import Backend


def _heartbeat(both: Backend, claim: Claim) -> LeaseStatus:
    with both.database.writing() as session:
        return run_queue.heartbeat(session, claim, progress=0.5, t_simulated=1.0, isolation=None)


def _silence(both: Backend, run_id: int) -> None:
    """Let the run's lease expire."""
    with both.database.writing() as session:
        session.execute(update(Run).where(Run.id == run_id).values(lease_until=time.time() - 1))


def _sweep(both: Backend) -> Recovery:
    watch = LeaseWatch(lease_s=both.settings.lease_s, renewal_s=both.settings.heartbeat_s)
    with both.database.reading() as session:
        leases = lost_attempts.leases(session)
    watch.abandoned(leases, now_s=0.0)
    abandoned = watch.abandoned(leases, now_s=2 * both.settings.heartbeat_s)
    with both.database.writing() as session:
        return lost_attempts.recover(session, abandoned, both.settings)


def test_a_run_is_claimed_once(both: Backend) -> None:
    run_id = both.queue("ann")

    first, second = both.claim("w1"), both.claim("w2")

    assert first is not None
    assert (first.run_id, first.attempt, second) == (run_id, 1, None)
    assert both.show(run_id).state is RunState.RUNNING


def test_a_run_whose_lease_expired_returns_to_its_position(both: Backend) -> None:
    first = both.queue("ann")
    both.claim("dead")
    both.queue("ben")
    _silence(both, first)

    report = _sweep(both)

    assert (report.requeued, report.failed) == ([first], [])
    assert both.show(first).state is RunState.QUEUED
    assert both.show(first).position == 1
    assert both.claim_next().run_id == first


def test_a_worker_whose_lease_expired_cannot_write(both: Backend) -> None:
    run_id = both.queue("ann")
    late = both.claim("late")
    assert late is not None
    _silence(both, run_id)
    _sweep(both)
    fresh = both.claim("fresh")
    assert fresh is not None

    assert _heartbeat(both, late) is LeaseStatus.LOST
    assert not both.finish(late, score=99.0)
    assert both.finish(fresh, score=42.0)
    assert not both.finish(fresh, score=43.0)
    assert both.show(run_id).score == 42.0
    assert both.show(run_id).attempt == 2


def _end_attempt(both: Backend, end: AttemptEnd) -> None:
    claim = both.claim_next()
    with both.database.writing() as session:
        lost_attempts.release(session, claim, end, settings=both.settings)


def test_the_third_evaluation_that_breaks_is_a_platform_failure(both: Backend) -> None:
    run_id = both.queue("ann")

    for _ in range(2):
        _end_attempt(both, AttemptEnd.EVALUATION_BROKE)
    before = both.show(run_id).state
    _end_attempt(both, AttemptEnd.EVALUATION_BROKE)

    view = both.show(run_id)
    assert (before, view.state) == (RunState.QUEUED, RunState.FAILED)
    assert view.cause == FailureReason.PLATFORM_ERROR
    assert view.detail["remedy"]


def test_a_run_that_loses_its_worker_three_times_still_gets_its_result(both: Backend) -> None:
    run_id = both.queue("ann")
    _end_attempt(both, AttemptEnd.EVALUATION_BROKE)

    for _ in range(3):
        assert both.claim() is not None
        _silence(both, run_id)
        _sweep(both)

    assert both.finish(both.claim_next())
    assert (both.show(run_id).state, both.show(run_id).attempt) == (RunState.SUCCEEDED, 5)


@pytest.mark.parametrize("end", [AttemptEnd.WORKER_LOST, AttemptEnd.STORAGE_FAILED])
def test_a_run_that_takes_down_ten_workers_or_fills_ten_disks_gets_no_eleventh(
    both: Backend, end: AttemptEnd
) -> None:
    run_id = both.queue("ann")

    for _ in range(lost_attempts.INTERRUPTIONS_MAX - 1):
        _end_attempt(both, end)
    before = both.show(run_id).state
    _end_attempt(both, end)

    assert (before, both.show(run_id).state) == (RunState.QUEUED, RunState.FAILED)
    assert both.show(run_id).cause == FailureReason.PLATFORM_ERROR


def test_the_queue_needs_a_ticket_for_each_slot_however_many_runs_wait(both: Backend) -> None:
    for owner in ("ann", "ann", "ben"):
        both.queue(owner)
    without_workers = _sweep(both).tickets

    with both.database.writing() as session:
        worker = Worker(name="w", slots=2, level="strong", languages=[], findings=[])
        workers.register(session, worker)

    assert (without_workers, _sweep(both).tickets) == (1, 2)


def test_the_runs_of_a_process_that_has_ended_are_queued_before_their_leases_end(
    both: Backend,
) -> None:
    run_ids = [both.queue("ann"), both.queue("ben")]
    for name in ("w/0", "w/1"):
        assert both.claim(name) is not None

    with both.database.writing() as session:
        recovery = lost_attempts.recover_from(session, "w/0", both.settings)

    assert (recovery.requeued, recovery.failed, recovery.tickets) == ([run_ids[0]], [], 1)
    assert both.show(run_ids[1]).state is RunState.RUNNING


def test_a_lease_that_was_renewed_after_it_was_read_is_not_abandoned(both: Backend) -> None:
    claim = both.running("ann")
    with both.database.reading() as session:
        read_before = lost_attempts.leases(session)
    assert _heartbeat(both, claim) is LeaseStatus.HELD

    with both.database.writing() as session:
        recovery = lost_attempts.recover(session, read_before, both.settings)

    assert recovery.requeued == []
    assert both.finish(claim)


def test_a_run_released_at_shutdown_is_no_failed_attempt(both: Backend) -> None:
    run_id = both.queue("ann")

    for _ in range(5):
        claim = both.claim()
        assert claim is not None
        with both.database.writing() as session:
            lost_attempts.release(session, claim, AttemptEnd.SHUTDOWN, settings=both.settings)

    assert both.show(run_id).state is RunState.QUEUED


@pytest.mark.parametrize("claimed", [False, True])
def test_a_live_run_is_cancelled_at_once(both: Backend, *, claimed: bool) -> None:
    run_id = both.queue("ann")
    claim = both.claim() if claimed else None

    with both.database.writing() as session:
        first = results.cancel(session, run_id)
        second = results.cancel(session, run_id)

    assert (first, second) == (RunState.RUNNING if claimed else RunState.QUEUED, None)
    assert both.show(run_id).state is RunState.CANCELLED
    if claim is not None:
        assert _heartbeat(both, claim) is LeaseStatus.CANCELLED
        assert not both.finish(claim)
        assert both.finish(claim, state=RunState.CANCELLED, detail={"t_reached": 3.0})
        assert both.show(run_id).detail == {"t_reached": 3.0}


def test_uploads_go_only_to_workers_that_can_run_them(both: Backend) -> None:
    run_id = both.queue("ann")
    with both.database.writing() as session:
        change = update(Run).where(Run.id == run_id)
        session.execute(change.values(language="python", program_sha256="0" * 64))

    assert both.claim("incapable", languages=()) is None
    assert both.claim("capable", languages=("python",)) is not None


def test_a_result_without_a_finite_score_is_refused_and_nothing_is_written(both: Backend) -> None:
    run_id = both.queue("ann")
    claim = both.claim_next()

    with pytest.raises(ResultInvalid):
        both.finish(claim, score=float("nan"))

    assert both.show(run_id).state is RunState.RUNNING


def test_a_ranked_run_shows_no_seed(both: Backend) -> None:
    run_id = both.queue("ann", kind=RunKind.RANKED)

    assert both.show(run_id).seed is None
    assert both.show(run_id).trials == 10


def test_a_reading_transaction_sees_one_moment_while_a_worker_claims_the_run(both: Backend) -> None:
    run_id = both.queue("ann")

    with both.database.reading() as session:
        before = views.show(session, run_id, both.settings)
        session.expire_all()
        assert both.claim() is not None
        after = views.show(session, run_id, both.settings)

    assert before is not None
    assert after is not None
    assert (before.state, after.state) == (RunState.QUEUED, RunState.QUEUED)


def test_a_run_that_was_claimed_after_it_was_read_has_no_position(both: Backend) -> None:
    run_id = both.queue("ann")
    with both.database.reading() as session:
        read_before = session.get_one(Run, run_id)
    assert both.claim() is not None

    with both.database.reading() as session:
        wait = wait_estimate.wait_of(session, read_before, both.settings)

    assert wait.position is None


def test_a_queued_run_says_why_it_waits(both: Backend) -> None:
    run_id = both.queue("ann")

    assert "No worker is running" in (both.show(run_id).why_waiting or "")


class _Story:
    """What happens to the runs of one user, step by step."""

    def __init__(self, both: Backend) -> None:
        self.both = both
        self.owner = both.sign_up(f"u{time.time_ns()}").name
        self.claims: list[Claim] = []
        self.queued: list[int] = []
        self.finished: Counter[int] = Counter()

    def tell(self, step: str) -> None:
        if step in {"queue", "claim"}:
            getattr(self, step)()
        elif step == "cancel":
            for run_id in self.queued[:1]:
                with self.both.database.writing() as session:
                    results.cancel(session, run_id)
        else:
            for claim in self.claims[:1] if step == "stale" else self.claims[-1:]:
                getattr(self, step)(claim)

    def queue(self) -> None:
        if len(self.queued) < self.both.settings.quota_live:
            self.queued.append(self.both.queue(self.owner))

    def claim(self) -> None:
        claim = self.both.claim()
        self.claims += [claim] if claim is not None else []

    def finish(self, claim: Claim) -> None:
        self.finished[claim.run_id] += self.both.finish(claim)

    stale = finish

    def silence(self, claim: Claim) -> None:
        _silence(self.both, claim.run_id)
        _sweep(self.both)

    def back(self, claim: Claim) -> None:
        with self.both.database.writing() as session:
            lost_attempts.release(
                session, claim, AttemptEnd.EVALUATION_BROKE, settings=self.both.settings
            )


def _turns(session: Session) -> set[tuple[object, ...]]:
    columns = (Turn.owner, Turn.priority, Turn.queued, Turn.running, Turn.next_run, Turn.expected_s)
    return {tuple(row) for row in session.execute(select(*columns))}


_steps = st.lists(
    st.sampled_from(["queue", "claim", "finish", "silence", "cancel", "back", "stale"]), max_size=25
)


@pytest.mark.slow
@given(steps=_steps)
@hypothesis_settings(
    max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
def test_no_run_is_lost_or_finished_twice_whatever_happens(both: Backend, steps: list[str]) -> None:
    story = _Story(both)

    for step in steps:
        story.tell(step)

    views = [both.show(run_id) for run_id in story.queued]
    assert all(story.finished[view.id] == (view.state is RunState.SUCCEEDED) for view in views)
    assert all((view.state is RunState.FAILED) == (view.cause is not None) for view in views)
    with both.database.writing() as session:
        kept = _turns(session)
        turns.rebuild(session)
        assert _turns(session) == kept


def test_no_transition_leaves_a_final_state() -> None:
    assert set(NEXT_STATES) == {RunState.QUEUED, RunState.RUNNING}
    assert all(state.final for state in RunState if state not in NEXT_STATES)


def test_workers_that_claim_at_the_same_time_get_different_runs(both: Backend) -> None:
    names = [f"user{number}" for number in range(12)]
    queued = [both.queue(both.sign_up(name).name) for name in names]

    with ThreadPoolExecutor(6) as pool:
        claims = list(pool.map(both.claim, [f"w{number}" for number in range(12)]))

    assert sorted(claim.run_id for claim in claims if claim is not None) == queued
