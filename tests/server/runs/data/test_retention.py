"""Which data of runs are deleted, and that nothing stays half deleted."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sqlalchemy import func, insert, select, update

from seamark.server.database.tables import Run
from seamark.server.programs import check_queue
from seamark.server.runs.data import retention
from seamark.server.runs.data.files import RunFiles
from seamark.server.runs.data.retention import Sweep
from seamark.server.runs.publication import publications
from seamark.server.runs.publication.publications import Terms
from seamark.server.runs.record.states import RunState
from seamark.sim.recording.telemetry import WIDTH
from tests.cast import Backend

DAY_S = 86_400.0
DELETING = """
import sys
from seamark.server.database.engine import Database
from seamark.server.runs.data import retention
from seamark.server.settings import Settings
database = Database(sys.argv[1])
settings = Settings.model_validate({"data": sys.argv[2]})
for run_id in range(1, int(sys.argv[3]) + 1):
    retention.delete(database, settings, [run_id])
    print(run_id, flush=True)
"""


def _record(both: Backend, run_id: int, attempt: int = 1) -> RunFiles:
    files = RunFiles(both.settings.data, run_id, attempt)
    files.append_rows(np.zeros((10, WIDTH)))
    files.append_log(b"hello")
    return files


def _recorded(both: Backend, who: str = "ann", **changes: Any) -> int:
    run_id = both.succeeded(who, **changes)
    _record(both, run_id)
    return run_id


def _age(both: Backend, run_id: int, days: float) -> None:
    change = update(Run).where(Run.id == run_id)
    with both.database.writing() as session:
        session.execute(change.values(finished_at=time.time() - days * DAY_S))


def _sweep(both: Backend, **changes: Any) -> None:
    """Let the maintenance process pass over everything once."""
    settings = both.settings.model_copy(update=changes)
    sweep = Sweep(both.database, settings)
    for _ in range(3):
        sweep.step()


def _has_data(both: Backend, run_id: int) -> bool:
    exists = RunFiles(both.settings.data, run_id).root.exists()
    assert exists == (both.show(run_id).data_deleted_at is None)
    return exists


def test_by_default_the_data_of_accounts_are_kept_for_ever(backend: Backend) -> None:
    run_id = _recorded(backend)
    _age(backend, run_id, 3650)

    _sweep(backend)

    assert _has_data(backend, run_id)


def test_old_data_of_guests_are_deleted_and_the_run_stays(backend: Backend) -> None:
    old, new = _recorded(backend, "guest"), _recorded(backend, "guest")
    _age(backend, old, backend.settings.guest_retention_days + 1)

    _sweep(backend)

    assert (_has_data(backend, old), _has_data(backend, new)) == (False, True)
    view = backend.show(old)
    assert (view.state, view.score, view.data_bytes) == (RunState.SUCCEEDED, 50.0, 0)
    assert view.metrics is not None


def test_old_data_are_deleted_except_published_ones_and_a_users_best(both: Backend) -> None:
    practice, public = _recorded(both), both.publish(_recorded(both))
    best, worse = _recorded(both, kind="ranked"), both.running(kind="ranked")
    both.finish(worse, score=20.0)
    _record(both, worse.run_id)
    everything = [practice, public, best, worse.run_id]
    for run_id in everything:
        _age(both, run_id, 31)

    _sweep(both, retention_days=30)

    assert [_has_data(both, run_id) for run_id in everything] == [False, True, True, False]


def test_beyond_a_total_size_the_oldest_private_practice_data_are_deleted(both: Backend) -> None:
    runs = [_recorded(both) for _ in range(4)]
    both.publish(runs[0])
    with both.database.writing() as session:
        session.execute(update(Run).values(data_bytes=2**20, data_measured=True))

    retention.trim(both.database, both.settings.model_copy(update={"retention_bytes": 2 * 2**20}))

    assert [_has_data(both, run_id) for run_id in runs] == [True, False, False, True]


def test_live_public_and_deleted_runs_are_not_deleted(both: Backend) -> None:
    running, public, gone = both.running().run_id, both.published(), both.succeeded()

    deleted = [retention.delete(both.database, both.settings, [gone]) for _ in range(2)]
    refused = [
        retention.delete(both.database, both.settings, [run_id])
        for run_id in (running, public, 999)
    ]

    assert (deleted, refused) == ([[gone], []], [[], [], []])


def test_a_run_without_its_data_cannot_be_published(backend: Backend) -> None:
    run_id = _recorded(backend, kind="ranked")
    retention.delete(backend.database, backend.settings, [run_id])

    with backend.database.writing() as session:
        assert not publications.publish(session, run_id, Terms())


def test_dead_attempts_are_removed_and_the_last_one_kept(both: Backend) -> None:
    ended, live = _recorded(both), both.running().run_id
    _record(both, ended, attempt=2)
    with both.database.writing() as session:
        session.execute(update(Run).where(Run.id == live).values(attempt=3))
    for attempt in (2, 3):
        _record(both, live, attempt=attempt)

    _sweep(both)

    assert RunFiles(both.settings.data, ended).attempts() == [2]
    assert RunFiles(both.settings.data, live).attempts() == [3]


def test_a_queued_run_keeps_nothing_of_its_dead_attempts(both: Backend) -> None:
    run_id = both.running().run_id
    _record(both, run_id)
    with both.database.writing() as session:
        values = {"state": RunState.QUEUED, "worker": None, "lease_until": None}
        session.execute(update(Run).where(Run.id == run_id).values(values))
    other = _record(both, run_id, attempt=2)  # of a worker that claimed it a moment ago

    _sweep(both)

    assert RunFiles(both.settings.data, run_id).attempts() == [other.attempt]


def test_files_without_a_run_are_removed_when_they_are_old(backend: Backend) -> None:
    orphan, recent = _record(backend, 5_000), _record(backend, 6_000)
    os.utime(orphan.root, (0, 0))

    _sweep(backend)

    assert (orphan.root.exists(), recent.root.exists()) == (False, True)


def test_what_nobody_measured_is_measured(both: Backend) -> None:
    program, record = both.store_program(), both.store_record()
    uploads: dict[str, Any] = {
        "program": program,
        "files": (record,),
        "config": {"current_record": record.name},
    }
    cancelled = both.running(controller="upload", **uploads).run_id
    files = _record(both, cancelled)
    both.cancel(cancelled)  # and its worker died
    assert both.show(cancelled).data_bytes > 2**20

    _sweep(both)
    assert both.show(cancelled).data_bytes > 2**20  # its worker may still be about to do it
    _age(both, cancelled, 0.1)
    _sweep(both)

    assert both.show(cancelled).data_bytes == files.size() + program.size + len(record.content)


def test_nothing_is_concluded_from_a_data_folder_that_is_away(
    backend: Backend, tmp_path: Path
) -> None:
    run_id = backend.running().run_id
    _record(backend, run_id)
    backend.cancel(run_id)
    _age(backend, run_id, 1)
    before = backend.show(run_id).data_bytes
    os.rename(backend.settings.data, tmp_path / "away")

    _sweep(backend)

    assert backend.show(run_id).data_bytes == before > 0


def test_a_worker_that_closes_a_deleted_run_does_not_bring_it_back(backend: Backend) -> None:
    claim = backend.running()
    backend.cancel(claim.run_id)
    retention.delete(backend.database, backend.settings, [claim.run_id])

    backend.finish(claim, state=RunState.CANCELLED, data_bytes=5)

    assert backend.show(claim.run_id).data_bytes == 0


def test_a_program_goes_with_the_data_of_its_last_run(backend: Backend) -> None:
    program = backend.store_program()
    first, second = (_recorded(backend, controller="upload", program=program) for _ in range(2))

    def referred_to() -> bool:
        with backend.database.reading() as session:
            return check_queue.refers_to(session, program.sha256)

    retention.delete(backend.database, backend.settings, [first])
    assert referred_to()
    retention.delete(backend.database, backend.settings, [second])
    assert not referred_to()


@pytest.mark.slow
def test_a_deletion_that_is_killed_leaves_nothing_half_deleted(both: Backend) -> None:
    runs = [_recorded(both) for _ in range(30)]
    arguments = [both.settings.database_url, str(both.settings.data), str(len(runs))]
    deleting = subprocess.Popen(
        [sys.executable, "-s", "-P", "-c", DELETING, *arguments], stdout=subprocess.PIPE, text=True
    )
    assert deleting.stdout is not None
    assert deleting.stdout.readline() == "1\n"
    deleting.send_signal(signal.SIGKILL)
    deleting.wait()
    deleting.stdout.close()

    for run_id in runs:
        if both.show(run_id).data_deleted_at is None:
            assert RunFiles(both.settings.data, run_id).row_count() == 10
    _sweep(both)

    kept = [run_id for run_id in runs if _has_data(both, run_id)]
    assert 1 not in kept
    with both.database.reading() as session:
        deleted = session.scalar(select(func.count()).where(Run.data_deleted_at.is_not(None)))
    assert deleted == len(runs) - len(kept)


def test_half_removed_files_of_a_deleted_run_are_removed(backend: Backend) -> None:
    run_id = _recorded(backend)
    with backend.database.writing() as session:
        assert retention.mark(session, [run_id]) == [run_id]
    (RunFiles(backend.settings.data, run_id).folder / "telemetry.f64").unlink()

    _sweep(backend)

    assert not _has_data(backend, run_id)


@pytest.mark.parametrize("count", [retention.BATCH + 5])
def test_deletions_come_in_bounded_batches(both: Backend, count: int) -> None:
    with both.database.writing() as session:
        one = both.succeeded("ben")
        row = {c.name: getattr(session.get_one(Run, one), c.name) for c in Run.__table__.columns}
    old = row | {"owner": "guest:n", "user_id": None, "guest": "g", "finished_at": 1.0}
    with both.database.engine.begin() as connection:
        rows = [old | {"id": 100 + number} for number in range(count)]
        connection.execute(insert(Run), rows)

    Sweep(both.database, both.settings).step()

    with both.database.reading() as session:
        deleted = session.scalar(select(func.count()).where(Run.data_deleted_at.is_not(None)))
    assert deleted == retention.BATCH
