"""The code in docs/python-client.md runs as a reader would run it, against a service."""

import re
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from seamark.server.runs.files import RunFiles
from seamark.sim.recording.telemetry import INDEX, WIDTH
from tests.cast import PROGRAM, Backend

GUIDE = Path(__file__).parents[3] / "docs" / "python-client.md"
BLOCK = re.compile(r"^```python\n(.*?)^```$", re.MULTILINE | re.DOTALL)


@contextmanager
def worker(backend: Backend) -> Iterator[None]:
    """Finish each queued run within a moment, with ten rows of telemetry."""
    stopping = threading.Event()
    rows = np.zeros((10, WIDTH))
    rows[:, INDEX["distance"]] = 2.0

    def work() -> None:
        while not stopping.wait(0.05):
            if (claim := backend.claim()) is not None:
                RunFiles(backend.settings.data, claim.run_id, 1).append_rows(rows)
                backend.finish(claim)

    thread = threading.Thread(target=work)
    thread.start()
    yield
    stopping.set()
    thread.join()


def test_the_code_of_the_guide_runs(
    backend: Backend,
    address: str,
    token: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    (tmp_path / "controller.py").write_bytes(PROGRAM)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("SEAMARK_SERVER", address)
    monkeypatch.setenv("SEAMARK_TOKEN", token)

    names: dict[str, Any] = {}
    with worker(backend):
        for block in BLOCK.findall(GUIDE.read_text(encoding="utf-8")):
            exec(block, names)  # noqa: S102  # our own documentation

    printed = capsys.readouterr().out
    assert names["run"].public
    assert (tmp_path / "run.png").stat().st_size > 10_000
    assert "10 control steps, RMS distance 2.00 m" in printed
    assert "Best: <run" in printed
    assert "kp" in printed.splitlines()[-1]
    names["client"].close()
