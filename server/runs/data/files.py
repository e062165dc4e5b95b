"""The files of a run: telemetry, log, manifest, metrics; readable while it is running.

`<data>/runs/<id // 1000>/<id>/<attempt>/` holds `telemetry.f64` (rows of little-endian float64),
`columns.json` (their names, so that a version with other columns can still read the rows),
`log.txt` (the start of the program's output), `log.tail` (the end of a longer output),
`manifest.json` and `metrics.json`. Each attempt has its own folder, so that a worker that
lost its lease never writes into the files of the next attempt. What nobody may see yet is in a
folder beside it, `<attempt>.held`.
"""

import json
import math
import os
import secrets
import shutil
from bisect import bisect_right
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seamark.sandbox.printable_text import printable_text
from seamark.sim.recording import telemetry
from seamark.sim.recording.telemetry import INDEX, WIDTH

HEAD_MAX = 256 * 1024  # [byte] of the log kept from its start
TAIL_MAX = 256 * 1024  # [byte] of the log kept from its end
RUNS_PER_FOLDER = 1000
HELD = ".held"  # ends the name of the folder of what is held back
_COPIED_BYTES = 4 * 2**20  # at a time
_COUNT_BYTES = 8
Rows = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class LogPart:
    """A part of the log. `next` is the offset after it; `dropped` bytes before it were not kept."""

    text: str
    next: int
    dropped: int


class StorageFailed(Exception):
    """A file of a run could not be written, for instance because the disk is full."""


