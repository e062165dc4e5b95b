"""Boxes that were started before anybody knew what runs in them: the first answer comes at once.

Each is used once. Stock is refilled only when its owner says so, which is when nobody waits for an
answer: between runs. Starting a box takes a few milliseconds of ours; it warms up by itself.

The owner lends boxes to processes that it forks, by the word `lend`, and keeps the rest.
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

OLDEST_S = 600.0  # [s] then a box that nobody needed is replaced by a new one


class Waiting(NamedTuple):
    """A box in stock."""

    box: Box
    since_s: float  # monotonic


class Pool:
    """Boxes of one thread and of its forks. The thread has to live as long as they do."""

    def __init__(
        self,
        stock: Mapping[str, int],
        *,
        limits: Limits,
        isolation: IsolationLevel,
        core: int | None = None,
        oldest_s: float = OLDEST_S,
    ) -> None:
        """Start nothing yet.

        Parameters
        ----------
        stock
            Language -> how many boxes wait. Languages that start alike share them.
        limits
            Of the boxes in stock. Whoever takes one may have shorter and longer times, but not
            more CPU time.
        """
        self._stock = {kind(language): count for language, count in stock.items()}
        self._limits = limits
        self._isolation = isolation
        self._core = core
        self._oldest_s = oldest_s
        self._waiting: dict[str, list[Waiting]] = {language: [] for language in self._stock}

    def refill(self) -> None:
        """Start what is missing in stock, and replace what is too old; waits for none of it.

        What cannot be started is missing: whoever takes a box then hears why.
        """
        for language, count in self._stock.items():
            waiting = self._waiting[language]
            old = [one for one in waiting if time.monotonic() - one.since_s >= self._oldest_s]
            for one in old:
                waiting.remove(one)
                _end(one.box)
            with contextlib.suppress(SandboxBroken):
                while len(waiting) < count:
                    waiting.append(Waiting(self._new(language, self._limits), time.monotonic()))

    def take(self, language: str, limits: Limits) -> Box:
        """Return a box that is the caller's from now on: from the stock, or a new one."""
        waiting = self._waiting.get(kind(language), [])
        while waiting and limits.fit(self._limits):
            box = waiting.pop(0).box  # the oldest: it is warm most likely
            if _is_ready(box):
                box.adopt(limits, language)
                box.move(os.sched_getaffinity(0))
                return box
            _end(box)
        return self._new(language, limits)

    def stock(self, language: str, count: int) -> None:
        """Keep so many boxes of a language from the next `refill` on."""
        self._stock[kind(language)] = count
        self._waiting.setdefault(kind(language), [])

    def lend(self, language: str, most: int) -> "Loan":
        """Set boxes of the stock apart for a process that is forked next."""
        waiting = self._waiting.get(kind(language), [])
        lent, self._waiting[kind(language)] = waiting[:most], waiting[most:]
        for one in lent:
            one.box.wait_known()
        return Loan(self, kind(language), lent)

    def keep(self, language: str, lent: list[Waiting]) -> None:
        """Be the pool of a fork, on its cores: these boxes alone wait, and no others are made."""
        for one in (one for waiting in self._waiting.values() for one in waiting):
            one.box.forget()
        self._stock, self._waiting, self._core = {}, {language: lent}, None

    def waiting(self) -> int:
        """Return how many boxes are in stock."""
        return sum(map(len, self._waiting.values()))

    def close(self) -> None:
        """End all boxes in stock."""
        for waiting in self._waiting.values():
            while waiting:
                _end(waiting.pop().box)

    def __enter__(self) -> Self:
        """Return the pool itself."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Close the pool."""
        self.close()

    def _new(self, language: str, limits: Limits) -> Box:
        return Box(language, limits=limits, isolation=self._isolation, core=self._core)


def kind(language: str) -> str:
    """Return the first language whose boxes start as those of this one, before their program."""
    runtime = LANGUAGES[language].runtime
    return next(name for name, other in LANGUAGES.items() if other.runtime is runtime)


class Loan:
    """Boxes for one fork. The maker says `leave` right after it, and `close` when it has ended."""

    def __init__(self, pool: Pool, language: str, lent: list[Waiting]) -> None:
        self._pool, self._language, self._lent = pool, language, lent

    def use(self) -> None:
        """In the fork: have these boxes in stock, and forget the pool's others."""
        self._pool.keep(self._language, list(self._lent))

    def leave(self) -> None:
        """Leave the talking to the fork."""
        for one in self._lent:
            one.box.leave()

    def close(self) -> None:
        """End what the fork could not end, and reap; SandboxBroken if anything survives."""
        while self._lent:
            self._lent.pop().box.close()


def _is_ready(box: Box) -> bool:
    """Tell whether a box is up, which it may have been and died."""
    try:
        box.wait_ready()
    except SandboxBroken:
        return False
    return box.lives()


def _end(box: Box) -> None:
    """End a box that nobody used: nothing ran in it, so nobody needs to hear how it went."""
    with contextlib.suppress(SandboxBroken):
        box.close()
