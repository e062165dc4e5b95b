"""What downloads cost: compressing a CSV, and the file formats beside writing plain rows."""

import zlib
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from io import RawIOBase
from multiprocessing import get_context
from pathlib import Path
from time import process_time
from typing import Any, BinaryIO, cast

import numpy as np

from performance.tables import Row, cpu_us
from seamark.formats.recording import Recording
from seamark.formats.registry import FORMATS
from seamark.server.web import compression
from seamark.sim.engine.program import BuiltIn
from seamark.sim.engine.trial import run_trial
from seamark.sim.recording import telemetry
from seamark.sim.recording.telemetry import Rows
from seamark.sim.registry import benchmark

SCENARIO = {"levels": [0.2], "level_duration_s": 120.0}
RANKED_ROWS = 130_000  # of a ranked run of currents-v2
LONGER = 7  # times as long: close to the limit of a MAT-file


class _Discarded(RawIOBase):
    """A file that counts what is written to it."""

    count = 0

    def writable(self) -> bool:
        return True

    def write(self, data: Any) -> int:
        self.count += len(data)
        return len(data)

    def tell(self) -> int:
        return self.count


def rows() -> list[Row]:
    """Measure the formats on two minutes of telemetry of the built-in PI controller, repeated."""
    table = _recorded()
    return [*_compression(table), *_formats(table)]


def _recorded() -> Rows:
    config = benchmark("currents-v1").read(SCENARIO)
    parts: list[telemetry.Rows] = []
    program = BuiltIn("pi", config)
    run_trial("currents-v1", config, program, seed=1, trial=0, on_rows=parts.append)
    return np.concatenate(parts)


def _compression(table: Rows) -> list[Row]:
    text = telemetry.csv_lines(table).encode()
    plain = cpu_us(lambda: telemetry.csv_lines(table), repeats=5)
    gzipped = zlib.compress(text, compression.LEVEL)
    compressing = cpu_us(lambda: zlib.compress(text, compression.LEVEL), repeats=5)
    megabytes = len(text) / 1e6
    return [
        Row(
            what="gzip of telemetry.csv",
            value=compressing / 1e3 / megabytes,
            unit="ms CPU per MB",
            baseline="writing it as CSV",
            baseline_value=plain / 1e3 / megabytes,
        ),
        Row(
            what="telemetry.csv with gzip",
            value=len(gzipped) / 1e6,
            unit="MB",
            baseline="without",
            baseline_value=megabytes,
        ),
    ]


def _formats(table: Rows) -> list[Row]:
    """Measure each format in a process of its own, as the service writes it."""
    results: list[Row] = []
    plain_s, _, _ = _alone("npz", table, RANKED_ROWS)
    plain_mb = measured("npz", table, len(table))[1]
    for name in FORMATS:
        seconds, _, peak = _alone(name, table, RANKED_ROWS)
        megabytes = measured(name, table, len(table))[1]  # repeated rows compress too well
        _, _, longer = _alone(name, table, LONGER * RANKED_ROWS)
        memory = f"{name}: peak memory of a run {LONGER} times as long"
        results += [
            _row(f"{name}: time", seconds, "s CPU", "as npz", plain_s),
            _row(f"{name}: size", megabytes, "MB", "as npz", plain_mb),
            _row(memory, longer, "MB with imports", "of a ranked run", peak),
        ]
    return results


def _row(what: str, value: float, unit: str, baseline: str, other: float) -> Row:
    return Row(what=what, value=value, unit=unit, baseline=baseline, baseline_value=other)


def _alone(name: str, table: Rows, count: int) -> Sequence[float]:
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        return pool.submit(measured, name, table, count).result()


def measured(name: str, table: Rows, count: int) -> tuple[float, float, float]:
    """Return CPU time [s], size [MB] and peak memory [MB] of writing a format in this process."""

    def read(start: int, stop: int) -> Rows:
        part: Rows = table[np.arange(start, stop) % len(table)]
        return part

    recording = Recording(
        title="a run",
        benchmark="currents-v1",
        config=benchmark("currents-v1").read(SCENARIO).model_dump(mode="json"),
        width=table.shape[1],
        row_count=count,
        read=read,
        seeds=[1],
    )
    if FORMATS[name].images:  # the images cost what they cost; their number is limited
        recording = replace(recording, seeds=None)
    file = _Discarded()
    began_s = process_time()
    FORMATS[name].write(recording, cast("BinaryIO", file))
    return process_time() - began_s, file.count / 1e6, _peak_mb()


def _peak_mb() -> float:
    """Return the peak memory of this process; that of getrusage would include its parent's."""
    status = Path("/proc/self/status").read_text()
    line = next(line for line in status.splitlines() if line.startswith("VmHWM:"))
    return int(line.split()[1]) / 1e3
