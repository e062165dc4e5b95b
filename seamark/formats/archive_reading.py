"""Reads the archive of a run, which may come from anybody: nothing is unpacked onto the disk.

Files are read by their names, up to a limit for each, and only in the two ways of compression that
need little memory. The rows are read a block at a time.
"""

from __future__ import annotations

import io
import json
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from seamark.formats import csv_file
from seamark.formats.archive import (
    CONFIG,
    MANIFEST,
    METRICS,
    PARTS,
    PROGRAM,
    TELEMETRY,
    why_not_again,
)
from seamark.formats.csv_file import NotTelemetry
from seamark.formats.recording import Program
from seamark.sim.engine.seeds import SEED_BITS
from seamark.sim.recording.telemetry import Rows

FILES_MAX = 100  # in an archive
DIRECTORY_BYTES = 64 * 1024  # of the list of them, which is read at once
DOCUMENT_BYTES = 16 * 2**20  # of a JSON document
PROGRAM_BYTES = 64 * 2**20
OWN_FILE_CHARACTERS = 2**21  # the largest, a record of currents, has 2 MB
LINE_CHARACTERS = 16384  # of a row: 100 columns take an eighth
TRIALS_MAX = 100
_METHODS = {zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED}
Seed = Annotated[int, Field(ge=0, lt=2**SEED_BITS)]
Role = Annotated[str, Field(pattern="^(tracker|detector)$")]
Sha256 = Annotated[str, Field(pattern="^[0-9a-f]{64}$")]


class ArchiveRefused(Exception):
    """It is not the archive of a run that can be computed again. The text is for the user."""


class OwnFile(BaseModel):
    """A file of the user's own that a setting names, and its SHA-256."""

    model_config = ConfigDict(extra="ignore", strict=True, frozen=True)

    sha256: Sha256
    text: str = Field(max_length=OWN_FILE_CHARACTERS)


class Manifest(BaseModel):
    """What of a manifest decides a result, or tells why another one came out."""

    model_config = ConfigDict(extra="ignore", strict=True, frozen=True)

    benchmark: str = Field(max_length=100)
    configuration: dict[str, Any]
    parameters: dict[str, Any] = Field(default_factory=dict)  # of the program
    seed: Seed | None
    seeds: Annotated[list[Seed], Field(max_length=TRIALS_MAX)] | None = None
    trials: int = Field(ge=1, le=TRIALS_MAX)
    controller: str = Field(max_length=200)
    program_sha256: Sha256 | None
    parts: dict[Role, Sha256] = Field(default_factory=dict)  # further programs
    digest: Sha256
    code_sha256: Sha256
    versions: dict[str, str]
    contacts: str = Field(max_length=100)
    cpu: dict[str, str] = Field(default_factory=dict)
    same_bits_on_every_cpu: bool = True
    vehicle_file: OwnFile | None = None
    current_file: OwnFile | None = None
    target_file: OwnFile | None = None

    def trial_seeds(self) -> tuple[int, ...]:
        """Return the seed of each trial; raises ArchiveRefused if they are hidden."""
        if self.seed is not None:
            return (self.seed,) * self.trials
        if self.seeds is None:
            raise ArchiveRefused(
                "The seeds of this ranked run are hidden, because other runs have the same ones: "
                "it cannot be computed again elsewhere."
            )
        if len(self.seeds) != self.trials:
            raise ArchiveRefused(
                f"{MANIFEST} has {len(self.seeds)} seeds for {self.trials} trials."
            )
        return tuple(self.seeds)


@dataclass(frozen=True, slots=True)
class ArchivedRun:
    """What an archive says about a run."""

    manifest: Manifest
    config: dict[str, Any]  # with the parameters of the program
    metrics: dict[str, Any] | None
    program: Program | None
    parts: dict[str, Program]  # role -> further program, as far as the archive has it
    _archive: zipfile.ZipFile
    _root: str

    def rows(self) -> Iterator[tuple[tuple[str, ...], Rows]]:
        """Yield the names of the columns with each block of rows; raises ArchiveRefused."""
        archive, name = self._archive, self._root + TELEMETRY
        with _failures_told(TELEMETRY), archive.open(_info(archive, name)) as file:
            lines = _lines(io.TextIOWrapper(file, "utf-8"))
            names = csv_file.read_names(lines)
            for block in csv_file.read_blocks(lines, len(names)):
                yield names, block


