"""A backup that is made while runs go on, and what is restored from it."""

import uuid
from collections.abc import Iterator
from hashlib import sha256
from pathlib import Path

import numpy as np
import pytest
from alembic import command
from sqlalchemy import text

from seamark.server.administration.backup import creation, layout, restoring
from seamark.server.administration.backup.archive import ArchiveRejected
from seamark.server.administration.backup.creation import BackupFailed
from seamark.server.administration.backup.restoring import RestoreRefused
from seamark.server.app import create_app
from seamark.server.database import schema
from seamark.server.database.data_folder import WrongDataFolder
from seamark.server.database.engine import Database
from seamark.server.database.tables import Worker
from seamark.server.messaging import workers
from seamark.server.programs import store
from seamark.server.runs.data import retention
from seamark.server.runs.data.files import RunFiles
from seamark.server.runs.queue import lost_attempts
from seamark.server.runs.record.states import RunState
from seamark.server.settings import Settings
from seamark.server.storage import objects, storage
from seamark.sim.recording.telemetry import WIDTH
from tests.cast import Backend
from tests.services import postgres


def nothing(_more: int) -> None:
    """Be told that more bytes have been copied."""


@pytest.fixture(params=["sqlite", pytest.param("postgresql", marks=pytest.mark.host)])
def elsewhere(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Settings]:
    """Another data folder and another database, both empty."""
    data = tmp_path / "elsewhere"
    if request.param == "sqlite":
        yield Settings.model_validate({"data": data})
    else:
        folder: str = request.getfixturevalue("_postgres")
        with postgres.database(folder, f"t{uuid.uuid4().hex}") as url:
            yield Settings.model_validate({"data": data, "database_url": url})


@pytest.fixture
def empty_place(tmp_path: Path) -> Settings:
    """A place on SQLite for a restored service."""
    return Settings.model_validate({"data": tmp_path / "elsewhere"})


def _succeeded(backend: Backend, who: str = "ann", **changes: object) -> int:
    """Return a run with telemetry that has succeeded."""
    claim = backend.running(who, **changes)
    files = RunFiles(backend.settings.data, claim.run_id, claim.attempt)
    files.append_rows(np.full((50, WIDTH), float(claim.run_id)))
    files.append_log(b"started\n")
    files.write_json("manifest.json", {"run": claim.run_id})
    assert backend.finish(claim)
    return claim.run_id


def _file_sums(settings: Settings) -> dict[str, str]:
    """Return the SHA-256 of each program and of each file of the runs."""
    return {
        str(path.relative_to(settings.data)): sha256(path.read_bytes()).hexdigest()
        for folder in ("runs", "programs")
        for path in sorted((settings.data / folder).rglob("*"))
        if path.is_file()
    }


def _answers(settings: Settings, run_id: int) -> list[object]:
    """Return what everybody can read of a leaderboard and of a run."""
    app = create_app(settings)
    client = app.test_client()
    paths = ("leaderboards/currents-v1", f"runs/{run_id}", f"runs/{run_id}/telemetry.csv")
    answers = [client.get(f"/api/v1/{path}") for path in paths]
    app.extensions["seamark"].close()
    assert [answer.status_code for answer in answers] == [200, 200, 200]
    return [answer.get_json() if answer.is_json else answer.data for answer in answers]


def _restored(backend: Backend, settings: Settings) -> Backend:
    return Backend(Database(settings.database_url), settings, backend.viewers)


@pytest.mark.slow
def test_a_service_restored_elsewhere_has_the_same_leaderboard_data_and_queue(
    both: Backend, elsewhere: Settings, tmp_path: Path
) -> None:
    best = both.publish(_succeeded(both, "eva", kind="ranked"))
    _succeeded(both, "ann", controller="upload", program=both.store_program())
    running = both.running("ann").run_id
    RunFiles(both.settings.data, running, 1).append_rows(np.zeros((5, WIDTH)))
    queued = both.queue_program("ben", seed=5)
    target = tmp_path / "backup.tar"
    before = _answers(both.settings, best)
    expected = {name: sum_ for name, sum_ in _file_sums(both.settings).items()}
    expected = {name: sum_ for name, sum_ in expected.items() if f"/{running}/" not in name}

    made = creation.make(both.database, both.settings, target, nothing)
    summary = restoring.restore(elsewhere, target, force=False, on_bytes=nothing)

    schema.check_all(elsewhere)
    restored = _restored(both, elsewhere)
    settings = elsewhere.model_copy(update={"broker_url": both.settings.broker_url})
    assert _answers(settings, best) == before
    assert _file_sums(elsewhere) == expected
    assert summary == made.summary
    assert (elsewhere.data / "seed_key").read_text() == both.settings.seed_key
    with restored.database.writing() as session:
        lost_attempts.recover(session, lost_attempts.leases(session), elsewhere)
    claimed = {restored.claim_next().run_id, restored.claim_next().run_id}
    assert claimed == {running, queued}
    assert restored.show(running).attempt == 2
    assert restored.queue("ann") == queued + 1
    restored.database.close()


