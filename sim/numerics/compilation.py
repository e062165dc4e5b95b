"""Tells when Numba compiles: a first run on a machine waits for it, a later one loads the code."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from numba.core import event


@contextmanager
def announced(on_compile: Callable[[int], None]) -> Iterator[None]:
    """Call `on_compile` whenever a function begins to be compiled, with how many that makes.

    Code that is loaded from the cache is not announced.
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
