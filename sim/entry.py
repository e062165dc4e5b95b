"""A name that a form offers, and where its code is."""

import importlib
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, slots=True)
class Entry:
    """A label for people and a dotted path, module:attribute, for the computer."""

    label: str
    path: str

    def load(self) -> Any:  # a class, a function or a data object
        """Return what the path names.

        Raises
        ------
        ImportError, AttributeError
            If the path names nothing: the registry is wrong.
        """
        module, _, attribute = self.path.partition(":")
        return getattr(importlib.import_module(module), attribute)


@dataclass(frozen=True, slots=True)
class TrackerEntry(Entry):
    """A tracker: also which settings it has, and what is to be said of it."""

    options: tuple[str, ...] = ()  # names of settings in sim/settings/tracker.py
    exact: bool = True  # whether every processor of x86-64 gives the same bits
