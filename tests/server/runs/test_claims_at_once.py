"""Claims at the same time on PostgreSQL, and machines that vanish in the middle of one."""

import time
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager

import pytest
from sqlalchemy import update
from sqlalchemy.orm import Session

from seamark.server.accounts.permissions import Viewer
from seamark.server.database.engine import Database
from seamark.server.database.tables import Run
from seamark.server.messaging import broker
from seamark.server.programs import check_queue
from seamark.server.runs.queue import lost_attempts, start_order
from seamark.server.runs.queue import queue as run_queue
from seamark.server.runs.queue.order import GUEST_SHARE
from seamark.server.runs.queue.queue import Claim
from seamark.server.runs.record.states import RunState
from seamark.server.runs.submission import baselines
from seamark.server.settings import Settings
from seamark.worker.service.maintenance import Recoverer
from tests.cast import Backend
from tests.services import tables

CLAIMERS = 8
PATIENCE_S = 60.0


@pytest.fixture
def backend(settings: Settings, postgres_tables_url: str) -> Iterator[Backend]:
    """The cast on PostgreSQL."""
    settings = settings.model_copy(update={"database_url": postgres_tables_url})
    database = tables.adopt(settings)
    yield Backend.with_cast(database, settings)
    database.close()


@contextmanager
def _vanished(backend: Backend, *, idle_s: float = PATIENCE_S) -> Iterator[Session]:
    """Yield a transaction of a machine that has claimed a run, and is not heard of any more."""
    machine = Database(backend.settings.database_url, idle_s=idle_s)
    session = Session(machine.engine)
    claim = run_queue.try_claim(session, "gone", languages=(), settings=backend.settings)
    assert claim is not None
    yield session
    session.invalidate()
    machine.close()


def _claimed_within_patience(backend: Backend) -> Claim:
    until = time.monotonic() + PATIENCE_S
    while (claim := backend.claim()) is None:
        assert time.monotonic() < until
    return claim


def _at_once(backend: Backend, count: int) -> list[Claim]:
    """Claim so many times, by several workers at the same time."""
    with ThreadPoolExecutor(CLAIMERS) as pool:
        claims = pool.map(backend.claim, [f"w{number}" for number in range(count)])
        return [claim for claim in claims if claim is not None]


def test_a_machine_that_vanishes_in_a_claim_stops_no_other_owner(backend: Backend) -> None:
    backend.queue("ann")
    bens = [backend.queue("ben") for _ in range(2)]

    with _vanished(backend):
        claims = [backend.claim_next().run_id for _ in bens]

    assert claims == bens


def test_the_owner_of_a_claim_that_vanished_goes_on_when_the_server_has_ended_it(
    backend: Backend,
) -> None:
    anns = [backend.queue("ann") for _ in range(2)]

    with _vanished(backend, idle_s=0.5):
        claim = _claimed_within_patience(backend)

    assert (claim.run_id, claim.attempt) == (anns[0], 1)


def test_a_machine_that_vanishes_in_a_claim_delays_no_recovery(backend: Backend) -> None:
    lost = backend.running("ben")
    backend.queue("ann")
    with backend.database.writing() as session:
        session.execute(update(Run).where(Run.id == lost.run_id).values(lease_until=1.0))

    with _vanished(backend), backend.database.writing() as session:
        recovery = lost_attempts.recover(session, {lost.run_id: 1.0}, backend.settings)

    assert recovery.requeued == [lost.run_id]


def test_a_run_whose_owner_is_held_by_a_vanished_machine_is_recovered_later(
    backend: Backend,
) -> None:
    anns, bens = backend.running("ann"), backend.running("ben")
    backend.queue("ann")
    with backend.database.writing() as session:
        session.execute(update(Run).where(Run.state == RunState.RUNNING).values(lease_until=1.0))
    leases = {anns.run_id: 1.0, bens.run_id: 1.0}

    with _vanished(backend), backend.database.writing() as session:
        first = lost_attempts.recover(session, leases, backend.settings)
    with backend.database.writing() as session:
        second = lost_attempts.recover(session, leases, backend.settings)

    assert (first.requeued, second.requeued) == ([bens.run_id], [anns.run_id])