def test_a_backup_of_an_earlier_schema_is_upgraded_when_it_is_restored(
    both: Backend, empty_place: Settings, tmp_path: Path
) -> None:
    run_id = both.publish(_succeeded(both, "eva", kind="ranked"))
    with both.database.engine.begin() as connection:
        command.downgrade(schema.config(connection), "0031")

    creation.make(both.database, both.settings, tmp_path / "old.tar", nothing)
    restoring.restore(empty_place, tmp_path / "old.tar", force=False, on_bytes=nothing)

    schema.check_all(empty_place)
    restored = _restored(both, empty_place)
    assert restored.show(run_id).score == 50.0
    restored.database.close()


def test_data_that_are_deleted_during_the_backup_are_deleted_when_it_is_restored(
    backend: Backend, empty_place: Settings, tmp_path: Path
) -> None:
    kept, gone = _succeeded(backend), _succeeded(backend)
    copied = 0

    def delete_soon(more: int) -> None:
        nonlocal copied
        copied += more
        if copied > 50_000 and not deleted:  # in the middle of the data of the first run
            deleted.extend(retention.delete(backend.database, backend.settings, [gone]))

    deleted: list[int] = []
    creation.make(backend.database, backend.settings, tmp_path / "b.tar", delete_soon)
    restoring.restore(empty_place, tmp_path / "b.tar", force=False, on_bytes=nothing)

    restored = _restored(backend, empty_place)
    assert deleted == [gone]
    assert restored.show(gone).data_deleted_at is not None
    assert restored.show(kept).data_deleted_at is None
    assert RunFiles(empty_place.data, gone).attempts() == []
    assert RunFiles(empty_place.data, kept).row_count() == 50
    restored.database.close()


def test_files_that_somebody_else_removes_meanwhile_end_the_backup(
    backend: Backend, tmp_path: Path
) -> None:
    run_id = _succeeded(backend)
    files = RunFiles(backend.settings.data, run_id)
    before = (files.folder / "columns.json").stat().st_size

    def remove(more: int) -> None:
        if more == before:
            files.telemetry_path.unlink()

    with pytest.raises(BackupFailed, match=f"Files of run {run_id} vanished"):
        creation.make(backend.database, backend.settings, tmp_path / "b.tar", remove)
    assert list(tmp_path.glob("*b.tar*")) == []


def test_an_interrupted_backup_leaves_no_file(backend: Backend, tmp_path: Path) -> None:
    _succeeded(backend)
    folder = tmp_path / "backups"
    folder.mkdir()

    def interrupt(_more: int) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        creation.make(backend.database, backend.settings, folder / "b.tar", interrupt)
    assert list(folder.iterdir()) == []


def test_a_backup_replaces_no_file_and_is_for_its_owner_alone(
    backend: Backend, tmp_path: Path
) -> None:
    target = tmp_path / "b.tar"
    creation.make(backend.database, backend.settings, target, nothing)
    before = target.read_bytes()

    with pytest.raises(BackupFailed, match="exists"):
        creation.make(backend.database, backend.settings, target, nothing)

    assert target.read_bytes() == before
    assert target.stat().st_mode & 0o777 == 0o600


@pytest.mark.parametrize("keep", [0.0, 0.3, 0.9, 0.97])
def test_a_backup_without_its_end_is_refused_and_nothing_is_changed(
    backend: Backend, empty_place: Settings, tmp_path: Path, keep: float
) -> None:
    _succeeded(backend)
    target = tmp_path / "b.tar"
    creation.make(backend.database, backend.settings, target, nothing)
    size = target.stat().st_size
    end = target.read_bytes().rindex(b"sha256sums.txt")  # zeros after it fill the last block
    with target.open("r+b") as file:
        file.truncate(int(end * keep))

    with pytest.raises(ArchiveRejected, match=r"not (a )?complete"):
        restoring.restore(empty_place, target, force=False, on_bytes=nothing)
    assert size > end
    assert not storage.mark(empty_place.data).exists()
    assert not (empty_place.data / "runs").exists()


def test_a_changed_byte_is_found(backend: Backend, empty_place: Settings, tmp_path: Path) -> None:
    run_id = _succeeded(backend)
    target = tmp_path / "b.tar"
    creation.make(backend.database, backend.settings, target, nothing)
    content = bytearray(target.read_bytes())
    content[content.index(np.full(WIDTH, float(run_id)).tobytes()) + 100] ^= 1
    target.write_bytes(content)

    with pytest.raises(ArchiveRejected, match=r"the SHA-256 of runs/.*telemetry\.f64 differs"):
        restoring.restore(empty_place, target, force=False, on_bytes=nothing)
    with pytest.raises(ArchiveRejected):
        restoring.check(target, nothing)
    assert not (empty_place.data / "runs").exists()


