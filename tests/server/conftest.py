"""The cast on each of the two databases."""

from collections.abc import Iterator

import pytest

from seamark.server.settings import Settings
from tests.cast import Backend
from tests.services import tables


@pytest.fixture(params=["sqlite", pytest.param("postgresql", marks=pytest.mark.host)])
def both(request: pytest.FixtureRequest, settings: Settings) -> Iterator[Backend]:
    """The cast on a database of each type in turn.

    For what the two do differently (locks, claims, times, texts), and for one test of each
    statement of the service: another test of the same statements takes `backend`, on SQLite alone.
    """
    if request.param == "postgresql":
        url = request.getfixturevalue("postgres_tables_url")
        settings = settings.model_copy(update={"database_url": url})
        database = tables.adopt(settings)
    else:
        database = tables.create(settings)
    yield Backend.with_cast(database, settings)
    database.close()
