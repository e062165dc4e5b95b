"""Records of currents that settings can name: those shipped, and those of users.

A user's record is named by the start of its file's SHA-256, as in "record@0123456789abcdef", so
that no other can be taken for it. It is known in this process once its file was read, and a run's
manifest has the file itself.
"""

from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
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
FOLDER = Path(__file__).with_name("records")
SHIPPED = {path.stem: path for path in sorted(FOLDER.glob(f"*{SUFFIX}"))}


class RecordFile(NamedTuple):
    """What a manifest has of a user's own record."""

    sha256: str
    text: str


_FILES: dict[str, RecordFile] = {}
_RECORDS: dict[str, Record] = {}


def load(name: str) -> Record:
    """Return the record of that name.

    Raises
    ------
    LookupError
        None of that name is shipped, and none was added.
    """
    if name in _RECORDS:
        return _RECORDS[name]
    return _shipped(name)


@lru_cache(maxsize=8)
def _shipped(name: str) -> Record:
    if name not in SHIPPED:
        raise LookupError(f"there is no record {name}")
    return read_record(SHIPPED[name].read_bytes())


def is_known(name: object) -> bool:
    """Return whether `load` returns a record of this name now."""
    return isinstance(name, str) and (name in SHIPPED or name in _RECORDS)


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
    record, digest = read_record(content), sha256(content)
    name = _MARK + digest[:_HASH_DIGITS]
    _RECORDS[name], _FILES[name] = record, RecordFile(digest, content.decode("utf-8"))
    return name


def file_of(name: object) -> RecordFile | None:
    """Return the file of a record that was added; None for any other value."""
    return _FILES.get(name) if isinstance(name, str) else None


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
