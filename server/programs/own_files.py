"""Files of users that settings name, lent to what is done for one run: vehicles and others.

A web process adds none to those that anybody can choose: a run has its own, by the SHA-256 of its
file in the store of programs, and only while something is done for that run is its name known.
"""

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from typing import Any, Protocol

from seamark.programs.preparation import UploadRejected
from seamark.server.programs import store, vehicles
from seamark.server.programs.vehicles import StoredVehicle, WithVehicle
from seamark.server.settings import Settings
from seamark.server.storage.storage import StorageUnavailable
from seamark.sim.files.library import FileInvalid
from seamark.sim.settings.own_files import INVALID, LIBRARIES, lending
from seamark.sim.vehicles import own

_MANIFEST = {"vehicle_file", *(one.entry for one in LIBRARIES.values())}  # have a whole file


class FileRejected(UploadRejected):
    """The file of a setting breaks a rule."""

    def __init__(self, sentence: str, *, field: str) -> None:
        super().__init__(sentence)
        self.field = field


class FileDeleted(FileNotFoundError):
    """The file of a setting was deleted with the data of its run."""

    def __init__(self, setting: str) -> None:
        super().__init__(f"The {LIBRARIES[setting].what} of this run has been deleted.")
        self.setting = setting


@dataclass(frozen=True, slots=True)
class StoredFile:
    """A file in the store that a setting names."""

    setting: str
    name: str  # the value of the setting
    sha256: str
    content: bytes = field(repr=False)


class FileOfRun(Protocol):
    """Which file a run has for a setting."""

    @property
    def setting(self) -> str: ...  # noqa: D102
    @property
    def sha256(self) -> str: ...  # noqa: D102


class WithFiles(WithVehicle, Protocol):
    """A run, as far as its files are concerned."""

    @property
    def files(self) -> Sequence[FileOfRun]: ...  # noqa: D102


def are_named(config: Mapping[str, object]) -> bool:
    """Return whether a setting names a file, other than that of a vehicle."""
    return any(library.is_own(config.get(name)) for name, library in LIBRARIES.items())


def save(setting: str, content: bytes, settings: Settings) -> StoredFile:
    """Put a file that `ProgramReader.read_file` has read into the store.

    Raises
    ------
    StorageUnavailable
        There is no room for it, or the data folder is away.
    """
    sha256 = store.save_content(content, settings)
    return StoredFile(setting, LIBRARIES[setting].name_of(content), sha256, content)


def stored(
    files: Mapping[str, str], config: Mapping[str, object], settings: Settings
) -> tuple[StoredFile, ...]:
    """Return stored files.

    Parameters
    ----------
    files
        Setting -> SHA-256.
    config
        Has the names of the files.

    Raises
    ------
    FileDeleted
    """
    found = []
    for setting, sha256 in files.items():
        try:
            content = store.read(settings, sha256)
        except FileNotFoundError:
            raise FileDeleted(setting) from None
        found.append(StoredFile(setting, str(config[setting]), sha256, content))
    return tuple(found)


def of_run(run: WithFiles, settings: Settings) -> tuple[StoredFile, ...]:
    """Return the files of a run but for its vehicle's, to be used again.

    Raises
    ------
    FileDeleted
        One was deleted with the data of the run.
    """
    for one in run.files:
        if store.touch(settings, one.sha256) is None:
            raise FileDeleted(one.setting)
    return stored({one.setting: one.sha256 for one in run.files}, run.config, settings)


@contextmanager
def lent(vehicle: StoredVehicle | None, files: Sequence[StoredFile] = ()) -> Iterator[None]:
    """Let what is done meanwhile know a vehicle and other files.

    Raises
    ------
    VehicleRejected, FileRejected
        One cannot be used.
    """
    with ExitStack() as stack:
        stack.enter_context(vehicles.lent(vehicle))
        for file in files:
            try:
                stack.enter_context(lending(file.setting, file.content))
            except FileInvalid as invalid:  # most likely accepted by an older version
                raise FileRejected(str(invalid), field=file.setting) from None
        yield


@contextmanager
def lent_to(settings: Settings, *runs: WithFiles) -> Iterator[None]:
    """Let what is done for these runs know their files, as far as they are there."""
    with ExitStack() as stack:
        for run in runs:
            for setting, content in contents_of(run, settings).items():
                try:
                    stack.enter_context(lending(setting, content))
                except INVALID:  # most likely accepted by an older version
                    continue
        yield


def contents_of(run: WithFiles, settings: Settings) -> dict[str, bytes]:
    """Return setting -> file of those of a run's own that are there now."""
    found = {one.setting: one.sha256 for one in run.files}
    if run.vehicle_sha256 is not None:
        found[own.SETTING] = run.vehicle_sha256
    contents = {setting: _content(sha256, settings) for setting, sha256 in found.items()}
    return {setting: content for setting, content in contents.items() if content is not None}


def without_texts(manifest: Mapping[str, Any]) -> dict[str, Any]:
    """Return a manifest for the database: the store has the files themselves."""
    return {**manifest, **{name: _short(manifest[name]) for name in _MANIFEST & manifest.keys()}}


def with_texts(manifest: dict[str, Any], run: WithFiles, settings: Settings) -> dict[str, Any]:
    """Return a manifest of the database as it was, but for files that were deleted since."""
    contents = {
        hashlib.sha256(content).hexdigest(): content
        for content in contents_of(run, settings).values()
    }
    whole = {
        name: {**manifest[name], "text": contents[manifest[name]["sha256"]].decode("utf-8")}
        for name in _MANIFEST & manifest.keys()
        if manifest[name]["sha256"] in contents
    }
    return {**manifest, **whole}


def _short(entry: Mapping[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in entry.items() if key != "text"}


def _content(sha256: str, settings: Settings) -> bytes | None:
    try:
        content = store.read(settings, sha256)
    except (FileNotFoundError, StorageUnavailable):
        return None
    return content if hashlib.sha256(content).hexdigest() == sha256 else None
