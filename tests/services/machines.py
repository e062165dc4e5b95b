"""A web machine and a worker's machine that share object storage and a broker, but no folder."""

import time
from pathlib import Path
from typing import Any

import numpy as np

from seamark.server.messaging import broker
from seamark.server.runs.data import run_objects, stored_files
from seamark.server.runs.data.files import RunFiles
from seamark.server.settings import Settings
from seamark.server.storage import objects, storage
from seamark.sim.recording.telemetry import INDEX, WIDTH
from seamark.worker.service.run_upload import RunUpload

LOOKS = 3000  # at most, 0.01 s apart


class Machines:
    """Both machines.

    Parameters
    ----------
    folder
        Where each has its data folder.
    shared
        Settings that they share.
    """

    def __init__(self, folder: Path, shared: dict[str, Any]) -> None:
        self.web, self.worker = (
            Settings.model_validate(shared | {"data": folder / name}) for name in ("web", "worker")
        )
        stored = objects.of(self.web)
        assert stored is not None
        self.stored: objects.Objects = stored
        self.stored.put(objects.MARK, b"mine")
        self._redis = broker.connect(self.worker)

    def recording(self, run_id: int = 7, attempt: int = 1) -> tuple[RunFiles, RunUpload]:
        """Return the files of a run on the worker's machine, and their upload, which goes on."""
        files = RunFiles(storage.workspace(self.worker), run_id, attempt)
        upload = RunUpload(self.stored, self._redis, files, run_id)
        upload.start()
        return files, upload

    def parts(self, run_id: int = 7) -> int:
        """Return how many bytes of telemetry are stored in parts."""
        attempts = run_objects.attempts(self.stored, run_id).values()
        return sum(part.size for one in attempts for part in one.parts.get("telemetry.f64", ()))

    def read(self, run_id: int = 7, attempt: int | None = None) -> RunFiles:
        """Return the files as the web machine reads them."""
        return stored_files.latest(self.web, run_id, attempt)

    def wait_for(self, rows: int, log: str = "") -> RunFiles:
        """Return the files once the web machine has exactly so many rows, and this log."""
        for _ in range(LOOKS):
            files = self.read()
            if (files.row_count(), files.log_text()) == (rows, log):
                return files
            time.sleep(0.01)  # parts are not announced
        raise AssertionError(f"{files.row_count()} rows instead of {rows}")


def numbered_rows(start: int, count: int, value: float = 0.0) -> Any:
    """Return rows 0.05 s apart."""
    rows = np.full((count, WIDTH), value)
    rows[:, INDEX["t"]] = 0.05 * np.arange(start, start + count)
    return rows
