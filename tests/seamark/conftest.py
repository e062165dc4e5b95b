"""A service with the cast, at an address."""

from collections.abc import Iterator
from threading import Event, Thread

import numpy as np
import pytest
from werkzeug.serving import make_server

from seamark.server.accounts import accounts
from seamark.server.app import create_app
from seamark.server.runs.files import RunFiles
from seamark.sim.recording.telemetry import INDEX, WIDTH
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


@pytest.fixture
def worker(backend: Backend) -> Iterator[None]:
    """Finish each queued run within a moment, with ten rows of telemetry."""
    stopping = Event()
    rows = np.zeros((10, WIDTH))
    rows[:, INDEX["distance"]] = 2.0

    def work() -> None:
        while not stopping.wait(0.05):
            if (claim := backend.claim()) is not None:
                RunFiles(backend.settings.data, claim.run_id, 1).append_rows(rows)
                backend.finish(claim)

    thread = Thread(target=work)
    thread.start()
    yield
    stopping.set()
    thread.join()
