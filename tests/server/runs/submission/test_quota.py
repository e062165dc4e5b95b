"""The limit of ranked runs: per user and benchmark, in 24 hours."""

import pytest
from sqlalchemy import text

from seamark.server.runs.record.states import RunState
from seamark.server.runs.submission import baselines
from seamark.server.runs.submission.quota import QuotaExceeded
from tests.cast import Backend

LIMIT = 2
HOUR_S = 3600.0


@pytest.fixture
def limited(both: Backend) -> Backend:
    settings = both.settings.model_copy(update={"ranked_day": LIMIT})
    return Backend(both.database, settings, both.viewers)


def _use_up(limited: Backend) -> None:
    for _ in range(LIMIT):
        limited.succeeded("ann", kind="ranked")


def test_the_ranked_runs_of_a_user_in_a_benchmark_are_limited(limited: Backend) -> None:
    _use_up(limited)

    with pytest.raises(
        QuotaExceeded, match=r"2 ranked runs of currents-v1 .* in 24\.0 h"
    ) as refused:
        limited.queue("ann", kind="ranked")

    assert "possible in 24.0 h" in str(refused.value)
    assert 24 * HOUR_S - 60 < refused.value.retry_after_s <= 24 * HOUR_S


def test_queued_runs_count_too(limited: Backend) -> None:
    limited.queue("ann", kind="ranked")
    limited.queue("ann", kind="ranked")

    with pytest.raises(QuotaExceeded, match="ranked runs"):
        limited.queue("ann", kind="ranked")


def test_other_benchmarks_other_users_and_practice_do_not_count(limited: Backend) -> None:
    _use_up(limited)

    limited.queue("ben", kind="ranked")
    limited.queue("ann", kind="ranked", benchmark="currents-v2")
    limited.queue("ann")


def test_a_platform_failure_and_a_cancellation_before_the_start_do_not_count(
    limited: Backend,
) -> None:
    broken = limited.running("ann", kind="ranked")
    limited.finish(
        broken, state=RunState.FAILED, cause="platform_error", metrics=None, manifest=None
    )
    limited.cancel(limited.queue("ann", kind="ranked"))

    _use_up(limited)


@pytest.mark.parametrize("cause", ["user_error", "benchmark_error"])
def test_a_failure_of_the_program_counts(limited: Backend, cause: str) -> None:
    failed = limited.running("ann", kind="ranked")
    limited.finish(failed, state=RunState.FAILED, cause=cause, metrics=None)
    limited.succeeded("ann", kind="ranked")

    with pytest.raises(QuotaExceeded, match="ranked runs"):
        limited.queue("ann", kind="ranked")


def test_a_run_that_was_cancelled_after_its_start_counts(limited: Backend) -> None:
    limited.cancel(limited.running("ann", kind="ranked").run_id)
    limited.succeeded("ann", kind="ranked")

    with pytest.raises(QuotaExceeded, match="ranked runs"):
        limited.queue("ann", kind="ranked")


def test_a_day_later_there_are_new_ones(limited: Backend) -> None:
    _use_up(limited)
    with limited.database.engine.begin() as connection:
        connection.execute(text("UPDATE runs SET queued_at = queued_at - 86401 WHERE id = 1"))

    limited.queue("ann", kind="ranked")


@pytest.mark.slow
def test_baselines_have_no_limit(backend: Backend) -> None:
    settings = backend.settings.model_copy(update={"ranked_day": 1})

    with backend.database.writing() as session:
        first = baselines.ensure(session, settings)
    for run_id in first:
        assert backend.cancel(backend.claim_next().run_id), run_id
    with backend.database.writing() as session:
        again = baselines.ensure(session, settings)

    assert len(again) == len(first) > 0
