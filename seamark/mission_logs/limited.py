"""Logs are read in a process of their own: a hostile one costs its caller a bounded time.

A chunk of a bag that unpacks to gigabytes, or a count of billions, ends that process and nothing
else.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np

from seamark.mission_logs.mapping import LogMapping
from seamark.mission_logs.result import LogRefused, LogResult
from seamark.mission_logs.scope import SUFFIXES, unknown_file
from seamark.sandbox.printable_text import printable_text

WALL_S = 300.0  # the CPU time is limited in `process`; this catches a machine that is busy
TOO_HEAVY = "Reading the log takes too much time or memory. Cut it into parts, or leave out images."
_COMMAND = (sys.executable, "-I", "-m", "seamark.mission_logs.process")
# Compiled code of the camera is found by these; no secret of a service is among them.
_ENVIRONMENT = ("HOME", "XDG_CACHE_HOME", "NUMBA_CACHE_DIR", "NUMBA_CPU_NAME", "PATH")
_ROWS = "rows.f64"
_BY_LIMIT = {-signal.SIGKILL, -signal.SIGXCPU, -signal.SIGXFSZ}


class LogReaderBroken(Exception):
    """The process that reads logs failed: a fault of Seamark, not of the log."""


def measure_limited(
    path: Path, mapping: LogMapping | str, *, benchmark: str, folder: Path
) -> LogResult:
    """Return what `measuring.measure` returns, within limits.

    Parameters
    ----------
    mapping
        Or its document, which is parsed within the limits, too: 16 KiB of TOML can take seconds.
    benchmark
        Empty: that of the mapping, or the default.
    folder
        For the rows, which are mapped from a file there and not kept in memory, and for what the
        process unpacks. The caller removes it, also after a process that was killed.

    Raises
    ------
    LogRefused
        The log cannot be read or measured, or costs too much.
    LogReaderBroken
        The process failed.
    """
    if not path.is_dir() and path.suffix not in SUFFIXES:
        raise LogRefused(unknown_file(path.name))
    request = {
        "path": str(path.absolute()),
        "mapping": mapping if isinstance(mapping, str) else mapping.model_dump(mode="json"),
        "benchmark": benchmark,
        "rows": str(folder / _ROWS),
    }
    environment = {name: os.environ[name] for name in _ENVIRONMENT if name in os.environ}
    environment["TMPDIR"] = str(folder)
    try:
        done = subprocess.run(
            _COMMAND,
            input=json.dumps(request).encode() + b"\n",
            capture_output=True,
            env=environment,
            timeout=WALL_S,
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise LogRefused(TOO_HEAVY) from None
    if done.returncode in _BY_LIMIT or b"MemoryError" in done.stderr[-500:]:
        raise LogRefused(TOO_HEAVY)
    if done.returncode:
        raise LogReaderBroken(done.stderr[-2000:].decode(errors="replace"))
    return _result(done.stdout, folder / _ROWS)


def _result(output: bytes, file: Path) -> LogResult:
    answer = json.loads(output)
    if "refused" in answer:
        raise LogRefused(printable_text(answer["refused"]))  # it quotes the log
    width = answer.pop("width")
    rows = np.memmap(file, "<f8", mode="r").reshape(-1, width)
    return LogResult(rows=rows, **answer)
