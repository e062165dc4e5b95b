"""A short real run, and recordings of it."""

from collections.abc import Callable
from dataclasses import replace
from io import BytesIO
from typing import Any

import numpy as np
import pytest

from seamark.formats.recording import Program, Recording
from seamark.formats.registry import FORMATS
from seamark.sim import registry
from seamark.sim.engine.program import BuiltIn
from seamark.sim.engine.trial import run_trial
from seamark.sim.recording import telemetry
from seamark.sim.recording.manifest import manifest
from seamark.sim.recording.telemetry import INDEX, Rows

SEED = 7
SETTINGS: dict[str, Any] = {"levels": [0.0, 0.2], "level_duration_s": 5.0, "settle_s": 1.0}


class WriteOnly(BytesIO):
    """What a pipe is to a writer: it can only be appended to."""

    def seekable(self) -> bool:
        return False

    def seek(self, *_: Any) -> int:
        raise OSError("a pipe cannot be positioned")

    def read(self, *_: Any) -> bytes:
        raise OSError("a pipe cannot be read")


@pytest.fixture(scope="session")
def rows() -> Rows:
    """Two trials of the built-in PI controller, with numbers that are hard to write."""
    config = registry.benchmark("currents-v1").read(SETTINGS)
    parts: list[Rows] = []
    for trial in range(2):
        program = BuiltIn("pi", config)
        run_trial("currents-v1", config, program, seed=SEED, trial=trial, on_rows=parts.append)
    table = np.concatenate(parts)
    table[3, INDEX["target_x"]] = np.nan
    table[4, INDEX["contact_n"]] = -0.0
    table[5, INDEX["contact_n"]] = 5e-324
    table[6, INDEX["contact_n"]] = 1.7976931348623157e308
    return table


@pytest.fixture
def recording(rows: Rows) -> Recording:
    """The run, kept in memory."""
    config = registry.benchmark("currents-v1").read(SETTINGS)
    described = manifest(
        "currents-v1", config, seed=SEED, trials=2, controller="pi", digest=telemetry.digest(rows)
    )
    return Recording(
        title="Run 12",
        benchmark="currents-v1",
        config=described["configuration"],
        width=rows.shape[1],
        row_count=len(rows),
        read=lambda start, stop: rows[start:stop],
        seeds=[SEED, SEED],
        comments=["Seamark run 12"],
        manifest=described,
        metrics={"score": 61.5},
    )


@pytest.fixture
def with_program(recording: Recording) -> Recording:
    return replace(recording, program=Program("mine.py", b"class Controller: ...\n"))


@pytest.fixture
def written(recording: Recording) -> Callable[[str], BytesIO]:
    """Write the run in a format."""

    def write(name: str) -> BytesIO:
        file = WriteOnly()
        FORMATS[name].write(recording, file)
        return BytesIO(file.getvalue())

    return write
