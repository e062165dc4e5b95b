"""Compiled functions: called without a search for their types, and announced when they are made."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, Generic, ParamSpec, TypeVar

import numba
from numba.core import event

P = ParamSpec("P")
R = TypeVar("R")


class SameTypes(Generic[P, R]):
    """A compiled function that is called with arguments of the same types every time.

    Numba looks the types of all arguments up at every call, which takes a quarter of a microsecond
    for each named tuple, and a control step of a vehicle takes thirty. `call` does so at the first
    call alone. With an array of another type, dimension or layout a later one would crash, so this
    is for callers that make all arrays that they pass.
    """

    def __init__(self, compiled: Callable[P, R]) -> None:
        self._compiled = compiled
        self.call: Callable[P, R] = self._first

    def _first(self, *arguments: P.args, **_none: P.kwargs) -> R:
        dispatcher: Any = self._compiled
        type_of: Callable[[object], Any] = numba.typeof
        code: Callable[P, R] = dispatcher.compile(tuple(type_of(value) for value in arguments))
        self.call = code
        return code(*arguments, **_none)


@contextmanager
def announced(on_compile: Callable[[int], None]) -> Iterator[None]:
    """Call `on_compile` whenever a function begins to be compiled, with how many that makes.

    A first run on a machine waits for that; a later one loads the code, which is not announced.
    """
    count = 0

    def note(_: event.Event) -> None:
        nonlocal count
        count += 1
        on_compile(count)

    with event.install_listener("numba:compile", _Listener(note)):
        yield


class _Listener(event.Listener):
    def __init__(self, on_start: Callable[[event.Event], None]) -> None:
        self._on_start = on_start

    def on_start(self, event: event.Event) -> None:
        self._on_start(event)

    def on_end(self, event: event.Event) -> None:
        pass
