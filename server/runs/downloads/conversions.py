"""Runs in other formats, written by processes of their own while clients receive them.

A web process gives each of them a slot. So a download costs it a pipe and 64 KiB, however long the
run is; libraries and rows are in memory elsewhere, and pages keep the interpreter to themselves.
"""

import json
import os
import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, suppress
from dataclasses import asdict, dataclass, field
from typing import BinaryIO

from seamark.formats.registry import Format
from seamark.server.programs.fair_semaphore import FairSemaphore
from seamark.server.runs.data.files import RunFiles

SLOTS = 2  # runs that one web process has converted at once, in up to 250 MB each; others wait
WAIT_S = 20.0  # for a slot; most files take less
WAITING_MAX = 2  # downloads of one client: each has a thread of the web server
_CHUNK = 64 * 1024
COMMAND = (sys.executable, "-I", "-m", "seamark.server.runs.downloads.conversion_process")
_ERRORS_SHOWN = 2000  # characters
# Compiled code of the camera is found by these; no secret of the service is among them.
_ENVIRONMENT = ("HOME", "XDG_CACHE_HOME", "NUMBA_CACHE_DIR", "NUMBA_CPU_NAME", "PATH")


class ConversionFailed(Exception):
    """The process that writes a file failed, or its client took nothing for long."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Job:
    """What is to be written: fields of a `Recording`, as far as JSON knows them."""

    title: str
    benchmark: str
    config: dict[str, object]
    rows: int
    seeds: list[int] | None
    comments: list[str]
    manifest: dict[str, object] | None
    metrics: dict[str, object] | None
    program: str | None = None  # its name
    parts: list[tuple[str, str, int]] = field(default_factory=list)  # role, name, size [B]
    files: dict[str, str] = field(default_factory=dict)  # setting -> file of the user's own
    extra_files: dict[str, str]

    def request(self, kind: Format, files: RunFiles) -> bytes:
        """Return the line that asks for a format; it says everything that the file depends on."""
        location = {"data": str(files.data), "run": files.run_id, "attempt": files.attempt}
        return json.dumps(asdict(self) | location | {"format": kind.name}).encode() + b"\n"


class Conversions:
    """The slots of one web process; `command` starts the process that writes a file."""

    def __init__(self, *, wait_s: float = WAIT_S, command: Sequence[str] = COMMAND) -> None:
        self._slots = FairSemaphore(SLOTS, wait_s=wait_s, waiting_max=WAITING_MAX, what="downloads")
        self._command = command

    def start(self, request: bytes, *, owner: str) -> "Conversion":
        """Return a conversion with a slot; its process starts when the first piece is read.

        Parameters
        ----------
        request
            The line of a job, and its programs.
        owner
            Who downloads: one file of each is written at a time.

        Raises
        ------
        SlotsBusy
            There was no slot in time.
        """
        held = ExitStack()
        held.enter_context(self._slots.taken(owner))
        return Conversion(self._command, request, held)


class Conversion:
    """The pieces of one file; `close` gives the slot back, whether it was read or not.

    The end of the process gives it back as well: a client may never take the last pieces.
    """

    def __init__(self, command: Sequence[str], request: bytes, slot: ExitStack) -> None:
        self._command, self._request, self._slot = command, request, slot
        self._held = ExitStack()
        self._held.callback(self._give_back)
        self._giving_back = threading.Lock()

    def __iter__(self) -> Iterator[bytes]:
        """Yield the file; raises ConversionFailed."""
        with self._held, tempfile.TemporaryFile() as errors:
            process = _start(self._command, errors)
            self._held.callback(_end, process)
            threading.Thread(target=self._give_back_after, args=(process,), daemon=True).start()
            yield from _exchange(process, self._request)
            if process.wait():
                errors.seek(0)
                text = errors.read()[-_ERRORS_SHOWN:].decode(errors="replace")
                raise ConversionFailed(f"exit status {process.returncode}: {text}")

    def close(self) -> None:
        """End the process and give the slot back."""
        self._held.close()

    def _give_back_after(self, process: "subprocess.Popen[bytes]") -> None:
        process.wait()
        self._give_back()

    def _give_back(self) -> None:
        with self._giving_back:
            self._slot.close()


def _start(command: Sequence[str], errors: BinaryIO) -> "subprocess.Popen[bytes]":
    environment = {name: os.environ[name] for name in _ENVIRONMENT if name in os.environ}
    pipe = subprocess.PIPE
    return subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=errors, env=environment)


def _end(process: "subprocess.Popen[bytes]") -> None:
    """Kill the process if it still runs, reap it and close its pipes."""
    process.kill()
    process.wait()
    for stream in (process.stdin, process.stdout):
        if stream is not None:
            with suppress(BrokenPipeError):
                stream.close()


def _exchange(process: "subprocess.Popen[bytes]", request: bytes) -> Iterator[bytes]:
    """Send the request and yield what the process writes."""
    if process.stdin is None or process.stdout is None:
        raise ValueError("the process has no pipes")
    with suppress(BrokenPipeError):  # it has failed: its exit status says so
        process.stdin.write(request)
        process.stdin.close()
    while piece := process.stdout.read(_CHUNK):
        yield piece
