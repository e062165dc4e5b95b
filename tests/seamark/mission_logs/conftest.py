"""A short simulated run, whose telemetry the tests write as logs."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from seamark.mission_logs.mapping import LogMapping
from seamark.mission_logs.measuring import measure
from seamark.mission_logs.result import LogResult
from seamark.sim import registry
from seamark.sim.engine.program import BuiltIn
from seamark.sim.engine.summary import summarise
from seamark.sim.engine.trial import run_trial
from seamark.sim.recording import telemetry
from seamark.sim.recording.telemetry import INDEX, Rows

SETTINGS = {"levels": [0.0, 0.3], "settle_s": 1.0}
POSE = ("x", "y", "z", "roll", "pitch", "yaw")
CORNERS = tuple(f"corner_{i}" for i in range(8))
Measure = Callable[..., LogResult]


@dataclass(frozen=True)
class Run:
    """A simulated run: its rows and its metrics.json."""

    rows: Rows
    metrics: dict[str, Any]

    def column(self, name: str) -> Any:
        """Return a column of the telemetry."""
        return self.rows[:, INDEX[name]]

    def level(self, number: int) -> "Run":
        """Return the rows of one level, whose time starts at 0."""
        rows = self.rows[self.column("level") == number].copy()
        rows[:, INDEX["t"]] -= rows[0, INDEX["t"]]
        return Run(rows, self.metrics)


@pytest.fixture(scope="session")
def run() -> Run:
    entry = registry.benchmark("currents-v1")
    config: Any = entry.read({**SETTINGS, "level_duration_s": 3.0})
    parts: list[Rows] = []
    result = run_trial(
        "currents-v1", config, BuiltIn("pi", config), seed=7, trial=0, on_rows=parts.append
    )
    return Run(np.concatenate(parts), summarise("currents-v1", config, [result]))


@pytest.fixture
def measured(tmp_path: Path) -> Measure:
    """Write a CSV file with some columns and return what its measuring gives."""

    def measured(columns: Mapping[str, Any], mapping: Mapping[str, Any] | None = None) -> LogResult:
        path = tmp_path / "log.csv"
        path.write_text(csv_of(columns))
        document = {"settings": SETTINGS} | dict(mapping or {})
        return measure(path, LogMapping.model_validate(document), benchmark="currents-v1")

    return measured


def csv_of(columns: Mapping[str, Any]) -> str:
    """Return a CSV document; every float reads back as the same number."""
    lines = [",".join(columns)]
    lines += [",".join(map(repr, map(float, row))) for row in zip(*columns.values(), strict=True)]
    return "\n".join(lines) + "\n"


def telemetry_csv(rows: Rows) -> str:
    """Return the document that `seamark run --out` writes."""
    return telemetry.header(["a run"], width=rows.shape[1]) + telemetry.csv_lines(rows)
