"""Logs that are stored: all of it or nothing, and without keeping the database from others."""

import os
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from sqlalchemy import func, select

from seamark.mission_logs.result import LogResult
from seamark.server.database.engine import Database
from seamark.server.database.tables import Result, Run
from seamark.server.runs.data import run_objects, staging, stored_files
from seamark.server.runs.logs import mission_logs
from seamark.server.runs.submission.quota import QuotaExceeded
from seamark.server.settings import Settings
from seamark.server.storage import objects
from seamark.server.storage.storage import StorageUnavailable
from seamark.sim import registry
from seamark.sim.recording import telemetry
from seamark.sim.recording.telemetry import INDEX, WIDTH, Rows
from tests.cast import Backend
from tests.services import s3, tables


@dataclass(frozen=True, kw_only=True)
class Found(LogResult):
    """A measured log, which remembers when its rows were read."""

    database: Database
    written: list[bool]

    def __getattribute__(self, name: str) -> object:
        if name == "rows":  # somebody else writes meanwhile
            with object.__getattribute__(self, "database").writing() as session:
                session.connection()
                object.__getattribute__(self, "written").append(True)
        return object.__getattribute__(self, name)


def _rows(count: int = 40) -> Rows:
    table = np.zeros((count, WIDTH))
    table[:, INDEX["t"]] = 0.05 * np.arange(count)
    return table


def log_of(rows: Rows) -> LogResult:
    """Return a log as it was measured."""
    metrics = {"score": None, "level_held": None, "not_ranked": "A log is never ranked."}
    return LogResult(
        benchmark="currents-v1",
        config=registry.benchmark("currents-v1").read({}).model_dump(mode="json"),
        trials=1,
        rows=rows,
        metrics=metrics | {"trials": []},
        manifest={"absent": [], "digest": telemetry.digest(rows)},
        digest=telemetry.digest(rows),
    )


def store(backend: Backend, found: LogResult) -> int:
    viewer = backend.viewers["ann"]
    return mission_logs.store(backend.database, backend.settings, viewer, found, title="pool")


def runs_and_results(backend: Backend) -> tuple[int, int]:
    with backend.database.reading() as session:
        counts = [session.scalar(select(func.count()).select_from(one)) for one in (Run, Result)]
    return counts[0] or 0, counts[1] or 0


def files_in(data: Path) -> list[str]:
    """Return the files of runs, and of what is to become one."""
    names = ("runs", "staged")
    found = [file for name in names if (data / name).is_dir() for file in (data / name).rglob("*")]
    return sorted(file.name for file in found if file.is_file())


def test_others_can_write_to_the_database_whenever_the_rows_of_a_log_are_read(
    backend: Backend,
) -> None:
    other = Database(backend.settings.database_url, busy_s=0.0)
    measured = log_of(_rows())
    found = Found(**vars(measured), database=other, written=[])

    run_id = store(backend, found)

    other.close()
    assert found.written
    files = stored_files.of_run(backend.settings, backend.show(run_id))
    assert files.rows().tolist() == measured.rows.tolist()
    assert files.manifest() == measured.manifest


@pytest.mark.parametrize("blocked", ["staged", "runs"])
def test_a_log_whose_files_cannot_be_written_leaves_nothing(backend: Backend, blocked: str) -> None:
    (backend.settings.data / blocked).write_text("in the way")

    with pytest.raises(StorageUnavailable):
        store(backend, log_of(_rows()))

    assert runs_and_results(backend) == (0, 0)
    (backend.settings.data / blocked).unlink()
    assert files_in(backend.settings.data) == []
    assert store(backend, log_of(_rows())) == 1


def test_a_log_that_does_not_fit_into_the_quota_leaves_nothing(backend: Backend) -> None:
    backend.settings = backend.settings.model_copy(update={"quota_bytes": 1000})

    with pytest.raises(QuotaExceeded):
        store(backend, log_of(_rows()))

    assert runs_and_results(backend) == (0, 0)
    assert files_in(backend.settings.data) == []


def test_files_of_a_run_that_never_was_do_not_get_into_a_log(backend: Backend) -> None:
    left = backend.settings.data / "runs" / "0" / "1" / "1"
    left.mkdir(parents=True)
    (left / "telemetry.f64").write_bytes(bytes(8 * WIDTH))

    run_id = store(backend, log_of(_rows()))

    assert run_id == 1
    files = stored_files.of_run(backend.settings, backend.show(run_id))
    assert files.row_count() == 40


@pytest.fixture
def on_s3(settings: Settings, s3_server: s3.Server, tmp_path: Path) -> Iterator[Backend]:
    """The cast on a service that keeps its files in S3."""
    shared = s3_server.settings(tmp_path.name) | {"seed_key": "of the tests"}
    chosen = Settings.model_validate(settings.model_dump() | shared)
    database = tables.create(chosen)
    yield Backend.with_cast(database, chosen)
    database.close()


@pytest.mark.slow
def test_a_log_is_kept_in_object_storage_and_read_from_there(on_s3: Backend) -> None:
    stored = objects.of(on_s3.settings)
    assert stored is not None

    run_id = store(on_s3, log_of(_rows()))

    (attempt,) = run_objects.attempts(stored, run_id).values()
    assert attempt.complete
    assert stored.list("staged") == []
    elsewhere = on_s3.settings.model_copy(update={"data": on_s3.settings.data / "elsewhere"})
    elsewhere.data.mkdir()
    files = stored_files.of_run(elsewhere, on_s3.show(run_id))
    assert files.rows().tolist() == _rows().tolist()
    marker = attempt.files[run_objects.COMPLETE]
    assert on_s3.show(run_id).data_bytes == attempt.size - marker.size


def test_a_log_leaves_nothing_if_the_object_storage_fails_half_way(
    backend: Backend, tmp_path: Path
) -> None:
    shared = tmp_path / "shared"
    backend.settings = backend.settings.model_copy(update={"storage_url": f"file://{shared}"})
    stored = objects.of(backend.settings)
    assert stored is not None
    stored.put(objects.MARK, b"of the tests")
    (shared / run_objects.folder(1, 1) / "metrics.json").mkdir(parents=True)  # in the way

    with pytest.raises(StorageUnavailable):
        store(backend, log_of(_rows()))

    assert runs_and_results(backend) == (0, 0)
    assert [*stored.list("runs"), *stored.list("staged")] == []
    assert files_in(backend.settings.data / "cache") == []


def test_what_a_crash_left_aside_is_removed_after_a_day_and_what_others_write_is_not(
    backend: Backend,
) -> None:
    aside = backend.settings.data / "staged"
    for name, age_s in (("left", staging.LEFT_S + 60.0), ("written", 60.0)):
        (aside / name).mkdir(parents=True)
        (aside / name / "telemetry.f64").write_bytes(b"rows")
        os.utime(aside / name, (time.time() - age_s,) * 2)

    store(backend, log_of(_rows()))

    assert [entry.name for entry in aside.iterdir()] == ["written"]
