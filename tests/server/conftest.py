"""The cast on each of the two databases."""

from collections.abc import Iterator

import pytest

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
