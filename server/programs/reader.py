"""Uploads are read in a process of their own: a hostile one costs a web process nothing.

`ast.parse` holds the interpreter for its whole duration, which is quadratic in some sources
(nested f-strings of 500 KiB took 45 s in Python 3.11), and an archive expands in memory.
"""

import json
import signal
import subprocess
import sys
import threading
from typing import Any, BinaryIO

from seamark.programs import preparation
from seamark.programs.diagnostics import Diagnostic, Stage
from seamark.programs.parameters import Parameter
from seamark.programs.preparation import PreparedProgram, UploadRejected, UploadTooLarge
from seamark.sandbox.languages import LANGUAGES
from seamark.server.programs import vehicles
from seamark.server.programs.fair_semaphore import FairSemaphore
from seamark.server.programs.own_files import FileRejected
from seamark.server.programs.vehicles import VehicleRejected, VehicleReport
from seamark.sim.settings.own_files import LIBRARIES
from seamark.sim.vehicles.toml_reading import BYTES_MAX

SLOTS = 2  # uploads of one web process that are read at the same time; the others wait
WAIT_S = 15.0  # for a slot
WAITING_MAX = 3  # uploads of one account: each has a thread of the web server
WALL_S = 20.0  # the CPU time is limited in `reader_process`; this catches a machine that is busy
_CHUNK = 64 * 1024
_COMMAND = (sys.executable, "-I", "-m", "seamark.server.programs.reader_process")
_TOO_HEAVY = "{}: reading it takes too much time or memory. Split it, or make it simpler."
_BY_LIMIT = {-signal.SIGKILL, -signal.SIGXCPU}  # the kernel sends SIGKILL at the hard CPU limit


class ReaderBroken(Exception):
    """The process that reads uploads failed: a fault of the service."""


