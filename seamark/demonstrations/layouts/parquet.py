"""Plain Parquet: a table of all steps and one of the episodes."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from seamark.demonstrations.description import FILE, Description
from seamark.demonstrations.layouts import Episode
from seamark.demonstrations.layouts.columns import numbers, vectors
from seamark.demonstrations.layouts.png import new_images, packed_images
from seamark.demonstrations.layouts.rolling import RollingTables

__all__ = ["packed_images", "refusal", "write"]
LIMIT_BYTES = 256 * 2**20


def refusal(description: Description) -> str:
    """Return nothing: all can be written."""
    return ""


def write(description: Description, episodes: Iterable[Episode], folder: Path) -> None:
    """Write `steps`, `episodes.parquet` and `seamark.json`."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    rows = []
    with RollingTables(folder / "steps", limit_bytes=LIMIT_BYTES) as steps:
        for number, episode in enumerate(episodes):
            steps.write(_steps(description, number, episode))
            told = episode.outcome.as_dict()
            rows.append({"episode": number} | {k: told[k] for k in told if k != "number"})
    pq.write_table(pa.Table.from_pylist(rows), folder / "episodes.parquet")
    (folder / FILE).write_text(description.text(), encoding="utf-8")


def _steps(description: Description, number: int, episode: Episode) -> Any:
    """Return an episode of n steps as n + 1 rows; the last has an observation, but no action."""
    import pyarrow as pa

    arrays = episode.arrays
    count = len(arrays["observations"])
    columns = {
        "episode": pa.array(np.full(count, number, np.int32)),
        "step": pa.array(np.arange(count, dtype=np.int32)),
        "observation": vectors(arrays["observations"]),
        "action": vectors(arrays["actions"], missing=1),
        "reward": numbers(arrays["rewards"], missing=1),
        "terminated": numbers(arrays["terminations"], missing=1),
        "truncated": numbers(arrays["truncations"], missing=1),
        "credit": numbers(arrays["credit"]),
        "stages": numbers(arrays["stages"].astype(np.int32)),
    }
    for camera in description.cameras:
        columns[f"image_{camera}"] = pa.array(new_images(arrays, camera), pa.binary())
    return pa.table(columns)
