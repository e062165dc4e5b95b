"""The result of a run on this machine, in the folder that `seamark run --out` wrote."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from seamark.formats import csv_file
from seamark.formats.archive import LOG
from seamark.formats.recording import Program, Recording
from seamark.sim import registry
from seamark.sim.recording import telemetry
from seamark.sim.recording.telemetry import Rows
from seamark.sim.settings import grid

_PARAMETERS = "parameters"  # of the program, in a configuration


class NoResult(ValueError):
    """The folder has no result of this version. The text is for the user."""


def recording_of(
    folder: Path, program: Program | None = None, parts: Mapping[str, Program] | None = None
) -> Recording:
    """Return the result in a folder; raises NoResult."""
    try:
        manifest = _object(folder / "manifest.json")
        metrics = _object(folder / "metrics.json") if (folder / "metrics.json").exists() else None
        names, rows = _rows(folder / "telemetry.csv")
        config = dict(manifest["configuration"])
        if manifest.get(_PARAMETERS):
            config[_PARAMETERS] = manifest[_PARAMETERS]
        benchmark = str(manifest["benchmark"])
        levels = grid.level_comments(registry.benchmark(benchmark).restore(config))
    except (OSError, ValueError, LookupError, TypeError) as error:
        raise NoResult(
            f"{folder} is not the result of a finished run ({error}). `seamark run --out {folder}` "
            "writes one."
        ) from None
    if names != telemetry.names(len(names)):
        raise NoResult(f"{folder}: telemetry.csv has columns of another version.")
    return Recording(
        title=folder.resolve().name,
        benchmark=benchmark,
        config=config,
        width=len(names),
        row_count=len(rows),
        read=lambda start, stop: rows[start:stop],
        seeds=_seeds(manifest),
        comments=[f"Seamark {benchmark}", *levels, telemetry.units(len(names))],
        manifest=manifest,
        metrics=metrics,
        program=program,
        parts=parts or {},
    )


def _seeds(manifest: dict[str, Any]) -> list[int] | None:
    """Return the seeds of the trials, which camera images need; None if there are no images.

    A log has no seed: the noise in its images is that of 0, as on a server.
    """
    trials, absent = int(manifest["trials"]), manifest.get("absent", ())
    if manifest["controller"] == LOG:
        return None if set(telemetry.POSE_COLUMNS) & set(absent) else [0] * trials
    seeds: list[int] | None = manifest.get("seeds")
    return seeds or [manifest["seed"]] * trials


def _rows(path: Path) -> tuple[tuple[str, ...], Rows]:
    with path.open(encoding="utf-8") as lines:
        names = csv_file.read_names(lines)
        blocks = list(csv_file.read_blocks(lines, len(names)))
    return names, np.concatenate(blocks) if blocks else np.empty((0, len(names)))


def _object(path: Path) -> dict[str, Any]:
    value = json.loads(path.read_text(encoding="utf-8"))
    if not isinstance(value, dict):
        raise ValueError(f"{path.name} is no JSON object")
    return value