class RunFiles:
    """Reads and writes the files of one attempt; without `attempt`, of the latest one."""

    def __init__(self, data: Path, run_id: int, attempt: int | None = None) -> None:
        self.root = data / "runs" / str(run_id // RUNS_PER_FOLDER) / str(run_id)
        chosen = attempt if attempt is not None else max(self.attempts(), default=0)
        self.attempt = chosen  # 0 while there are no files
        self.folder = self.root / str(chosen)
        self.data, self.run_id = data, run_id
        self.hidden: tuple[
            str, ...
        ] = ()  # what the log is shown without: names that tell its author
        self._made = False  # whether the folder was made here: it is never made again
        self._tail = b""
        self._written = 0
        self._names: tuple[str, ...] | None = None

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the columns of `rows`: those of this version, for the vehicle of the run."""
        return telemetry.names(telemetry.width_of(self._written_names()))

    def attempts(self) -> list[int]:
        """Return the attempts that have files."""
        if not self.root.is_dir():
            return []
        return sorted(int(entry.name) for entry in self.root.iterdir() if entry.name.isdigit())

    @property
    def telemetry_path(self) -> Path:
        """The file of the rows; it may not exist yet."""
        return self.folder / "telemetry.f64"

    def size(self) -> int:
        """Return how many bytes the files of this attempt take."""
        if not self.folder.is_dir():
            return 0
        return sum(file.stat().st_size for file in self.folder.iterdir())

    # -- writing: only by the worker that has the lease -------------------------------------------
    def remove_earlier_attempts(self) -> None:
        """Remove the files of the attempts before this one, whose workers have lost the run.

        A worker that does not know it yet fails at its next write.
        """
        for entry in self.root.iterdir() if self.root.is_dir() else ():
            attempt = entry.name.removesuffix(HELD)
            if attempt.isdigit() and int(attempt) < self.attempt:
                shutil.rmtree(entry, ignore_errors=True)

    def remove(self) -> None:
        """Remove the files of this attempt, with what was held back."""
        for folder in (self.folder, self.root / f"{self.attempt}{HELD}"):
            shutil.rmtree(folder, ignore_errors=True)

    def held_back(self) -> "RunFiles":
        """Return where rows and log of this attempt are written that nobody may see yet."""
        held = RunFiles(self.data, self.run_id, self.attempt)
        held.folder = self.root / f"{self.attempt}{HELD}"
        return held

    def append_all(self, held: "RunFiles") -> None:
        """Append the rows and the log of other files, and remove those."""
        if held.telemetry_path.exists():
            with held.telemetry_path.open("rb") as file:
                while piece := file.read(_COPIED_BYTES):
                    self._append(self.telemetry_path, piece)
        head, kept = (_bytes(held.folder / name) for name in ("log.txt", "log.tail"))
        self.append_log(head)
        if kept:
            # As far as the tail lies behind the head: what was not kept between them counts, too.
            self._written += int.from_bytes(kept[:_COUNT_BYTES], "little") - len(head)
            self.append_log(kept[_COUNT_BYTES:])
        held.remove()

    def append_rows(self, rows: Rows) -> None:
        """Append whole rows, shape (k, number of columns)."""
        if not self.telemetry_path.exists() and rows.ndim == 2 and rows.shape[1] >= WIDTH:
            self._names = telemetry.names(rows.shape[1])
            self._replace("columns.json", json.dumps(self._names).encode())
        if rows.ndim != 2 or rows.shape[1] != len(self._written_names()):
            raise ValueError(f"rows have shape {rows.shape}, not (k, {len(self._written_names())})")
        self._append(self.telemetry_path, np.ascontiguousarray(rows, dtype="<f8").tobytes())

    def truncate_rows(self, count: int) -> None:
        """Keep only the first `count` rows, before a trial is repeated."""
        if self.row_count() > count:
            os.truncate(self.telemetry_path, count * self._row_bytes())

    def append_log(self, text: bytes) -> None:
        """Append output of the program: first to the head, then to a tail of bounded length."""
        room = max(HEAD_MAX - self._written, 0)
        if text[:room]:
            self._append(self.folder / "log.txt", text[:room])
        self._written += len(text)
        if rest := text[room:]:
            self._tail = (self._tail + rest)[-TAIL_MAX:]
            start = self._written - len(self._tail)
            self._replace("log.tail", start.to_bytes(_COUNT_BYTES, "little") + self._tail)

    def write_json(self, name: str, value: Mapping[str, Any]) -> None:
        """Write `manifest.json` or `metrics.json` atomically."""
        self._replace(name, json.dumps(value, indent=2, allow_nan=False).encode())

    # -- reading: by any process, at any time -----------------------------------------------------
    def row_count(self) -> int:
        """Return the number of complete rows so far."""
        try:
            return self.telemetry_path.stat().st_size // self._row_bytes()
        except FileNotFoundError:
            return 0

    def rows(self, start: int = 0, stop: int | None = None) -> Rows:
        """Return the rows from `start` to before `stop`, shape (k, number of columns).

        The columns are those of this version: NaN where the version that wrote the rows had none.
        """
        end = self.row_count() if stop is None else min(stop, self.row_count())
        count = max(end - max(start, 0), 0)
        if count == 0:
            return np.empty((0, len(self.columns)))
        names, columns = self._written_names(), self.columns
        offset = max(start, 0) * self._row_bytes()
        try:
            values = np.fromfile(self.telemetry_path, "<f8", count * len(names), offset=offset)
        except FileNotFoundError:  # removed since they were counted
            return np.empty((0, len(columns)))
        rows = values.reshape(count, len(names)).astype(np.float64, copy=False)
        return rows if names == columns else _in_current_columns(rows, names, columns)

    def rows_at(self, indices: Sequence[int]) -> Rows:
        """Return single rows, shape (k, number of columns); rows that are gone are left out.

        Reads only these: a few rows of a long run cost as much as those of a short one.
        """
        names, size = self._written_names(), self._row_bytes()
        if not indices or not self.telemetry_path.exists():
            return np.empty((0, len(self.columns)))
        with self.telemetry_path.open("rb", buffering=0) as file:
            read = (os.pread(file.fileno(), size, at * size) for at in indices)
            data = b"".join(row for row in read if len(row) == size)
        rows = np.frombuffer(data, "<f8").reshape(-1, len(names)).astype(np.float64, copy=False)
        return rows if names == self.columns else _in_current_columns(rows, names, self.columns)

    def rows_until(self, trial: int, t: float) -> int:
        """Return the number of rows up to time t [s] of a trial; trials are in ascending order."""
        return bisect_right(range(self.row_count()), (trial, t), key=self._trial_and_time)

    def rows_of_trial(self, trial: int) -> Rows:
        """Return the rows of one trial so far, shape (k, number of columns)."""
        first, after = (self.rows_until(number, -math.inf) for number in (trial, trial + 1))
        return self.rows(first, after)

    def _trial_and_time(self, at: int) -> tuple[int, float]:
        row = self.rows(at, at + 1)[0]
        return int(row[INDEX["trial"]]), float(row[INDEX["t"]])

    def log(self, after: int = 0, until: int | None = None) -> LogPart:
        """Return the output from byte `after` to before `until` as printable text.

        Without `until`, to the end. What was not kept is missing.
        """
        head = self._without_hidden(_bytes(self.folder / "log.txt"))
        kept = _bytes(self.folder / "log.tail")
        tail_start = int.from_bytes(kept[:_COUNT_BYTES], "little") if kept else len(head)
        tail = self._without_hidden(kept[_COUNT_BYTES:])
        after = max(after, 0)
        end = tail_start + len(tail) if until is None else min(until, tail_start + len(tail))
        gap = max(tail_start - max(after, len(head)), 0)
        text = head[after:end] + tail[max(after - tail_start, 0) : max(end - tail_start, 0)]
        shown = printable_text(text.decode("utf-8", "replace"))
        return LogPart(shown, end, gap)

    def log_length(self) -> int:
        """Return the length [byte] of the output so far, with what was not kept."""
        try:
            with (self.folder / "log.tail").open("rb") as file:
                start = int.from_bytes(file.read(_COUNT_BYTES), "little")
                return start + os.fstat(file.fileno()).st_size - _COUNT_BYTES
        except FileNotFoundError:
            pass
        try:
            return (self.folder / "log.txt").stat().st_size
        except FileNotFoundError:
            return 0

    def log_text(self) -> str:
        """Return the whole log as printable text; a line says how many bytes were not kept."""
        kept = self._without_hidden(_bytes(self.folder / "log.txt"))
        head = printable_text(kept.decode("utf-8", "replace"))
        rest = self.log(after=HEAD_MAX)
        gap = f"\n[... {rest.dropped} bytes were not kept ...]\n" if rest.dropped else ""
        return head + gap + rest.text

    def _without_hidden(self, output: bytes) -> bytes:
        """Return output of the same length: an offset may lie within what is hidden."""
        for name in map(str.encode, self.hidden):
            output = output.replace(name, b"*" * len(name))
        return output

    def manifest(self) -> dict[str, Any] | None:
        """Return the manifest, or None while there is none."""
        return _json(self.folder / "manifest.json")

    def metrics(self) -> dict[str, Any] | None:
        """Return the metrics, or None while there are none."""
        return _json(self.folder / "metrics.json")

    def _written_names(self) -> tuple[str, ...]:
        """Return the columns of the file; those of this version while there is no file."""
        if self._names is None:
            text = _bytes(self.folder / "columns.json")
            if not text:
                return telemetry.NAMES
            self._names = tuple(json.loads(text))
        return self._names

    def _row_bytes(self) -> int:
        return 8 * len(self._written_names())

    def _append(self, path: Path, data: bytes) -> None:
        """Append all of the data, or nothing if that fails."""
        with self._storing(path.name), path.open("ab", buffering=0) as file:
            before, left = file.tell(), memoryview(data)
            try:
                while left:  # a disk that gets full takes a part without an error
                    left = left[file.write(left) :]
            except OSError:
                file.truncate(before)
                raise

    def _replace(self, name: str, data: bytes) -> None:
        draft = self.folder / f".{name}.{secrets.token_hex(4)}"
        with self._storing(name):
            try:
                draft.write_bytes(data)
                os.replace(draft, self.folder / name)
            except OSError:
                draft.unlink(missing_ok=True)
                raise

    @contextmanager
    def _storing(self, name: str) -> Iterator[None]:
        """Make the folder before the first write; raise StorageFailed for what goes wrong."""
        try:
            if not self._made:
                # Not by `parents`: a data folder that is away must not be replaced by a new one.
                for folder in (self.data / "runs", self.root.parent, self.root, self.folder):
                    folder.mkdir(exist_ok=True)
                self._made = True
            yield
        except OSError as error:
            raise StorageFailed(f"{name}: {error.strerror}") from error


def _in_current_columns(rows: Rows, names: tuple[str, ...], columns: tuple[str, ...]) -> Rows:
    written = {name: at for at, name in enumerate(names)}
    moved = np.full((len(rows), len(columns)), np.nan)
    for at, name in enumerate(columns):
        if name in written:
            moved[:, at] = rows[:, written[name]]
    return moved


def _bytes(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except FileNotFoundError:
        return b""


def _json(path: Path) -> dict[str, Any] | None:
    text = _bytes(path)
    if not text:
        return None
    value: dict[str, Any] = json.loads(text)
    return value
