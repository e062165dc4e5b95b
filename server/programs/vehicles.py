"""Vehicles that users upload: files in the store of programs.

`own_files` lends them to what is done for one run.
"""

from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from typing import Any, Protocol, Self

from seamark.server.programs import store
from seamark.server.settings import Settings
from seamark.sim.vehicles import own
from seamark.sim.vehicles.reading import VehicleInvalid
from seamark.sim.vehicles.toml_reading import BYTES_MAX

FIELD = own.SETTING  # part of a form with the file
_SHOWN_MAX = 3  # errors at a field


class VehicleRejected(Exception):
    """The file is no vehicle that can run. Its text is for the user, `errors` by sentence."""

    def __init__(self, *errors: str) -> None:
        super().__init__(" ".join(errors))
        self.errors = errors

    @property
    def shortened(self) -> str:
        """The first errors, as much as is read at a field of a form."""
        more = len(self.errors) - _SHOWN_MAX
        rest = [f"{more} more: `seamark vehicle check` lists them."] if more > 0 else []
        return " ".join([*self.errors[:_SHOWN_MAX], *rest])


class VehicleTooLarge(VehicleRejected):
    """The file is larger than a vehicle may be."""


@dataclass(frozen=True, slots=True)
class VehicleReport:
    """What `seamark vehicle check` says about a file.

    Attributes
    ----------
    name
        By which settings choose it; empty if it cannot be read.
    figures
        What follows from the numbers, line by line; none if there are errors.
    defaults
        Settings that come with it where a benchmark has them.
    """

    name: str = ""
    title: str = ""
    errors: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    figures: tuple[str, ...] = ()
    defaults: Mapping[str, Any] = field(default_factory=dict)

    @classmethod
    def from_json(cls, values: Mapping[str, Any]) -> Self:
        """Return the report of the process that reads uploads."""
        lists = {key: tuple(value) for key, value in values.items() if isinstance(value, list)}
        return cls(**{**values, **lists})

    def require_usable(self) -> None:
        """Raise VehicleRejected with all errors, if there are any."""
        if self.errors:
            raise VehicleRejected(*self.errors)


@dataclass(frozen=True, slots=True)
class StoredVehicle:
    """A vehicle in the store, which can run."""

    name: str  # by which settings choose it
    sha256: str
    content: bytes = field(repr=False)


class WithVehicle(Protocol):
    """A run, as far as its vehicle is concerned."""

    @property
    def config(self) -> dict[str, Any]: ...  # noqa: D102
    @property
    def vehicle_sha256(self) -> str | None: ...  # noqa: D102


def save(name: str, content: bytes, settings: Settings) -> StoredVehicle:
    """Put a file that `ProgramReader.read_vehicle` has read into the store.

    Raises
    ------
    StorageUnavailable
        There is no room for it, or the data folder is away.
    """
    return StoredVehicle(name, store.save_content(content, settings), content)


def of_run(run: WithVehicle, settings: Settings) -> StoredVehicle | None:
    """Return the vehicle of a run, to be used again; None if it has one of ours.

    Raises
    ------
    FileNotFoundError
        It was deleted with the data of the run.
    """
    if run.vehicle_sha256 is None:
        return None
    if store.touch(settings, run.vehicle_sha256) is None:
        raise FileNotFoundError(run.vehicle_sha256)
    return stored(str(run.config[own.SETTING]), run.vehicle_sha256, settings)


def stored(name: str, sha256: str, settings: Settings) -> StoredVehicle:
    """Return a stored vehicle; raises FileNotFoundError if it was deleted."""
    return StoredVehicle(name, sha256, store.read(settings, sha256))


@contextmanager
def lent(vehicle: StoredVehicle | None) -> Iterator[None]:
    """Let what is done meanwhile know a vehicle; raises VehicleRejected if it cannot run."""
    with ExitStack() as stack:
        if vehicle is not None:
            try:
                stack.enter_context(own.lending(vehicle.content))
            except VehicleInvalid as invalid:  # most likely accepted by an older version
                raise VehicleRejected(*invalid.errors) from None
        yield


def refuse_large(size: int) -> None:
    """Raise VehicleTooLarge for a file [byte] of which not all would be read."""
    if size > BYTES_MAX:
        raise VehicleTooLarge(f"The file of a vehicle has at most {BYTES_MAX >> 10} KiB.")
