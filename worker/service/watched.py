"""What may wait for a storage, done beside the watch over a lease."""

import threading
from collections.abc import Callable
from concurrent.futures import Future, wait
from typing import TypeVar

LOOK_S = 0.1  # between two calls of the watch
T = TypeVar("T")


def watched(action: Callable[[], T], watch: Callable[[], None]) -> T:
    """Return what an action returns, or raise what it raises; call `watch` meanwhile.

    What `watch` raises ends the waiting at once. The action then goes on, unheard.
    """
    future = Future[T]()

    def act() -> None:
        try:
            future.set_result(action())
        except BaseException as error:
            future.set_exception(error)

    threading.Thread(target=act, name="watched", daemon=True).start()
    while not wait([future], LOOK_S).done:
        watch()
    return future.result()
