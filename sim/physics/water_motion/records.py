"""Records of currents that settings can name: those shipped, and those of users.

A user's record is named by the start of its file's SHA-256, as in "record@0123456789abcdef", so
that no other can be taken for it. It is known in this process once its file was read, and a run's
manifest has the file itself. A process that serves many users adds none: it lends one for as long
as it works on a run with it.
"""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from functools import lru_cache
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

from seamark.sim.physics.water_motion.record import (
    BYTES_MAX,
    Record,
    RecordInvalid,
    read_record,
    sha256,
)

SETTING = "current_record"
SUFFIX = ".csv"
_MARK = "record@"
_HASH_DIGITS = 16
_KEPT = 4  # files of users, each of at most a few MB as numbers
FOLDER = Path(__file__).with_name("records")
SHIPPED = {path.stem: path for path in sorted(FOLDER.glob(f"*{SUFFIX}"))}


class RecordFile(NamedTuple):
    """What a manifest has of a user's own record."""

    sha256: str
    text: str


class OwnRecord(NamedTuple):
    """A user's record, and the name by which settings choose it."""

    name: str
    record: Record
    file: RecordFile


_ADDED: dict[str, OwnRecord] = {}
_LENT: ContextVar[Mapping[str, OwnRecord]] = ContextVar("_LENT", default=MappingProxyType({}))


def load(name: str) -> Record:
    """Return the record of that name.

    Raises
    ------
    LookupError
        None of that name is shipped, and none was added or is lent.
    """
    found = _own(name)
    return _shipped(name) if found is None else found.record


@lru_cache(maxsize=8)
def _shipped(name: str) -> Record:
    if name not in SHIPPED:
        raise LookupError(f"there is no record {name}")
    return read_record(SHIPPED[name].read_bytes())


def is_known(name: object) -> bool:
    """Return whether `load` returns a record of this name now."""
    return isinstance(name, str) and (name in SHIPPED or _own(name) is not None)


def is_own(name: object) -> bool:
    """Return whether a setting names a user's record, known here or not."""
    return isinstance(name, str) and name.startswith(_MARK)


def add(content: bytes) -> str:
    """Add a record to this process and return the name by which settings choose it.

    Raises
    ------
    RecordInvalid
        Its file breaks a rule.
    """
    found = _read(content)
    _ADDED[found.name] = found
    return found.name


@contextmanager
def lending(content: bytes) -> Iterator[str]:
    """Let this thread use a record meanwhile, and nothing else in this process.

    Raises
    ------
    RecordInvalid
        As `add`.
    """
    found = _read(content)
    before = _LENT.set({**_LENT.get(), found.name: found})
    try:
        yield found.name
    finally:
        _LENT.reset(before)


def name_of(content: bytes) -> str:
    """Return the name by which settings choose the record of a file."""
    return _MARK + sha256(content)[:_HASH_DIGITS]


def file_of(name: object) -> RecordFile | None:
    """Return the file of a record that was added or is lent; None for any other value."""
    found = _own(name) if isinstance(name, str) else None
    return None if found is None else found.file


def resolved(settings: Mapping[str, object]) -> dict[str, object]:
    """Return settings in which a record's file is replaced by the record's name, added.

    Raises
    ------
    RecordInvalid
        The file cannot be read, or breaks a rule.
    """
    chosen = settings.get(SETTING)
    if not isinstance(chosen, str | Path) or not str(chosen).endswith(SUFFIX):
        return dict(settings)
    try:
        with Path(chosen).open("rb") as file:
            content = file.read(BYTES_MAX + 1)
    except OSError as error:
        raise RecordInvalid(f"The file cannot be read: {error.strerror}.") from None
    return {**settings, SETTING: add(content)}


def _own(name: str) -> OwnRecord | None:
    return _LENT.get().get(name) or _ADDED.get(name)


@lru_cache(maxsize=_KEPT)
def _read(content: bytes) -> OwnRecord:
    record = read_record(content)
    return OwnRecord(name_of(content), record, RecordFile(sha256(content), content.decode("utf-8")))
