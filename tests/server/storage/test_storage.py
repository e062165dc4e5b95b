"""The free space of the data folder, and whether it is there."""

import os
from pathlib import Path

import pytest

from seamark.server.settings import Settings
from seamark.server.storage import storage
from seamark.server.storage.storage import StorageUnavailable
from tests.cast import PROGRAM, Backend

MORE_THAN_ANY_DISK = 2**62


@pytest.fixture
def marked(settings: Settings) -> Settings:
    storage.mark(settings.data).touch()
    return settings


def test_with_enough_free_space_nothing_is_refused(marked: Settings) -> None:
    storage.require(marked)

    assert storage.free_bytes(marked.data) > marked.free_min_bytes


def test_with_too_little_free_space_new_data_are_refused_and_stored_ones_readable(
    marked: Settings,
) -> None:
    full = marked.model_copy(update={"free_min_bytes": MORE_THAN_ANY_DISK})

    with pytest.raises(StorageUnavailable, match="too little free disk space"):
        storage.require(full)

    storage.require_readable(full)


def test_running_runs_may_use_most_of_what_is_kept_free(marked: Settings) -> None:
    twice = marked.model_copy(update={"free_min_bytes": 2 * storage.free_bytes(marked.data)})

    assert storage.refusal(twice) is not None
    assert storage.refusal(twice, share=storage.STOP_SHARE) is None


def test_the_empty_folder_of_a_disk_that_is_not_mounted_is_not_the_data_folder(
    marked: Settings, tmp_path: Path
) -> None:
    os.rename(marked.data, tmp_path / "disk")
    marked.data.mkdir()

    with pytest.raises(StorageUnavailable, match="cannot access its data folder"):
        storage.require_readable(marked)


def test_without_the_folder_there_is_no_free_space(marked: Settings, tmp_path: Path) -> None:
    os.rename(marked.data, tmp_path / "away")

    assert storage.free_bytes(marked.data) == 0
    assert storage.refusal(marked) is not None


def test_no_run_and_no_program_is_accepted_without_space(both: Backend) -> None:
    program = both.store_program()
    settings = both.settings.model_copy(update={"free_min_bytes": MORE_THAN_ANY_DISK})
    full = Backend(both.database, settings, both.viewers)

    with pytest.raises(StorageUnavailable):
        full.queue("ann")
    with pytest.raises(StorageUnavailable):
        full.queue("ann", controller="upload", program=program)
    with pytest.raises(StorageUnavailable):
        full.store_program(PROGRAM + b"# another\n")

    assert len(list((settings.data / "programs").iterdir())) == 1