class ProgramReader:
    """Reads uploads in limited processes, of which one waits ready for the next upload."""

    def __init__(self, *, wait_s: float = WAIT_S, waiting_max: int = WAITING_MAX) -> None:
        self.slots = FairSemaphore(SLOTS, wait_s=wait_s, waiting_max=waiting_max, what="uploads")
        self._lock = threading.Lock()
        self._spare: subprocess.Popen[bytes] | None = None
        self._closed = False

    def read_upload(
        self, stream: BinaryIO, filename: str, *, owner: str, limit: int, role: str
    ) -> PreparedProgram:
        """Read an upload into normal form.

        Parameters
        ----------
        owner
            Whose upload it is: one of each owner is read at a time.
        limit : int [B]
            A larger upload is rejected without reading the rest; source files already at
            `preparation.TEXT_MAX_BYTES`.
        role
            What the benchmark evaluates: a key of `interfaces.INTERFACES`.

        Raises
        ------
        UploadRejected
            It cannot be a program, or reading it costs too much.
        SlotsBusy
            Too many uploads are being read: not the fault of this one.
        ReaderBroken
            The service could not read it.
        """
        name = preparation.clean_name(filename)
        language = preparation.language_by_suffix(name)  # before anything is read
        if language is not None and LANGUAGES[language].is_text:
            limit = min(limit, preparation.TEXT_MAX_BYTES)
        source = _read(stream, limit)
        with self.slots.taken(owner):
            return self._prepare(source, name, role)

    def read_vehicle(
        self, stream: BinaryIO, filename: str, *, owner: str
    ) -> tuple[VehicleReport, bytes]:
        """Return what is to be said of the file of a vehicle, and the file.

        Raises
        ------
        VehicleRejected
            It is too large, or reading it costs too much.
        SlotsBusy, ReaderBroken
            As `read_upload`.
        """
        name = preparation.clean_name(filename)
        content = stream.read(BYTES_MAX + 1)
        vehicles.refuse_large(len(content))
        try:
            with self.slots.taken(owner):
                output = self._answer({"vehicle": True}, content, name)
        except UploadRejected as refusal:
            raise VehicleRejected(str(refusal)) from None
        return VehicleReport.from_json(json.loads(output)), content

    def read_file(self, stream: BinaryIO, filename: str, *, setting: str, owner: str) -> bytes:
        """Return the file to keep of one that a setting can name.

        Raises
        ------
        FileRejected
            It breaks a rule, is too large, or reading it costs too much.
        SlotsBusy, ReaderBroken
            As `read_upload`.
        """
        name = preparation.clean_name(filename)
        content = stream.read(LIBRARIES[setting].bytes_max + 1)
        try:
            with self.slots.taken(owner):
                output = self._answer({"setting": setting}, content, name)
        except UploadRejected as refusal:
            raise FileRejected(str(refusal), field=setting) from None
        line, _, kept = output.partition(b"\n")
        refused = json.loads(line)["refused"]
        if refused:
            raise FileRejected(f"{name}: {refused}", field=setting)
        return kept

    def close(self) -> None:
        """End the process that waits."""
        with self._lock:
            self._closed = True
            spare, self._spare = self._spare, None
        if spare is not None:
            _end(spare)

    def _prepare(self, source: bytes, name: str, role: str) -> PreparedProgram:
        return _prepared(self._answer({"filename": name, "role": role}, source, name))

    def _answer(self, request: dict[str, Any], source: bytes, name: str) -> bytes:
        """Return what a process answers; raises UploadRejected if that costs too much."""
        line = json.dumps(request).encode() + b"\n"
        process = self._take()
        try:
            output, errors = process.communicate(line + source, timeout=WALL_S)
        except subprocess.TimeoutExpired:
            raise UploadRejected(_TOO_HEAVY.format(name)) from None
        finally:
            _end(process)
            self._start_spare()
        if process.returncode in _BY_LIMIT or b"MemoryError" in errors[-200:]:
            raise UploadRejected(_TOO_HEAVY.format(name))
        if process.returncode < 0:  # the interpreter itself crashed, as on deeply nested source
            raise UploadRejected(f"{name}: the file cannot be parsed.")
        if process.returncode > 0:
            raise ReaderBroken(errors[-2000:].decode(errors="replace"))
        return output

    def _take(self) -> "subprocess.Popen[bytes]":
        """Return a process that waits for an upload."""
        with self._lock:
            process, self._spare = self._spare, None
        if process is not None and process.poll() is None:
            return process
        return _start()

    def _start_spare(self) -> None:
        with self._lock:
            if self._spare is None and not self._closed:
                self._spare = _start()


def _start() -> "subprocess.Popen[bytes]":
    """Start a process that reads one upload; it ends with this one, whose pipe it reads."""
    pipe = subprocess.PIPE
    # It needs no secret of the service, and no memory for threads of NumPy or OpenCV on each core.
    environment = {"OPENBLAS_NUM_THREADS": "1", "OPENCV_FOR_THREADS_NUM": "1"}
    return subprocess.Popen(_COMMAND, stdin=pipe, stdout=pipe, stderr=pipe, env=environment)


def _end(process: "subprocess.Popen[bytes]") -> None:
    """Kill the process if it still runs, reap it and close its pipes."""
    process.kill()
    process.wait()
    for stream in (process.stdin, process.stdout, process.stderr):
        if stream is not None:
            stream.close()


def _prepared(output: bytes) -> PreparedProgram:
    line, _, content = output.partition(b"\n")
    answer = json.loads(line)
    if "refused" in answer:
        raise UploadRejected(answer["refused"])
    diagnostics = tuple(_diagnostic(values) for values in answer["diagnostics"])
    declared = tuple(map(Parameter.from_json, answer["parameters"]))
    return PreparedProgram(answer["name"], answer["language"], content, diagnostics, declared)


def _diagnostic(values: dict[str, Any]) -> Diagnostic:
    return Diagnostic(**values | {"stage": Stage(values["stage"])})


def _read(stream: BinaryIO, limit: int) -> bytes:
    chunks: list[bytes] = []
    size = 0
    while chunk := stream.read(_CHUNK):
        size += len(chunk)
        if size > limit:
            raise UploadTooLarge(f"The file is larger than {limit / 2**20:g} MiB.")
        chunks.append(chunk)
    return b"".join(chunks)
