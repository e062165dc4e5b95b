"""The files of users that one setting can name, each by the start of its SHA-256.

A name such as "record@0123456789abcdef" cannot be taken for another file. It is known in this
process once its file was read, and a run's manifest has the file itself. A process that serves many
users adds none: it lends one for as long as it works on a run with it.
"""

import hashlib
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from functools import lru_cache
from pathlib import Path
from types import MappingProxyType
from typing import Generic, NamedTuple, TypeVar

_HASH_DIGITS = 16
_KEPT = 4  # of the files read last, of which each takes at most a few MB
T = TypeVar("T")


def name_digits(content: bytes) -> str:
    """Return the end of the name of a file: the start of its SHA-256."""
    return hashlib.sha256(content).hexdigest()[:_HASH_DIGITS]


class FileInvalid(ValueError):
    """A file of a user's breaks a rule. Its text is written for the user."""


class TextFile(NamedTuple):
    """What a manifest has of a file."""

    sha256: str
    text: str


class _Known(NamedTuple, Generic[T]):
    name: str
    value: T
    file: TextFile


class Library(Generic[T]):
    """The files of one setting.

    Parameters
    ----------
    setting
        That can name one.
    what
        A file of them is, such as "record of currents".
    mark
        First part of the names.
    entry
        Of a manifest, that has the file.
    suffixes
        By which a setting's value is the path of a file, in lower case.
    bytes_max
        Most that is read of such a file.
    read
        Returns what is in a file, which is text; raises FileInvalid.
    converted
        Returns a file for `read`, from a file that a user has; raises FileInvalid. None: they are
        the same.
    """

    def __init__(
        self,
        *,
        setting: str,
        what: str,
        mark: str,
        entry: str,
        suffixes: tuple[str, ...],
        bytes_max: int,
        read: Callable[[bytes], T],
        converted: Callable[[bytes], bytes] | None = None,
    ) -> None:
        self.setting, self.what, self.entry = setting, what, entry
        self.suffixes, self.bytes_max = suffixes, bytes_max
        self._mark, self._converted = f"{mark}@", converted
        self._read_file = read
        self._read = lru_cache(maxsize=_KEPT)(self._known)
        self._added = dict[str, _Known[T]]()
        self._lent: ContextVar[Mapping[str, _Known[T]]] = ContextVar(
            mark, default=MappingProxyType({})
        )

    def add(self, content: bytes) -> str:
        """Add a file to this process and return the name by which the setting chooses it.

        Raises
        ------
        FileInvalid
            It breaks a rule.
        """
        found = self._read(content)
        self._added[found.name] = found
        return found.name

    @contextmanager
    def lending(self, content: bytes) -> Iterator[str]:
        """Let this thread use a file meanwhile, and nothing else in this process.

        Raises
        ------
        FileInvalid
            As `add`.
        """
        found = self._read(content)
        before = self._lent.set({**self._lent.get(), found.name: found})
        try:
            yield found.name
        finally:
            self._lent.reset(before)

    def converted(self, content: bytes) -> bytes:
        """Return the file to keep of one that a user has.

        Raises
        ------
        FileInvalid
            None can be made of it, or it breaks a rule.
        """
        if len(content) > self.bytes_max:
            raise FileInvalid(f"The file may have at most {self.bytes_max / 2**20:.3g} MiB.")
        kept = content if self._converted is None else self._converted(content)
        self._read(kept)
        return kept

    def name_of(self, content: bytes) -> str:
        """Return the name by which the setting chooses a file."""
        return self._mark + name_digits(content)

    def is_own(self, name: object) -> bool:
        """Return whether a value of the setting names a file, known here or not."""
        return isinstance(name, str) and name.startswith(self._mark)

    def is_path(self, value: object) -> bool:
        """Return whether a value of the setting is the path of a file that can be read."""
        return isinstance(value, str | Path) and str(value).lower().endswith(self.suffixes)

    def is_meant(self, value: object) -> bool:
        """Return whether a value of the setting is the path or the name of a file."""
        return self.is_path(value) or self.is_own(value)

    def is_known(self, name: object) -> bool:
        """Return whether a value of the setting names a file that was added or is lent."""
        return isinstance(name, str) and self._find(name) is not None

    def get(self, name: str) -> T | None:
        """Return what is in a file that was added or is lent; None if there is no such."""
        found = self._find(name)
        return None if found is None else found.value

    def file_of(self, name: object) -> TextFile | None:
        """Return a file that was added or is lent; None for any other value."""
        found = self._find(name) if isinstance(name, str) else None
        return None if found is None else found.file

    def resolved(self, settings: Mapping[str, object]) -> dict[str, object]:
        """Return settings in which the path of a file is replaced by the file's name, added.

        Raises
        ------
        FileInvalid
            The file cannot be read, or breaks a rule.
        """
        chosen = settings.get(self.setting)
        if not isinstance(chosen, str | Path) or not self.is_path(chosen):
            return dict(settings)
        try:
            with Path(chosen).open("rb") as file:
                content = self.converted(file.read(self.bytes_max + 1))
        except OSError as error:
            reason = f"The file cannot be read: {error.strerror}."
            raise FileInvalid(f"{chosen}: {reason}") from None
        except FileInvalid as invalid:
            raise FileInvalid(f"{chosen}: {invalid}") from None
        return {**settings, self.setting: self.add(content)}

    def _find(self, name: str) -> _Known[T] | None:
        return self._lent.get().get(name) or self._added.get(name)

    def _known(self, content: bytes) -> _Known[T]:
        value = self._read_file(content)
        file = TextFile(hashlib.sha256(content).hexdigest(), content.decode("utf-8"))
        return _Known(self.name_of(content), value, file)
