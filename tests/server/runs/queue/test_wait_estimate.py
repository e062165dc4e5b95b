"""The estimate of a wait: from measured durations, near what happens, without jumps."""

import time
from itertools import pairwise

import pytest
from sqlalchemy import update

from seamark.server.database.tables import Run, Worker
from seamark.server.messaging import workers
from seamark.server.runs.queue import paces
from seamark.server.runs.queue.queue import Claim
from tests.cast import Backend

SHORT = {"levels": [0.0], "level_duration_s": 10.0, "settle_s": 1.0}
LONG = {"levels": [0.0], "level_duration_s": 100.0, "settle_s": 1.0}


def _slots(both: Backend, slots: int) -> None:
    worker = Worker(name="host", slots=slots, level="none", languages=[], findings=[])
    with both.database.writing() as session:
        workers.register(session, worker)


def _measured(both: Backend, pace: float) -> None:
    """Have one run succeed whose evaluation took `pace` seconds for each simulated second."""
    claim = both.running("eva")
    with both.database.writing() as session:
        started = {"started_at": time.time() - 20.0 * pace}
        session.execute(update(Run).where(Run.id == claim.run_id).values(**started))
    both.finish(claim, t_simulated=20.0)


def _estimate(both: Backend, run_id: int) -> float:
    estimate_s = both.show(run_id).estimate_s
    assert estimate_s is not None
    return estimate_s


def _ends(both: Backend, slots: int) -> dict[int, float]:
    """Return when each queued run ends [s] if all take as long as they were expected to."""
    now, ends = 0.0, dict[int, float]()
    live: list[tuple[float, int, Claim]] = []
    while True:
        while len(live) < slots and (claim := both.claim()) is not None:
            with both.database.reading() as session:
                expected_s = session.get_one(Run, claim.run_id).expected_s
            assert expected_s is not None
            live.append((now + expected_s, claim.run_id, claim))
        if not live:
            return ends
        first = min(live)
        live.remove(first)
        now, run_id, claim = first
        ends[run_id] = now
        both.finish(claim)


def test_nothing_is_estimated_before_anything_was_measured(backend: Backend) -> None:
    _slots(backend, 2)

    assert backend.show(backend.queue("ann")).estimate_s is None


@pytest.mark.slow
def test_an_estimate_follows_the_simulated_time_of_the_run(backend: Backend) -> None:
    _slots(backend, 2)
    early = backend.queue("ben", config=LONG, trials=2)
    backend.cancel(backend.queue("ann"))
    early_claim = backend.claim_next()
    _measured(backend, pace=0.5)

    assert _estimate(backend, backend.queue("ann", config=SHORT)) == pytest.approx(5.0, rel=0.05)
    assert _estimate(backend, backend.queue("eva", config=LONG, trials=3)) > 150.0
    assert _estimate(backend, early_claim.run_id) == pytest.approx(100.0, rel=0.05)
    assert early == early_claim.run_id


def test_recent_runs_count_more_than_old_ones(backend: Backend) -> None:
    run_id = backend.succeeded("ann")
    for wall_s in [*[100.0] * 10, *[20.0] * 30]:
        with backend.database.writing() as session:
            paces.record(session, run_id, wall_s=wall_s, simulated_s=100.0)
            pace = paces.expected_s(session, session.get_one(Run, run_id), 1.0)

    assert pace is not None
    assert 0.2 < pace < 0.3


@pytest.mark.slow
@pytest.mark.parametrize("slots", [1, 2, 4])
def test_every_estimate_in_a_known_queue_is_within_a_factor_of_two(
    backend: Backend, slots: int
) -> None:
    _measured(backend, pace=1.0)
    _slots(backend, slots)
    for who, config in (("ann", SHORT), ("ben", LONG), ("eva", SHORT), ("guest", LONG)):
        for _ in range(3):
            backend.queue(who, config=config)
    for who in ("ann", "ann", "ben", "guest"):
        backend.queue(who, config=SHORT)
    with backend.database.reading() as session:
        queued = [run_id for run_id in range(1, 30) if session.get(Run, run_id)][1:]
    estimates = {run_id: _estimate(backend, run_id) for run_id in queued}

    ends = _ends(backend, slots)

    assert set(ends) == set(queued)
    wrong = {run_id: (estimates[run_id], end) for run_id, end in ends.items()}
    wrong = {k: v for k, v in wrong.items() if not v[1] / 2 <= v[0] <= 2 * v[1]}
    assert wrong == {}


def test_the_estimate_of_a_running_run_falls_between_heartbeats_and_does_not_jump_at_them(
    both: Backend,
) -> None:
    _slots(both, 2)
    _measured(both, pace=1.0)
    claim = both.running("ann", config=LONG)
    seen = []

    for elapsed in range(0, 121):  # it takes 120 s although 100 were expected
        heartbeat_at = 5.0 * (elapsed // 5)
        start = time.time() - elapsed
        with both.database.writing() as session:
            change = update(Run).where(Run.id == claim.run_id)
            values = {"started_at": start, "progress": heartbeat_at / 120.0}
            lease = {"lease_until": start + heartbeat_at + both.settings.lease_s}
            session.execute(change.values(**values, **lease))
        seen.append(_estimate(both, claim.run_id))

    steps = [later - earlier for earlier, later in pairwise(seen)]
    assert seen[0] == pytest.approx(100.0, abs=2.0)
    assert seen[-1] == pytest.approx(0.0, abs=2.0)
    assert max(map(abs, steps)) < 4.0


def test_workers_of_before_an_upgrade_shorten_no_wait(both: Backend) -> None:
    _slots(both, 1)
    _measured(both, 1.0)
    for name in ("ben", "eva"):
        both.queue(name, config=LONG)
    waiting = both.queue("ann", config=SHORT)
    alone_s = _estimate(both, waiting)

    with both.database.writing() as session:
        old = Worker(name="old", slots=8, level="none", languages=[], findings=[])
        old.result_code = "{}"
        workers.register(session, old)

    assert _estimate(both, waiting) == pytest.approx(alone_s, abs=1.0)