def test_a_machine_that_vanishes_in_the_maintenance_stops_no_recovery(backend: Backend) -> None:
    lost = backend.running("ben")
    app, redis = broker.celery_app(backend.settings), broker.connect(backend.settings)
    quick = backend.settings.model_copy(update={"lease_s": 0.001})
    machine = Database(backend.settings.database_url, idle_s=PATIENCE_S)

    with Session(machine.engine) as vanished:
        lost_attempts.tidy(vanished)
        recoverer = Recoverer(app, backend.database, redis, quick)
        recoverer.recover_runs()
        recoverer.recover_runs()

    machine.close()
    assert backend.show(lost.run_id).state is RunState.QUEUED


def test_a_machine_that_vanishes_with_a_check_stops_no_other_check(backend: Backend) -> None:
    program = backend.store_program()
    with backend.database.writing() as session:
        ids = [
            check_queue.enqueue(session, backend.user_id(who), "currents-v1", {}, program)
            for who in ("ann", "ben")
        ]
    machine = Database(backend.settings.database_url, idle_s=PATIENCE_S)

    with Session(machine.engine) as vanished:
        first = check_queue.claim(vanished, "gone", languages=("python",), lease_s=30.0)
        with backend.database.writing() as session:
            second = check_queue.claim(session, "here", languages=("python",), lease_s=30.0)
            check_queue.recover(session, {ids[0]: 1.0})

    machine.close()
    assert first is not None
    assert second is not None
    assert [first.check_id, second.check_id] == ids


def test_claims_at_once_take_each_run_once_and_keep_the_limit_of_each_owner(
    backend: Backend,
) -> None:
    limit = backend.settings.running_max
    names = [backend.sign_up(f"user{number}").name for number in range(3)]
    queued = {backend.queue(name) for name in names for _ in range(limit + 1)}

    claims = _at_once(backend, len(queued) + CLAIMERS)
    running = Counter(claim.user_id for claim in claims)
    for claim in claims:
        backend.finish(claim)
    rest = _at_once(backend, len(queued))

    assert set(running.values()) == {limit}
    assert sorted(claim.run_id for claim in [*claims, *rest]) == sorted(queued)


def test_claims_at_once_start_what_claims_one_after_the_other_would(backend: Backend) -> None:
    names = [backend.sign_up(f"user{number}").name for number in range(2 * CLAIMERS)]
    for name in names * 2:
        backend.queue(name)
    with backend.database.reading() as session:
        order = start_order.first(session, 2 * CLAIMERS)

    claims = _at_once(backend, len(order))

    assert {claim.run_id for claim in claims} == set(order)


def test_claims_at_once_leave_the_runs_of_others_behind_those_of_accounts(
    backend: Backend,
) -> None:
    backend.viewers["g"] = Viewer(guest="g", network="n")
    anns = {backend.queue("ann") for _ in range(backend.settings.running_max)}
    guests = {backend.queue("g") for _ in range(2)}

    claims = {claim.run_id for claim in _at_once(backend, len(anns))}

    assert len(claims - guests) >= len(anns) - 1  # one guest has its share after four
    assert len(claims) == len(anns)


def test_claims_at_once_start_one_baseline(backend: Backend) -> None:
    with backend.database.writing() as session:
        submitted = baselines.ensure(session, backend.settings)

    claims = _at_once(backend, 2 * CLAIMERS)

    assert len(submitted) > 1
    assert len(claims) == 1


def test_guests_have_their_share_of_claims_at_once(backend: Backend) -> None:
    backend.viewers["g"] = Viewer(guest="g", network="n")
    names = [backend.sign_up(f"user{number}").name for number in range(40)]
    for name in names:
        backend.queue(name)
    guests = {backend.queue("g") for _ in range(backend.settings.running_max)}

    claims = {claim.run_id for claim in _at_once(backend, 40)}

    # After four runs of accounts, and what starts while the fourth does, and the guest's.
    cycle = GUEST_SHARE + 2 * (CLAIMERS - 1) + 1
    assert len(claims & guests) >= 40 // cycle
