"""A database knows its data folder."""

import os

import pytest

from seamark.server.database.data_folder import WrongDataFolder
from seamark.server.database.schema import check_all, upgrade
from seamark.server.settings import Settings
from seamark.server.storage import storage
from tests.cast import Backend


def test_a_service_starts_again_with_its_data_folder(both: Backend) -> None:
    upgrade(both.settings)

    check_all(both.settings)


def test_a_service_does_not_start_with_the_empty_folder_of_another_disk(both: Backend) -> None:
    data = both.settings.data
    os.rename(data, data.with_name("disk"))
    empty = Settings.model_validate(both.settings.model_dump())  # as at the next start

    for start in (check_all, upgrade):
        with pytest.raises(WrongDataFolder, match="Is its disk mounted"):
            start(empty)
    assert not storage.mark(data).exists()


def test_the_sentence_says_how_to_use_another_folder(both: Backend) -> None:
    data = both.settings.data
    mark = storage.mark(data).read_text()
    storage.mark(data).unlink()

    with pytest.raises(WrongDataFolder, match=mark):
        check_all(both.settings)
    storage.mark(data).write_text(mark)

    check_all(both.settings)
