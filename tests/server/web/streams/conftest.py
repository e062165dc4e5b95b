"""Runs that are being recorded, and viewers who follow them."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pytest

from seamark.server.runs.data.files import RunFiles
from seamark.server.web.streams.hub import Hub
from seamark.sim.recording.telemetry import INDEX, WIDTH
from tests.cast import Backend


@dataclass
class Recording(Backend):
    """A run that a worker has, and what it writes."""

    run_id: int = 0
    attempt: int = 1

    @property
    def files(self) -> RunFiles:
        return RunFiles(self.settings.data, self.run_id, self.attempt)

    def record(self, rows: int, *, trial: int = 0) -> None:
        """Append rows 0.05 s apart."""
        first = self.files.row_count()
        numbers = np.arange(first, first + rows)
        table = np.round(np.sin(numbers[:, None] + np.arange(WIDTH)), 2)
        table[:, INDEX["t"]] = 0.05 * numbers
        table[:, INDEX["trial"]] = trial
        self.files.append_rows(table)


@pytest.fixture
def recording(backend: Backend) -> Recording:
    """A running run without any rows so far."""
    claim = backend.running("ann")
    return Recording(**vars(backend), run_id=claim.run_id, attempt=claim.attempt)


@pytest.fixture
def hub(recording: Recording) -> Iterator[Hub]:
    """The streams of a web process."""
    made = Hub(recording.database, recording.settings)
    yield made
    made.close()
