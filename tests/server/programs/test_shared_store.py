"""Programs on machines that share object storage."""

import os
from pathlib import Path

import pytest

from seamark.programs.preparation import PreparedProgram
from seamark.server.programs import store
from seamark.server.settings import Settings
from seamark.server.storage import objects, storage
from seamark.server.storage.storage import StorageUnavailable

SOURCE = b"class Controller(Base):\n    pass\n"


@pytest.fixture
def machines(tmp_path: Path) -> tuple[Settings, Settings]:
    """A web machine and a worker's machine."""
    shared = {"storage_url": f"file://{tmp_path / 'shared'}"}
    web, worker = (
        Settings.model_validate(shared | {"data": tmp_path / name}) for name in ("web", "worker")
    )
    stored = objects.of(web)
    assert stored is not None
    stored.put(objects.MARK, b"mine")
    return web, worker


def _save(settings: Settings, source: bytes = SOURCE) -> str:
    return store.save(PreparedProgram("mine.py", "python", source), settings).sha256


def _object(settings: Settings, sha256: str) -> Path:
    return settings.data.parent / "shared" / "programs" / sha256


def test_a_worker_has_the_program_that_another_machine_was_sent(
    machines: tuple[Settings, Settings],
) -> None:
    web, worker = machines

    sha256 = _save(web)

    assert store.path(worker, sha256).read_bytes() == SOURCE
    assert store.path(worker, sha256).is_relative_to(worker.data)


def test_a_worker_runs_no_program_that_was_changed_in_the_storage(
    machines: tuple[Settings, Settings],
) -> None:
    web, worker = machines
    sha256 = _save(web)
    _object(web, sha256).write_bytes(b"something else")

    with pytest.raises(StorageUnavailable, match="damaged"):
        store.path(worker, sha256)


def test_an_unused_program_is_deleted_everywhere_and_a_renewed_one_nowhere(
    machines: tuple[Settings, Settings],
) -> None:
    web, worker = machines
    gone, renewed = _save(web), _save(web, SOURCE + b"# 2")
    for sha256 in (gone, renewed):
        store.path(worker, sha256)
        for file in (_object(web, sha256), store.path(web, sha256), store.path(worker, sha256)):
            os.utime(file, (0, 0))

    assert store.touch(web, renewed)
    store.delete_unused(web, used=lambda _: False)
    store.delete_unused(worker, used=lambda _: False)

    assert [store.touch(web, sha256) is not None for sha256 in (gone, renewed)] == [False, True]
    assert store.size(worker, gone) == 0
    assert store.read(worker, renewed) == SOURCE + b"# 2"


def test_nothing_is_accepted_while_the_storage_is_not_that_of_a_service(tmp_path: Path) -> None:
    url = f"file://{tmp_path / 'empty'}"
    settings = Settings.model_validate({"data": tmp_path / "web", "storage_url": url})

    with pytest.raises(StorageUnavailable, match="cannot access"):
        _save(settings)
    assert storage.is_away(settings)
