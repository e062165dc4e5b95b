"""The same run in other processes and with fewer CPU instructions: which columns differ."""

import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np

from performance.simulator.validation.trials import SEED, trial
from performance.tables import markdown_table
from seamark.sim.recording.manifest import cpu_class
from seamark.sim.recording.telemetry import NAMES, STEP_US, Rows, digest

TITLE = "Determinism"
LEVELS, LEVEL_S = (0.0, 0.2, 0.4), 20.0
VEHICLE = "girona500"
LONGEST_S = 600.0
PROGRAM = """
import sys
import numpy as np
from performance.simulator.validation.determinism import short_run
np.save(sys.argv[1], short_run())
"""
# Instruction sets masked for Numba's compiler, glibc's functions and OpenCV's choice of kernels.
# Numba gets a cache of its own, so that it uses no code compiled earlier.
OLD_NUMBA = {"NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": ""}
OLD_GLIBC = {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-AVX512F,-AVX512VL,-AVX512BW"}
OLD_OPENCV = {"OPENCV_CPU_DISABLE": "AVX2,FMA3,AVX,AVX512_SKX,AVX512_ICL"}
SETTINGS: Mapping[str, Mapping[str, str]] = {
    "unchanged": {},
    "another hash seed, one thread": {
        "PYTHONHASHSEED": "7",
        "OMP_NUM_THREADS": "1",
    },
    "glibc without AVX2 and FMA": OLD_GLIBC,
    "Numba for the oldest x86-64, glibc and OpenCV without AVX2, FMA and AVX-512": OLD_NUMBA
    | OLD_GLIBC
    | OLD_OPENCV,
}


class Outcome(NamedTuple):
    """The telemetry of one process, compared with that of the first."""

    what: str
    digest: str
    differing: list[str]  # names of columns


def short_run() -> Rows:
    """Return the telemetry of a short trial of the whole chain."""
    return trial("pi", vehicle=VEHICLE, levels=LEVELS, level_duration_s=LEVEL_S, settle_s=5.0).rows


def in_process(settings: Mapping[str, str], folder: Path) -> Rows:
    """Return the telemetry of the short run in a process with these environment variables."""
    out = folder / "rows.npy"
    environment = {"PATH": os.environ.get("PATH", ""), **settings}
    if "NUMBA_CPU_NAME" in settings:
        environment["NUMBA_CACHE_DIR"] = str(folder / "cache")
    command = [sys.executable, "-c", PROGRAM, str(out)]
    subprocess.run(command, check=True, timeout=LONGEST_S, env=environment)
    rows: Rows = np.load(out)
    return rows


def differing_columns(first: Rows, second: Rows) -> list[str]:
    """Return the names of the digested columns whose bytes differ."""
    return [
        name
        for i, name in enumerate(NAMES)
        if i != STEP_US and first[:, i].tobytes() != second[:, i].tobytes()
    ]


def outcomes(settings: Mapping[str, Mapping[str, str]] = SETTINGS) -> list[Outcome]:
    """Return the outcome of each process; the first is the reference for the others."""
    processes: list[Outcome] = []
    first: Rows | None = None
    for what, variables in settings.items():
        with tempfile.TemporaryDirectory() as folder:
            rows = in_process(variables, Path(folder))
        first = rows if first is None else first
        processes.append(Outcome(what, digest(rows), differing_columns(first, rows)))
    return processes


def section(_names: list[str], _figures: Path) -> str:
    """Return the section's text."""
    processes = outcomes()
    columns = sorted({name for entry in processes for name in entry.differing})
    verdict = (
        f"All {len(processes)} processes gave the same bytes in every telemetry column."
        if not columns
        else f"**These columns differ:** {', '.join(columns)}."
    )
    rows = [
        (entry.what, f"`{entry.digest[:16]}`", ", ".join(entry.differing) or "none")
        for entry in processes
    ]
    return "\n\n".join(
        [
            verdict,
            f"Method: PI, `{VEHICLE}`, tracker `esm`, levels {', '.join(f'{v:g}' for v in LEVELS)} "
            f"m/s of {LEVEL_S:g} s each, seed {SEED}. Each row is a process of its own on one "
            f"machine ({cpu_class()['level']}), compared column by column and byte by byte. The "
            "digest is that of the telemetry without the controller's wall time. Masked "
            "instructions stand in for an older processor of the same family; processors of other "
            "manufacturers and other versions of the libraries are not tested.",
            markdown_table(("process", "digest (first 16 digits)", "columns that differ"), rows),
        ]
    )
