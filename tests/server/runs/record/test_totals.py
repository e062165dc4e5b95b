"""Counts of runs that cost the same however many there are."""

import time

import pytest
from sqlalchemy import update

from seamark.server.database import counters
from seamark.server.database.tables import Run
from seamark.server.runs.queue import lost_attempts
from seamark.server.runs.record import totals
from tests.cast import Backend


def _sweep(both: Backend) -> None:
    with both.database.writing() as session:
        lost_attempts.tidy(session)


def _age(both: Backend, run_id: int, ended_s_ago: float) -> None:
    with both.database.writing() as session:
        ended = {"finished_at": time.time() - ended_s_ago}
        session.execute(update(Run).where(Run.id == run_id).values(**ended))


def _totals(both: Backend) -> tuple[dict[str, int], float]:
    with both.database.reading() as session:
        counts, simulated_s = totals.counts_and_simulated_s(session)
        assert totals.counts(session) == counts
        return {str(state): number for state, number in counts.items() if number}, simulated_s


def test_every_run_is_counted_once_before_and_after_maintenance(backend: Backend) -> None:
    with backend.database.writing() as session:
        counters.store(session, totals.UNTIL, 0.0)  # the database is an old one
    _age(backend, backend.succeeded("ann"), 1000.0)
    _sweep(backend)
    backend.failed({})
    backend.succeeded("ben")
    backend.cancel(backend.queue("ann"))
    backend.running("eva")
    backend.queue("ann")
    expected = {"succeeded": 2, "failed": 1, "cancelled": 1, "running": 1, "queued": 1}

    before = _totals(backend)
    _sweep(backend)
    _sweep(backend)

    assert _totals(backend) == before
    assert before[0] == expected
    assert before[1] == pytest.approx(3 * 1800.0)


def test_the_oldest_queued_run_is_found(backend: Backend) -> None:
    with backend.database.reading() as session:
        assert totals.oldest_queued_at(session) is None
    first = backend.queue("ann")
    backend.queue("ben")

    with backend.database.reading() as session:
        assert totals.oldest_queued_at(session) == backend.show(first).queued_at
