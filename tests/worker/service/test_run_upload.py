"""What a worker takes to the object storage is what the web processes read."""

import os
import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from seamark.server.database import schema
from seamark.server.database.data_folder import WrongDataFolder
from seamark.server.runs.data import stored_files
from seamark.server.runs.data.files import StorageFailed
from seamark.server.settings import Settings
from seamark.server.storage import objects, storage
from seamark.server.storage.objects import Objects
from seamark.worker.service import run_upload
from seamark.worker.service.run_upload import RunUpload
from tests.services import s3
from tests.services.machines import Machines, numbered_rows


@pytest.fixture(params=["file", "s3"])
def shared(
    request: pytest.FixtureRequest,
    tmp_path: Path,
    redis_url: str,
    s3_server: s3.Server,
    monkeypatch: Any,
) -> dict[str, str]:
    """Settings of storage and a broker that two machines share."""
    monkeypatch.setattr(run_upload, "PART_EVERY_S", 0.01)
    monkeypatch.setattr(stored_files, "LIST_EVERY_S", 0.0)
    if request.param == "s3":
        return s3_server.settings(tmp_path.name) | {"broker_url": redis_url}
    return {"storage_url": f"file://{tmp_path / 'shared'}", "broker_url": redis_url}


@pytest.fixture
def machines(tmp_path: Path, shared: dict[str, str]) -> Machines:
    return Machines(tmp_path, shared)


def _end(upload: RunUpload) -> None:
    upload.complete(lambda: None, within_s=10.0)


@pytest.mark.slow
def test_a_run_is_read_while_it_goes_on_and_as_it_was_written_when_it_has_ended(
    machines: Machines,
) -> None:
    files, upload = machines.recording()
    files.append_rows(numbered_rows(0, 20))
    files.append_log(b"first\n")
    machines.wait_for(20, log="first\n")

    files.append_rows(numbered_rows(20, 30))
    going_on = machines.wait_for(50, log="first\n")
    files.write_json("manifest.json", {"digest": "d"})
    _end(upload)
    upload.remove_parts()
    files.remove()

    ended = machines.read(attempt=1)
    assert going_on.rows().tolist() == ended.rows().tolist() == numbered_rows(0, 50).tolist()
    assert (ended.manifest(), ended.log_text()) == ({"digest": "d"}, "first\n")
    assert machines.parts() == 0


def test_a_run_that_has_recorded_nothing_is_complete(machines: Machines) -> None:
    files, upload = machines.recording()
    files.remove()

    _end(upload)

    assert not files.folder.exists()
    assert machines.read(attempt=1).row_count() == 0


def test_a_disk_that_cannot_be_read_ends_the_upload_as_a_failure_of_the_storage(
    machines: Machines, monkeypatch: Any
) -> None:
    files, upload = machines.recording()
    files.append_rows(numbered_rows(0, 3))

    def broken(path: Path) -> Any:
        raise OSError("Input/output error")

    monkeypatch.setattr(Path, "iterdir", broken)

    with pytest.raises(StorageFailed, match="Input/output error"):
        _end(upload)


def test_rows_that_a_trial_takes_back_are_replaced_for_readers_too(machines: Machines) -> None:
    files, upload = machines.recording()
    files.append_rows(numbered_rows(0, 30))
    machines.wait_for(30)

    upload.truncate_rows(10)
    files.append_rows(numbered_rows(10, 15, value=1.0))

    found = machines.wait_for(25).rows()
    wanted = np.concatenate([numbered_rows(0, 10), numbered_rows(10, 15, value=1.0)])
    upload.stop()
    assert found.tolist() == wanted.tolist()


def test_the_objects_of_a_dead_attempt_are_neither_read_nor_kept(machines: Machines) -> None:
    dead, dying = machines.recording(attempt=1)
    dead.append_rows(numbered_rows(0, 40))
    machines.wait_for(40)

    files, upload = machines.recording(attempt=2)
    files.append_rows(numbered_rows(0, 5, value=2.0))
    found = machines.wait_for(5)
    _end(dying)  # it does not know yet that it has lost the run
    _end(upload)

    assert found.attempt == 2
    assert machines.read(attempt=2).rows().tolist() == numbered_rows(0, 5, value=2.0).tolist()