class _Bounded(io.FileIO):
    """A file that refuses to be read too much at once: zipfile believes what an archive claims."""

    read_max: int | None = DIRECTORY_BYTES

    def read(self, size: int | None = -1, /) -> bytes:
        """Return the next bytes."""
        if self.read_max is not None and size is not None and size > self.read_max:
            raise zipfile.BadZipFile("its list of files is too long")
        return super().read(-1 if size is None else size) or b""


@contextmanager
def opened(path: Path) -> Iterator[ArchivedRun]:
    """Provide the run in an archive.

    Raises
    ------
    ArchiveRefused
        It cannot be read, or has no run that can be computed again.
    """
    with _failures_told(path.name), _Bounded(path) as file, zipfile.ZipFile(file) as archive:
        file.read_max = None
        if len(archive.infolist()) > FILES_MAX:
            raise ArchiveRefused(f"{path.name} has more than {FILES_MAX} files.")
        root = _root(archive, path)
        manifest = _manifest(archive, root)
        if why_not := why_not_again(manifest.model_dump()):
            raise ArchiveRefused(why_not)
        yield ArchivedRun(
            manifest,
            _object(archive, root + CONFIG),
            _object(archive, root + METRICS) if root + METRICS in archive.namelist() else None,
            _program(archive, root, PROGRAM),
            _parts(archive, root, manifest),
            archive,
            root,
        )


def _root(archive: zipfile.ZipFile, path: Path) -> str:
    """Return the folder in the archive that has the manifest, "" or with a slash at its end."""
    manifests = [name for name in archive.namelist() if PurePosixPath(name).name == MANIFEST]
    if len(manifests) != 1 or manifests[0].count("/") > 1:
        raise ArchiveRefused(
            f"{path.name} has no {MANIFEST}: it is not the archive of a run that has ended."
        )
    return manifests[0].removesuffix(MANIFEST)


def _manifest(archive: zipfile.ZipFile, root: str) -> Manifest:
    try:
        return Manifest.model_validate(_object(archive, root + MANIFEST))
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"]))
        raise ArchiveRefused(f"{MANIFEST}: {where}: {first['msg']}.") from None


def _parts(archive: zipfile.ZipFile, root: str, manifest: Manifest) -> dict[str, Program]:
    found = {role: _program(archive, root, f"{PARTS}/{role}") for role in manifest.parts}
    return {role: program for role, program in found.items() if program is not None}


def _program(archive: zipfile.ZipFile, root: str, where: str) -> Program | None:
    folder = f"{root}{where}/"
    names = [name for name in archive.namelist() if name.startswith(folder) and name != folder]
    if not names:
        return None
    if len(names) > 1:
        raise ArchiveRefused(f"{where}/ has {len(names)} files instead of one.")
    content = _read(archive, names[0], PROGRAM_BYTES)
    return Program(PurePosixPath(names[0]).name, content)


def _object(archive: zipfile.ZipFile, name: str) -> dict[str, Any]:
    text = _read(archive, name, DOCUMENT_BYTES)
    try:
        value = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise ArchiveRefused(f"{name} is not JSON ({error}).") from None
    if not isinstance(value, dict):
        raise ArchiveRefused(f"{name} is not a JSON object.")
    return value


def _read(archive: zipfile.ZipFile, name: str, limit: int) -> bytes:
    """Return a file, whatever size the archive claims for it."""
    with archive.open(_info(archive, name)) as file:
        content = file.read(limit + 1)
    if len(content) > limit:
        raise ArchiveRefused(f"{name} is larger than {limit >> 20} MiB.")
    return content


def _info(archive: zipfile.ZipFile, name: str) -> zipfile.ZipInfo:
    try:
        info = archive.getinfo(name)
    except KeyError:
        raise ArchiveRefused(f"{name} is missing.") from None
    if info.compress_type not in _METHODS:
        raise ArchiveRefused(f"{name} is compressed in a way that archives of runs are not.")
    return info


def _lines(text: io.TextIOWrapper) -> Iterator[str]:
    while line := text.readline(LINE_CHARACTERS):
        if len(line) == LINE_CHARACTERS:
            raise NotTelemetry("a line is too long")
        yield line


@contextmanager
def _failures_told(name: str) -> Iterator[None]:
    """Raise ArchiveRefused for what the libraries raise."""
    try:
        yield
    except (zipfile.BadZipFile, zlib.error, RuntimeError, EOFError, OSError) as error:
        raise ArchiveRefused(f"{name} cannot be read: {error}.") from None
    except (NotTelemetry, UnicodeDecodeError) as error:
        raise ArchiveRefused(f"{name} is not a table of telemetry: {error}.") from None
