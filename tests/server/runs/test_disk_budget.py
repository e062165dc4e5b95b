"""What a run may write, and what all runs of an owner may take on disk together."""

import threading
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import pytest
from sqlalchemy import func, select, text

from seamark.server.accounts.permissions import Viewer
from seamark.server.database.tables import Run
from seamark.server.runs.submission import baselines, quota
from seamark.server.runs.submission.quota import QuotaExceeded
from seamark.server.runs.submission.validation import SubmissionRejected
from tests.cast import Backend

MIB = 2**20
LONG: dict[str, Any] = {
    "levels": [round(0.05 * n, 2) for n in range(12)],
    "level_duration_s": 600.0,
}
SHORT: dict[str, Any] = {"levels": [0.0], "level_duration_s": 10.0, "settle_s": 1.0}


def _with(both: Backend, **changes: Any) -> Backend:
    return Backend(both.database, both.settings.model_copy(update=changes), both.viewers)


def _size(both: Backend, run_id: int) -> int:
    with both.database.reading() as session:
        return session.get_one(Run, run_id).data_bytes


def test_an_order_of_gigabytes_is_refused_with_its_size_and_what_to_change(both: Backend) -> None:
    config = LONG | {"control_period_s": 0.01}

    with pytest.raises(SubmissionRejected, match=r"7,200,000 rows.* 3\.\d+ GiB.* 256 MiB") as why:
        both.queue("guest", config=config, trials=10)

    assert "fewer levels or trials" in str(why.value)


def test_the_largest_run_at_the_usual_rate_is_accepted(backend: Backend) -> None:
    assert backend.queue("ann", config=LONG, trials=4)


def test_a_ranked_run_is_as_large_as_its_benchmark_says(backend: Backend) -> None:
    assert _with(backend, run_max_bytes=MIB).queue("ann", kind="ranked", benchmark="currents-v2")


def test_a_queued_run_counts_with_what_it_may_record(backend: Backend) -> None:
    small, twice = backend.queue("ann", config=SHORT), backend.queue("ann", config=SHORT, trials=2)
    program = backend.queue_program("ann", config=SHORT)

    rows = 200  # 10 s at 20 Hz
    assert _size(backend, small) > rows * 8 * 50
    assert _size(backend, twice) - _size(backend, small) > rows * 8 * 50
    assert _size(backend, program) > _size(backend, small)  # it has a log, and is stored itself


def test_the_runs_of_an_account_share_its_disk_space(backend: Backend) -> None:
    size = _size(backend, backend.queue("ben", config=SHORT))
    limited = _with(backend, quota_bytes=2 * size)
    limited.queue("ann", config=SHORT)
    limited.queue("ann", config=SHORT)

    with pytest.raises(QuotaExceeded, match=r"Your runs take .* Delete the data of runs") as why:
        limited.queue("ann", config=SHORT)

    assert why.value.retry_after_s > 0
    assert limited.queue("eva", config=SHORT)


def test_guests_of_a_network_share_their_disk_space(backend: Backend) -> None:
    size = _size(backend, backend.queue("ben", config=SHORT))
    limited = _with(backend, guest_quota_bytes=size)
    for name, network in (("one", "n"), ("two", "n"), ("far", "m")):
        limited.viewers[name] = Viewer(guest=name, network=network)
    limited.queue("one", config=SHORT)

    with pytest.raises(QuotaExceeded, match="guests of your network"):
        limited.queue("two", config=SHORT)

    assert limited.queue("far", config=SHORT)


def test_a_run_that_was_cancelled_before_it_started_takes_no_space(backend: Backend) -> None:
    size = _size(backend, backend.queue("ben", config=SHORT))
    limited = _with(backend, quota_bytes=size)
    limited.cancel(limited.queue("ann", config=SHORT))

    assert limited.queue("ann", config=SHORT)


def test_a_finished_run_counts_with_what_it_recorded(backend: Backend) -> None:
    claim = backend.running("ann", config=SHORT)

    backend.finish(claim, data_bytes=123)

    assert _size(backend, claim.run_id) == 123
    with backend.database.reading() as session:
        used = quota.used_by(session, backend.viewers["ann"], backend.settings)
    assert (used.bytes, type(used.bytes)) == (123, int)


@pytest.mark.parametrize("who", ["ann", "guest"])
def test_runs_submitted_at_once_do_not_exceed_the_disk_space_together(
    both: Backend, who: str
) -> None:
    size = _size(both, both.queue("ben", config=SHORT))
    limits = {"quota_bytes": 3 * size, "guest_quota_bytes": 3 * size, "quota_live": 100}
    limited = _with(both, **limits)
    start = threading.Barrier(8)

    def submit(_: int) -> bool:
        start.wait()
        try:
            limited.queue(who, config=SHORT)
        except QuotaExceeded:
            return False
        return True

    with ThreadPoolExecutor(8) as pool:
        accepted = list(pool.map(submit, range(8)))

    owner = limited.viewers[who].owner
    with both.database.reading() as session:
        taken = session.scalar(select(func.sum(Run.data_bytes)).where(Run.owner == owner))
    assert (accepted.count(True), taken) == (3, 3 * size)


def test_baselines_have_no_limit_of_space(backend: Backend) -> None:
    with backend.database.writing() as session:
        assert baselines.ensure(session, _with(backend, quota_bytes=1).settings)


def test_a_rerun_counts_the_program_again_and_needs_it(backend: Backend) -> None:
    first = backend.queue_program("ann", config=SHORT)
    again = backend.rerun(first)
    assert _size(backend, again) == _size(backend, first)

    for file in (backend.settings.data / "programs").iterdir():
        file.unlink()

    with pytest.raises(SubmissionRejected, match="has been deleted"):
        backend.rerun(first)


def test_the_space_of_an_owner_is_summed_from_an_index(both: Backend) -> None:
    query = quota.bytes_of("user:1").compile(
        both.database.engine, compile_kwargs={"literal_binds": True}
    )
    explain = "EXPLAIN QUERY PLAN " if both.database.engine.dialect.name == "sqlite" else "EXPLAIN "
    with both.database.reading() as session:
        if both.database.engine.dialect.name == "postgresql":
            session.execute(text("SET LOCAL enable_seqscan = off"))
            session.execute(text("SET LOCAL enable_bitmapscan = off"))
        plan = " ".join(str(row) for row in session.execute(text(explain + str(query))))

    assert "ix_runs_owner_bytes" in plan
