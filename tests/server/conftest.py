"""The cast on each of the two databases."""

import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

from seamark.server.accounts.permissions import Viewer
from seamark.server.database.engine import Database
from seamark.server.database.schema import upgrade
from seamark.server.settings import Settings
from tests.cast import Backend


@pytest.fixture(params=["database_url", "postgres_url"], ids=["sqlite", "postgresql"])
def both(request: pytest.FixtureRequest, settings: Settings) -> Iterator[Backend]:
    """The cast on a database of each type in turn."""
    url = request.getfixturevalue(request.param)
    settings = settings.model_copy(update={"database_url": url})
    upgrade(settings)
    database = Database(settings.database_url)
    yield Backend.with_cast(database, settings)
    database.close()


@pytest.fixture(scope="session")
def cast_in_folder(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Viewer]]:
    """A data folder with the cast, to be copied: faster than to migrate a new database."""
    settings = Settings.model_validate({"data": tmp_path_factory.mktemp("cast")})
    upgrade(settings)
    database = Database(settings.database_url)
    viewers = Backend.with_cast(database, settings).viewers
    database.close()
    return settings.data, viewers


@pytest.fixture
def copied_backend(
    cast_in_folder: tuple[Path, dict[str, Viewer]], settings: Settings
) -> Iterator[Backend]:
    """The cast on SQLite as `backend`, ready sooner."""
    folder, viewers = cast_in_folder
    shutil.copytree(folder, settings.data, dirs_exist_ok=True)
    changed = {"database_url": f"sqlite:///{settings.data / 'seamark.db'}"}
    settings = settings.model_copy(update=changed)
    database = Database(settings.database_url)
    yield Backend(database, settings, dict(viewers))
    database.close()
