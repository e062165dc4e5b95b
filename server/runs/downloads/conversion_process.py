"""The process that writes one run in one format: limited in CPU time and memory, then gone.

Protocol: a line of JSON with the job and then its programs, if any, on standard input: that of the
benchmark's role, then those of further roles. The file is on standard output. `conversions` starts
the process.
"""

import json
import os
import resource
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any

from seamark.formats.recording import Program, Recording
from seamark.formats.registry import FORMATS
from seamark.server.runs.data.files import RunFiles
from seamark.server.runs.downloads.slow_readers import DeadlineOutput
from seamark.sim.settings import own_files

CPU_S = 900  # the largest run as MCAP, with its images, takes a third of it
DATA_MIB = 2048  # beyond this a format does not keep its promise; Arrow and OpenCV need 400
OPEN_FILES = 128
NICENESS = 10  # pages go first


def main() -> None:
    """Write one file."""
    _limit()
    job: dict[str, Any] = json.loads(sys.stdin.buffer.readline())
    recording = _recording(job, sys.stdin.buffer.read())
    FORMATS[job["format"]].write(recording, DeadlineOutput(sys.stdout.buffer))  # type: ignore[arg-type]
    sys.stdout.buffer.flush()


def _recording(job: dict[str, Any], programs: bytes) -> Recording:
    for setting, text in job["files"].items():
        with suppress(*own_files.INVALID):  # most likely accepted by an older version
            own_files.add(setting, text.encode())
    end = len(programs) - sum(size for _role, _name, size in job["parts"])
    parts: dict[str, Program] = {}
    for role, name, size in job["parts"]:
        start = end + sum(len(part.content) for part in parts.values())
        parts[role] = Program(name, programs[start : start + size])
    files = RunFiles(Path(job["data"]), job["run"], job["attempt"])
    return Recording(
        title=job["title"],
        benchmark=job["benchmark"],
        config=job["config"],
        width=len(files.columns),
        row_count=job["rows"],
        read=files.rows,
        seeds=job["seeds"],
        comments=job["comments"],
        manifest=job["manifest"],
        metrics=job["metrics"],
        program=Program(job["program"], programs[:end]) if job["program"] else None,
        parts=parts,
        extra_files=job["extra_files"],
    )


def _limit() -> None:
    """Limit this process; what it has used for its start counts."""
    os.nice(NICENESS)
    for kind, most in (
        (resource.RLIMIT_CPU, CPU_S),
        (resource.RLIMIT_DATA, DATA_MIB << 20),
        (resource.RLIMIT_NOFILE, OPEN_FILES),
        (resource.RLIMIT_CORE, 0),
    ):
        resource.setrlimit(kind, (most, most))


if __name__ == "__main__":
    main()
