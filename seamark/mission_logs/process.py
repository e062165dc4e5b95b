"""The process that reads and measures one log: limited in CPU time and memory, then gone.

Protocol: a line of JSON with the request on standard input; on standard output a line of JSON with
the answer. The rows go into the file that the request names, as little-endian float64: hundreds of
megabytes, which whoever asks shall not hold in memory. Started by `limited`.
"""

import json
import os
import resource
import sys
from pathlib import Path
from typing import Any

import numpy as np

from seamark.mission_logs.mapping import LogMapping
from seamark.mission_logs.result import LogRefused
from seamark.mission_logs.scope import check_benchmark
from seamark.sim.registry import DEFAULT_BENCHMARK

CPU_S = 120  # the largest CSV with all columns takes half of it
DATA_MIB = 2048  # the largest log takes half of it
FILE_MIB = 512  # the rows; a compressed ROS 2 bag is unpacked into a temporary file
OPEN_FILES = 64
NICENESS = 10  # pages go first


def main() -> None:
    """Answer one request."""
    limit()
    request = json.loads(sys.stdin.buffer.readline())
    answer = _answer(request)
    sys.stdout.buffer.write(json.dumps(answer, allow_nan=False).encode() + b"\n")
    sys.stdout.buffer.flush()


def _answer(request: dict[str, Any]) -> dict[str, Any]:
    try:
        mapping = _mapping(request["mapping"])
        benchmark = request["benchmark"] or mapping.benchmark or DEFAULT_BENCHMARK
        check_benchmark(benchmark)
        from seamark.mission_logs.measuring import measure  # half of the time of a refusal

        result = measure(Path(request["path"]), mapping, benchmark=benchmark)
    except LogRefused as reason:
        return {"refused": str(reason)}
    np.ascontiguousarray(result.rows, dtype="<f8").tofile(request["rows"])
    return {
        "benchmark": result.benchmark,
        "config": result.config,
        "trials": result.trials,
        "metrics": result.metrics,
        "manifest": result.manifest,
        "digest": result.digest,
        "width": result.rows.shape[1],
    }


def _mapping(given: str | dict[str, Any]) -> LogMapping:
    if isinstance(given, str):
        return LogMapping.parse(given)
    return LogMapping.model_validate(given)


def limit() -> None:
    """Limit this process; what it has used for its start counts."""
    os.nice(NICENESS)
    for kind, most in (
        (resource.RLIMIT_CPU, CPU_S),
        (resource.RLIMIT_DATA, DATA_MIB << 20),
        (resource.RLIMIT_FSIZE, FILE_MIB << 20),
        (resource.RLIMIT_NOFILE, OPEN_FILES),
        (resource.RLIMIT_CORE, 0),
    ):
        resource.setrlimit(kind, (most, most))


if __name__ == "__main__":
    main()
