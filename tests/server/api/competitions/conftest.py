"""The application on both databases, with a token of each person of the cast."""

from collections.abc import Iterator

import pytest

from seamark.server.accounts import accounts
from seamark.server.accounts.permissions import SCOPES, Role
from seamark.server.app import create_app
from tests.cast import CAST, Backend
from tests.server.api.conftest import Site


@pytest.fixture
def hall(both: Backend) -> Iterator[Site]:
    """A service without a worker, where otto organises other competitions than olga."""
    both.sign_up("otto", role=Role.ORGANISER)
    headers: dict[str, dict[str, str]] = {"nobody": {}}
    with both.database.writing() as session:
        for name in (*CAST, "otto"):
            token = accounts.new_token(session, both.user_id(name), "all", SCOPES)
            headers[name] = {"Authorization": f"Bearer {token}"}
    site = Site(**vars(both), app=create_app(both.settings), headers=headers)
    yield site
    site.services.close()
