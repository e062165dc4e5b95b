"""A service with the cast, at an address."""

from collections.abc import Iterator
from threading import Event, Thread

import numpy as np
import pytest

from seamark.server.accounts import accounts
from seamark.server.runs.data.files import RunFiles
from seamark.sim.recording.telemetry import INDEX, WIDTH
from tests.cast import Backend
from tests.services.pages import served


@pytest.fixture
def address(backend: Backend) -> Iterator[str]:
    """The address of a service with the cast."""
    with served(backend) as found:
        yield found


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