@pytest.mark.slow
def test_what_a_restore_leaves_that_broke_off_is_no_service_until_it_is_repeated(
    backend: Backend, elsewhere: Settings, tmp_path: Path
) -> None:
    run_id = backend.publish(_succeeded(backend, "eva", kind="ranked"))
    target = tmp_path / "b.tar"
    made = creation.make(backend.database, backend.settings, target, nothing)
    done = 0

    def break_off(more: int) -> None:
        nonlocal done
        done += more
        if done > 1.8 * made.summary.bytes:  # it is read twice
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        restoring.restore(elsewhere, target, force=False, on_bytes=break_off)

    with pytest.raises(WrongDataFolder, match="has not finished"):
        schema.upgrade(elsewhere)
    with pytest.raises(RestoreRefused, match="--force"):
        restoring.restore(elsewhere, target, force=False, on_bytes=nothing)
    restoring.restore(elsewhere, target, force=True, on_bytes=nothing)
    schema.check_all(elsewhere)
    restored = _restored(backend, elsewhere)
    assert restored.show(run_id).score == 50.0
    restored.database.close()


@pytest.mark.slow
def test_a_service_is_replaced_only_by_force_and_only_when_it_has_stopped(
    both: Backend, tmp_path: Path
) -> None:
    kept = _succeeded(both)
    target = tmp_path / "b.tar"
    creation.make(both.database, both.settings, target, nothing)
    later = _succeeded(both)
    with both.database.writing() as session:
        row = Worker(name="w1", slots=1, level="strong", languages=[], findings=[])
        workers.register(session, row)

    with pytest.raises(RestoreRefused, match="Worker w1 is running"):
        restoring.restore(both.settings, target, force=True, on_bytes=nothing)
    with both.database.writing() as session:
        workers.unregister(session, "w1")
    with pytest.raises(RestoreRefused, match="There is a service"):
        restoring.restore(both.settings, target, force=False, on_bytes=nothing)
    assert both.show(later).state is RunState.SUCCEEDED
    restoring.restore(both.settings, target, force=True, on_bytes=nothing)

    assert both.show(kept).state is RunState.SUCCEEDED
    assert both.queue("ann") == later
    assert RunFiles(both.settings.data, later).attempts() == []


def test_a_backup_that_is_too_early_to_be_upgraded_is_refused(
    backend: Backend, empty_place: Settings, tmp_path: Path
) -> None:
    with backend.database.writing() as session:
        session.execute(text("UPDATE alembic_version SET version_num = '0030'"))
    creation.make(backend.database, backend.settings, tmp_path / "b.tar", nothing)

    with pytest.raises(RestoreRefused, match="Restore it with the commit 093b11f4"):
        restoring.restore(empty_place, tmp_path / "b.tar", force=False, on_bytes=nothing)


def test_a_backup_of_a_later_version_is_refused(
    backend: Backend, empty_place: Settings, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(layout, "FORMAT", layout.FORMAT + 1)
    creation.make(backend.database, backend.settings, tmp_path / "b.tar", nothing)
    monkeypatch.undo()

    with pytest.raises(RestoreRefused, match="later than this version knows"):
        restoring.restore(empty_place, tmp_path / "b.tar", force=False, on_bytes=nothing)


def test_a_key_of_the_environment_must_be_that_of_the_backup(
    backend: Backend, tmp_path: Path
) -> None:
    creation.make(backend.database, backend.settings, tmp_path / "b.tar", nothing)
    other = Settings.model_validate({"data": tmp_path / "other", "seed_key": "of the environment"})

    with pytest.raises(RestoreRefused, match="SEAMARK_SEED_KEY"):
        restoring.restore(other, tmp_path / "b.tar", force=False, on_bytes=nothing)


def test_a_backup_for_which_there_is_no_room_is_refused(backend: Backend, tmp_path: Path) -> None:
    with pytest.raises(BackupFailed, match="SEAMARK_FREE_MIN_BYTES"):
        creation.refuse_without_room(backend.settings, tmp_path / "b.tar", 10**18)


def test_with_object_storage_the_backup_has_the_database_and_the_storage_keeps_its_data(
    backend: Backend, empty_place: Settings, tmp_path: Path
) -> None:
    url = {"storage_url": f"file://{tmp_path / 'objects'}"}
    (tmp_path / "objects").mkdir()
    stored = objects.of(backend.settings.model_copy(update=url))
    assert stored is not None
    stored.put(objects.MARK, storage.mark(backend.settings.data).read_bytes())
    backend.settings = backend.settings.model_copy(update=url)
    program = backend.store_program()
    run_id = backend.succeeded("ann", controller="upload", program=program)
    target = tmp_path / "b.tar"

    made = creation.make(backend.database, backend.settings, target, nothing)
    with pytest.raises(RestoreRefused, match="Set SEAMARK_STORAGE_URL"):
        restoring.restore(empty_place, target, force=False, on_bytes=nothing)
    there = empty_place.model_copy(update=url)
    restoring.restore(there, target, force=False, on_bytes=nothing)

    schema.check_all(there)
    restored = _restored(backend, there)
    assert made.summary.programs == made.summary.runs_with_data == 0
    assert restored.show(run_id).state is RunState.SUCCEEDED
    assert store.size(there, program.sha256) == program.size
    restored.database.close()
