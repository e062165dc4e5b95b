"""What compressing a download costs: telemetry as CSV with gzip beside the same CSV without."""

import zlib

import numpy as np

from performance.table import Row, cpu_us
from seamark.server.web import compression
from seamark.sim.engine.program import BuiltIn
from seamark.sim.engine.trial import run_trial
from seamark.sim.recording import telemetry
from seamark.sim.registry import benchmark

SCENARIO = {"levels": [0.2], "level_duration_s": 120.0}


def rows() -> list[Row]:
    """Measure two minutes of telemetry of the built-in PI controller."""
    config = benchmark("currents-v1").read(SCENARIO)
    parts: list[telemetry.Rows] = []
    program = BuiltIn("pi", config)
    run_trial("currents-v1", config, program, seed=1, trial=0, on_rows=parts.append)
    table = np.concatenate(parts)
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
