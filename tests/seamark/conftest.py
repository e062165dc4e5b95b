"""A service with the cast, at an address."""

from collections.abc import Iterator
from threading import Thread

import pytest
from werkzeug.serving import make_server

from seamark.server.accounts import accounts
from seamark.server.app import create_app
from tests.cast import Backend


@pytest.fixture
def address(backend: Backend) -> Iterator[str]:
    """The address of a service with the cast."""
    app = create_app(backend.settings)
    server = make_server("127.0.0.1", 0, app)
    thread = Thread(target=server.serve_forever)
    thread.start()
    yield f"http://127.0.0.1:{server.server_port}"
    server.shutdown()
    thread.join()
    server.server_close()
    app.extensions["seamark"].close()


@pytest.fixture
def token(backend: Backend) -> str:
    """A token of ann, to read and submit."""
    with backend.database.writing() as session:
        user_id = backend.user_id("ann")
        return accounts.new_token(session, user_id, "t", ["read", "submit"], days=1.0)
