"""Recording demonstrations, several at a time; which ones are kept does not depend on how many."""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from dataclasses import dataclass
from types import TracebackType
from typing import Any, Self

from seamark.demonstrations.episodes import Attempt, Outcome, Task, demonstrate
from seamark.demonstrations.layouts import Layout
from seamark.demonstrations.spool import Spool
from seamark.sim import registry
from seamark.worker.ipc.process_control import die_with_parent

MOST_ATTEMPTS = 20  # for each episode that is wanted
_AHEAD = 2  # attempts in the queue, for each process


class TooFewSuccesses(Exception):
    """The expert hardly ever succeeds; the text is for the user."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """Which episodes are recorded: attempts in their order, the levels in turn.

    The seed of the benchmark's reference trials is left out. Those of fresh trials have 63 bits and
    follow from a secret.
    """

    task: Task
    first_seed: int
    levels: int
    episodes: int
    only_successes: bool

    def attempts(self) -> Iterator[Attempt]:
        """Yield all attempts that may be made."""
        protocol = registry.benchmark(self.task.benchmark).protocol
        reference = protocol.reference_seed if protocol else None
        seed = self.first_seed
        for number in range(self.episodes * (MOST_ATTEMPTS if self.only_successes else 1)):
            if seed == reference:
                seed += 1
            yield Attempt(number=number, seed=seed, level=number % self.levels)
            seed += 1

    def keeps(self, outcome: Outcome) -> bool:
        """Return whether an episode becomes part of the set."""
        return outcome.success or not self.only_successes


class Recording:
    """Processes that record; a context manager.

    They are forks that share compiled code, so enter before anything else has threads.
    """

    def __init__(self, plan: Plan, spool: Spool, layout: Layout, *, workers: int) -> None:
        self._plan, self._spool, self._layout, self._workers = plan, spool, layout, workers
        self._pool = ProcessPoolExecutor(
            workers,
            mp_context=multiprocessing.get_context("fork"),
            initializer=_be_a_worker,
            initargs=(os.getpid(),),
        )

    def __enter__(self) -> Self:
        """Start the processes."""
        from seamark.sim.engine.warm_up import warm_up_benchmark

        warm_up_benchmark(self._plan.task.benchmark)
        self._pool.submit(os.getpid).result()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """End the processes; attempts that are running are given up."""
        self._pool.shutdown(wait=False, cancel_futures=True)
        for process in multiprocessing.active_children():
            process.terminate()
            process.join()
        self._pool.shutdown()

    def run(self, on_outcome: Callable[[Outcome, int], None]) -> list[Outcome]:
        """Record until there are enough episodes, and return what came of those that are kept.

        Parameters
        ----------
        on_outcome
            Is called with each outcome, in order, and how many have been kept.

        Raises
        ------
        TooFewSuccesses
            Only successes are kept, and there are too few.
        """
        kept: list[Outcome] = []
        attempts = 0
        for outcome in self._outcomes():
            attempts = outcome.number + 1
            if self._plan.keeps(outcome):
                kept.append(outcome)
            on_outcome(outcome, len(kept))
            if len(kept) == self._plan.episodes:
                return kept
        raise TooFewSuccesses(
            f"The expert {self._plan.task.expert} succeeded in {len(kept)} of {attempts} attempts. "
            "Choose weaker currents, such as --set levels=0,0.1, or another --expert."
        )

    def _outcomes(self) -> Iterator[Outcome]:
        """Yield the outcomes of all attempts in their order; those on the disk at once."""
        attempts = self._plan.attempts()
        waiting: deque[Outcome | Future[Outcome]] = deque()
        for attempt in attempts:
            waiting.append(self._spool.outcome(attempt.number) or self._submit(attempt))
            if len(waiting) > _AHEAD * self._workers:
                yield _result(waiting.popleft())
        while waiting:
            yield _result(waiting.popleft())

    def _submit(self, attempt: Attempt) -> Future[Outcome]:
        return self._pool.submit(_record, self._plan, attempt, self._spool, self._layout)


def _result(outcome: Outcome | Future[Outcome]) -> Outcome:
    return outcome if isinstance(outcome, Outcome) else outcome.result()


def _be_a_worker(parent: int) -> None:
    """Prepare a process of the pool: Ctrl-C is for the parent, which then ends this one."""
    die_with_parent(parent)
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _record(plan: Plan, attempt: Attempt, spool: Spool, layout: Layout) -> Outcome:
    """Make an attempt and store what came of it."""
    done = demonstrate(plan.task, attempt)
    arrays: Any = None
    if plan.keeps(done.outcome):
        arrays = done.arrays() | layout.packed_images(done.images, _rate_hz(plan.task))
    spool.store(done.outcome, arrays)
    return done.outcome


def _rate_hz(task: Task) -> float:
    config: Any = registry.benchmark(task.benchmark).read(task.settings)
    return 1.0 / float(config.control_period_s)