def test_a_file_is_fetched_once_however_many_ask(machines: Machines, monkeypatch: Any) -> None:
    files, upload = machines.recording()
    files.append_rows(numbered_rows(0, 10))
    _end(upload)
    fetched = list[str]()
    fetch = Objects.fetch

    def counting(self: Objects, path: str, target: Path) -> bool:
        fetched.append(path)
        return fetch(self, path, target)

    monkeypatch.setattr(Objects, "fetch", counting)
    asking = [threading.Thread(target=machines.read, args=(7, 1)) for _ in range(8)]
    for one in asking:
        one.start()
    for one in asking:
        one.join()

    assert sorted(path.rpartition("/")[2] for path in fetched) == ["columns.json", "telemetry.f64"]


def test_copies_that_nobody_reads_make_room(machines: Machines, monkeypatch: Any) -> None:
    monkeypatch.setattr(stored_files, "KEPT_S", 0.0)
    monkeypatch.setattr(stored_files, "TRIM_EVERY_S", 0.0)
    machines.web = machines.web.model_copy(update={"cache_bytes": 25_000})
    for run_id in (1, 2, 3):
        files, upload = machines.recording(run_id)
        files.append_rows(numbered_rows(0, 30))
        _end(upload)

    size = [machines.read(run_id, 1).size() for run_id in (1, 2, 3)]

    copies = storage.copies(machines.web) / "runs" / "0"
    left = sorted(folder.name for folder in copies.iterdir())
    assert size[0] > 12_500
    assert left == ["3"]
    assert machines.read(1, 1).row_count() == 30


def test_a_copy_that_nobody_has_read_for_a_day_goes_even_if_there_is_room(
    machines: Machines, monkeypatch: Any
) -> None:
    monkeypatch.setattr(stored_files, "TRIM_EVERY_S", 0.0)
    for run_id in (1, 2):
        files, upload = machines.recording(run_id)
        files.append_rows(numbered_rows(0, 30))
        _end(upload)
    for file in machines.read(1, 1).root.rglob("*"):
        os.utime(file, (0, 0))

    machines.read(2, 1)

    copies = storage.copies(machines.web) / "runs" / "0"
    assert [folder.name for folder in copies.iterdir()] == ["2"]


def test_while_the_storage_is_away_readers_see_what_was_copied(
    machines: Machines, monkeypatch: Any
) -> None:
    files, upload = machines.recording()
    files.append_rows(numbered_rows(0, 10))
    _end(upload)
    machines.wait_for(10)

    def away(*_: object) -> None:
        raise objects.ObjectsAway("nobody is there")

    monkeypatch.setattr(Objects, "list", away)

    assert machines.read().row_count() == 10
    assert machines.read(8).row_count() == 0


def test_a_run_that_ends_while_the_storage_is_away_waits_for_it(
    machines: Machines, monkeypatch: Any
) -> None:
    monkeypatch.setattr(run_upload, "RETRY_S", 0.01)
    files, upload = machines.recording()
    upload.stop()
    files.append_rows(numbered_rows(0, 10))
    put, failures = Objects.put, iter([True] * 3)

    def sometimes(self: Objects, path: str, content: Any) -> None:
        if next(failures, False):
            raise objects.ObjectsAway("nobody is there")
        put(self, path, content)

    monkeypatch.setattr(Objects, "put", sometimes)
    _end(upload)

    assert machines.read(attempt=1).row_count() == 10


def test_a_database_refuses_the_storage_of_another_service(
    tmp_path: Path, shared: dict[str, str]
) -> None:
    url = f"sqlite:///{tmp_path / 'one.db'}"
    ours = Settings.model_validate(shared | {"data": tmp_path / "a", "database_url": url})
    schema.upgrade(ours)
    other = {**shared, "storage_url": shared["storage_url"] + "-other"}
    theirs = Settings.model_validate(other | {"data": tmp_path / "b", "database_url": url})
    local = Settings.model_validate({"data": tmp_path / "c", "database_url": url})

    schema.check_all(ours.model_copy(update={"data": tmp_path / "b"}))
    with pytest.raises(WrongDataFolder, match="is not the storage of this database"):
        schema.check_all(theirs)
    with pytest.raises(WrongDataFolder, match="need SEAMARK_STORAGE_URL"):
        schema.check_all(local)
