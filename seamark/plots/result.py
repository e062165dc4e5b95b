"""The result of a run, as `seamark run` leaves it in a folder or a server has it."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seamark.failures import UsageRefused

FILES = ("telemetry.csv", "metrics.json", "manifest.json")  # of those that `seamark run` writes
COLUMNS = (  # of the telemetry, that plots need
    *("trial", "level", "t", "x", "y", "current_x", "current_y", "current_z"),
    *("tracker_error", "distance"),
)
WORK_COLUMNS = ("reach",)  # likewise, of a run in which an arm works on something


@dataclass(frozen=True, slots=True, kw_only=True)
class Result:
    """What a run recorded. A run that failed has no metrics."""

    name: str  # in legends
    manifest: Mapping[str, Any]
    metrics: Mapping[str, Any] | None
    rows: NDArray[np.void]  # structured: the columns of the telemetry by name, if it was read

    @property
    def benchmark(self) -> str:
        """The name of the benchmark."""
        return str(self.manifest["benchmark"])

    def trial(self, number: int) -> NDArray[np.void]:
        """Return the rows of a trial."""
        rows: NDArray[np.void] = self.rows[self.rows["trial"] == number]
        return rows


def of_folder(folder: Path, *, telemetry: bool) -> Result:
    """Return the result in a folder that `seamark run --out` wrote.

    Raises
    ------
    UsageRefused
        It is not such a folder.
    """
    try:
        manifest = json.loads((folder / "manifest.json").read_text(encoding="utf-8"))
        if not isinstance(manifest, dict) or not {"benchmark", "configuration"} <= set(manifest):
            raise ValueError("manifest.json names no benchmark")
        metrics = folder / "metrics.json"
        document = json.loads(metrics.read_text(encoding="utf-8")) if metrics.exists() else None
        return Result(
            name=folder.name or str(folder),
            manifest=manifest,
            metrics=document,
            rows=_read_telemetry(folder / "telemetry.csv") if telemetry else no_rows(),
        )
    except (OSError, ValueError) as error:
        raise UsageRefused(
            f"{folder} is not the result of a finished run ({error}). `seamark run --out "
            f"{folder}` writes one."
        ) from None


def _read_telemetry(path: Path) -> NDArray[np.void]:
    with path.open(encoding="utf-8") as file:
        names = next((line for line in file if not line.startswith("#")), "").strip().split(",")
        wanted = [*COLUMNS, *(name for name in WORK_COLUMNS if name in names)]
        columns = [names.index(name) for name in wanted]
        lines = file.readlines()
    if not lines:
        raise ValueError("telemetry.csv has no rows")
    numbers = np.loadtxt(lines, delimiter=",", usecols=columns, ndmin=2)
    rows = _empty(len(numbers), wanted)
    for at, name in enumerate(wanted):
        rows[name] = numbers[:, at]
    return rows


def no_rows() -> NDArray[np.void]:
    """Return the telemetry of a result of which it is not needed."""
    return _empty(0, COLUMNS)


def _empty(count: int, columns: Sequence[str]) -> NDArray[np.void]:
    """Return rows to be filled."""
    return np.empty(count, dtype=[(name, "<f8") for name in columns])
