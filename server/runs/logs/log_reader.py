"""Logs of missions that are uploaded: measured in limited processes, a few at a time."""

from __future__ import annotations

from pathlib import Path
from typing import BinaryIO

from seamark.mission_logs.limited import measure_limited
from seamark.mission_logs.result import LogRefused, LogResult
from seamark.mission_logs.scope import SUFFIXES, unknown_file
from seamark.server.programs.fair_semaphore import FairSemaphore

SLOTS = 2  # logs that one web process has measured at the same time; the others wait
WAIT_S = 20.0  # for a slot
WAITING_MAX = 2  # uploads of one account: each has a thread of the web server
_CHUNK = 1 << 20


class LogTooLarge(LogRefused):
    """The file is larger than an upload may be."""


class LogReader:
    """The slots of one web process."""

    def __init__(self) -> None:
        self._slots = FairSemaphore(SLOTS, wait_s=WAIT_S, waiting_max=WAITING_MAX, what="logs")

    def read(
        self,
        stream: BinaryIO,
        filename: str,
        mapping: str,
        *,
        benchmark: str,
        owner: str,
        limit: int,
        folder: Path,
    ) -> LogResult:
        """Return what the measuring of an uploaded log gives.

        Parameters
        ----------
        filename
            Its suffix says what the file is; the rest of the name is not kept.
        mapping
            What the log means, in TOML or JSON.
        benchmark
            Empty: that of the mapping, or the default.
        owner
            Whose upload it is: one of each owner is measured at a time.
        limit : int [B]
            A larger file is refused without reading the rest.
        folder
            Holds the upload meanwhile, and the rows as long as they are used.

        Raises
        ------
        LogRefused
            The log cannot be read or measured, or costs too much.
        SlotsBusy
            There was no slot in time.
        """
        suffix = Path(filename[-100:].lower()).suffix
        if suffix not in SUFFIXES:
            raise LogRefused(unknown_file(filename[-100:]))
        path = folder / f"log{suffix}"
        _copy(stream, path, limit)
        with self._slots.taken(owner):
            return measure_limited(path, mapping, benchmark=benchmark, folder=folder)


def _copy(stream: BinaryIO, path: Path, limit: int) -> None:
    """Write a stream to a file; raises LogTooLarge beyond the limit."""
    left = limit
    with path.open("wb") as file:
        while chunk := stream.read(_CHUNK):
            left -= len(chunk)
            if left < 0:
                raise LogTooLarge(f"The file is larger than {limit / 2**20:g} MiB.")
            file.write(chunk)
