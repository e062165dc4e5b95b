"""Pre-started boxes, so that the first answer does not wait for an interpreter to start.

Each box is used once. The stock is refilled only when its owner calls `refill`, between runs, while
nobody waits for an answer. Starting a box takes a few milliseconds of our time; it warms up alone.

The owner leases boxes to processes that it forks (`lease`) and keeps the rest.
"""

import contextlib
import os
import time
from collections.abc import Mapping
from types import TracebackType
from typing import NamedTuple, Self

from seamark.sandbox.box import Box
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.languages import LANGUAGES
from seamark.sandbox.limits import Limits
from seamark.sandbox.outcome import SandboxBroken

MAX_AGE_S = 600.0  # [s] an unused box is replaced after this time


class IdleBox(NamedTuple):
    """A box in stock."""

    box: Box
    since_s: float  # monotonic


class Pool:
    """Boxes of one thread and its forks. The thread has to live as long as they do."""

    def __init__(
        self,
        stock: Mapping[str, int],
        *,
        limits: Limits,
        isolation: IsolationLevel,
        core: int | None = None,
        max_age_s: float = MAX_AGE_S,
    ) -> None:
        """Start nothing yet.

        Parameters
        ----------
        stock
            Language -> number of idle boxes. Languages with the same runtime share them.
        limits
            Limits of the boxes in stock. Whoever takes one may have other time limits, but not
            more CPU time.
        """
        self._stock = {stock_key(language): count for language, count in stock.items()}
        self._limits = limits
        self._isolation = isolation
        self._core = core
        self._max_age_s = max_age_s
        self._idle: dict[str, list[IdleBox]] = {language: [] for language in self._stock}

    def refill(self) -> None:
        """Start the boxes that are missing, replace those that are too old; wait for neither.

        A box that fails to start is left out: `take` then raises the reason.
        """
        for language, count in self._stock.items():
            idle = self._idle[language]
            old = [one for one in idle if time.monotonic() - one.since_s >= self._max_age_s]
            for one in old:
                idle.remove(one)
                _discard(one.box)
            with contextlib.suppress(SandboxBroken):
                while len(idle) < count:
                    idle.append(IdleBox(self._new(language, self._limits), time.monotonic()))

    def take(self, language: str, limits: Limits) -> Box:
        """Return a box, from the stock or new, which the caller owns from now on."""
        idle = self._idle.get(stock_key(language), [])
        while idle and limits.fit(self._limits):
            box = idle.pop(0).box  # the oldest one is the most likely to be warm
            if _is_ready(box):
                box.assign(limits, language)
                box.set_affinity(os.sched_getaffinity(0))
                return box
            _discard(box)
        return self._new(language, limits)

    def stock(self, language: str, count: int) -> None:
        """Set how many boxes of a language are kept, from the next `refill` on."""
        self._stock[stock_key(language)] = count
        self._idle.setdefault(stock_key(language), [])

    def lease(self, language: str, count: int) -> "BoxLease":
        """Reserve up to `count` boxes of the stock for the process that is forked next."""
        key = stock_key(language)
        idle = self._idle.get(key, [])
        leased, self._idle[key] = idle[:count], idle[count:]
        for one in leased:
            one.box.wait_killable()
        return BoxLease(self, key, leased)

    def take_over(self, language: str, leased: list[IdleBox]) -> None:
        """In a fork, on the fork's cores: hold only these boxes, and never start others."""
        for one in (one for idle in self._idle.values() for one in idle):
            one.box.detach()
        self._stock, self._idle, self._core = {}, {language: leased}, None

    def close(self) -> None:
        """Close all boxes in stock."""
        for idle in self._idle.values():
            while idle:
                _discard(idle.pop().box)

    def __enter__(self) -> Self:
        """Return the pool itself."""
        return self

    def __exit__(
        self,
        error_type: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Close the pool."""
        self.close()

    def _new(self, language: str, limits: Limits) -> Box:
        return Box(language, limits=limits, isolation=self._isolation, core=self._core)


def stock_key(language: str) -> str:
    """Return the first language with the same runtime: until a program arrives, they are alike."""
    runtime = LANGUAGES[language].runtime
    return next(name for name, other in LANGUAGES.items() if other.runtime is runtime)


class BoxLease:
    """Boxes for one fork. The parent calls `hand_over` after forking, `close` when it has ended."""

    def __init__(self, pool: Pool, language: str, leased: list[IdleBox]) -> None:
        self._pool, self._language, self._leased = pool, language, leased

    def take_over(self) -> None:
        """In the fork: have these boxes in stock, and detach from all others of the pool."""
        self._pool.take_over(self._language, list(self._leased))

    def hand_over(self) -> None:
        """In the parent: leave the communication with the programs to the fork."""
        for one in self._leased:
            one.box.hand_over()

    def close(self) -> None:
        """Kill what the fork left, and reap; SandboxBroken if anything survives."""
        while self._leased:
            self._leased.pop().box.close()


def _is_ready(box: Box) -> bool:
    """Return whether a box is up, and has not died since."""
    try:
        box.wait_ready()
    except SandboxBroken:
        return False
    return box.is_alive()


def _discard(box: Box) -> None:
    """Close a box that ran no program: a failure concerns nobody."""
    with contextlib.suppress(SandboxBroken):
        box.close()
