import os
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from seamark.programs.preparation import PreparedProgram
from seamark.server.programs import store
from seamark.server.settings import Settings
from seamark.server.storage import storage
from seamark.server.storage.storage import StorageUnavailable
from tests.services.full_disk import files_end_at

GOOD = b"class Controller(Base):\n    pass\n"


@pytest.fixture
def settings(tmp_path: Path) -> Settings:
    storage.mark(tmp_path).touch()
    return Settings.model_validate({"data": tmp_path})


def _store(source: bytes, settings: Settings, name: str = "mine.py") -> store.StoredProgram:
    return store.save(PreparedProgram(name, "python", source), settings)


def test_a_program_is_stored_once_under_its_hash(settings: Settings) -> None:
    first, second = _store(GOOD, settings), _store(GOOD, settings, "other.py")

    assert first.sha256 == second.sha256
    assert store.read(settings, first.sha256) == GOOD
    assert len(list((settings.data / "programs").iterdir())) == 1


@pytest.mark.parametrize("key", ["", "../secret", "A" * 64, "0" * 63])
def test_a_program_is_found_only_by_a_valid_hash(settings: Settings, key: str) -> None:
    with pytest.raises(ValueError, match="SHA-256"):
        store.path(settings, key)


def test_only_old_unreferenced_programs_are_deleted(settings: Settings) -> None:
    kept = [_store(GOOD + b"# %d" % number, settings).sha256 for number in range(3)]
    for sha256 in kept[:2]:
        os.utime(store.path(settings, sha256), (0, 0))

    gone = store.delete_unused(settings, older_than_s=60, used=lambda key: key == kept[0])

    assert gone == 1
    assert [store.touch(settings, sha256) is not None for sha256 in kept] == [True, False, True]


def test_uploading_a_program_again_renews_its_age(settings: Settings) -> None:
    sha256 = _store(GOOD, settings).sha256
    os.utime(store.path(settings, sha256), (0, 0))

    _store(GOOD, settings)

    assert store.delete_unused(settings, older_than_s=60, used=lambda _: False) == 0


def test_two_workers_delete_every_unused_program_once(settings: Settings) -> None:
    for number in range(3):
        sha256 = _store(GOOD + b"# %d" % number, settings).sha256
        os.utime(store.path(settings, sha256), (0, 0))
    deleted_by_other = []

    def used(_: str) -> bool:  # called between listing the folder and taking the lock
        other = store.delete_unused(settings, older_than_s=60, used=lambda _: False)
        deleted_by_other.append(other)
        return False

    deleted = store.delete_unused(settings, older_than_s=60, used=used)

    assert (deleted_by_other, deleted) == ([3], 0)


@pytest.mark.slow
def test_uploads_survive_two_workers_that_delete_at_the_same_time(settings: Settings) -> None:
    ended = threading.Event()

    def delete() -> None:
        while not ended.is_set():
            store.delete_unused(settings, older_than_s=60, used=lambda _: False)

    with ThreadPoolExecutor(2) as workers:
        deleting = [workers.submit(delete) for _ in range(2)]
        for number in range(300):  # every file is first a draft, which is then renamed
            sha256 = _store(GOOD + b"# %d" % number, settings).sha256
            assert store.read(settings, sha256)
            os.utime(store.path(settings, sha256), (0, 0))
        ended.set()

    assert [one.result() for one in deleting] == [None, None]


def test_a_program_that_does_not_fit_leaves_nothing_half(settings: Settings) -> None:
    with files_end_at(100), pytest.raises(StorageUnavailable, match="could not be stored"):
        _store(GOOD + b"#" * 1000, settings)

    assert list((settings.data / "programs").iterdir()) == []
