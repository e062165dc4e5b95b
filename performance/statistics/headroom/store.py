"""docs/headroom.json: what the entries of the benchmarks scored, one entry a line."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from performance import DOCS

FILE = DOCS / "headroom.json"


def stored(benchmark: str, *, file: Path = FILE) -> dict[str, dict[str, Any]]:
    """Return what was measured of a benchmark, by the short names of the entries."""
    return dict(_read(file).get(benchmark, {}))


def store(benchmark: str, entries: Mapping[str, Mapping[str, Any]], *, file: Path = FILE) -> None:
    """Replace all entries of a benchmark."""
    blocks = [
        f"{json.dumps(name)}: {{\n{_lines(results)}\n}}"
        for name, results in (_read(file) | {benchmark: entries}).items()
    ]
    file.write_text("{\n" + ",\n".join(blocks) + "\n}\n", "utf-8")


def _lines(entries: Mapping[str, Mapping[str, Any]]) -> str:
    return ",\n".join(f" {json.dumps(name)}: {json.dumps(one)}" for name, one in entries.items())


def _read(file: Path) -> dict[str, Mapping[str, Any]]:
    by_benchmark: dict[str, Mapping[str, Any]] = json.loads(file.read_text("utf-8"))
    return by_benchmark
