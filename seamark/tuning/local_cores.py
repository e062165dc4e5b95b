"""Candidates on the cores of this machine, each in one process."""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from types import TracebackType
from typing import Any, NoReturn, Self

from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sim.engine.warm_up import warm_up_benchmark
from seamark.tuning.candidates import Evaluated, Order, evaluated
from seamark.worker.evaluation.local import Callbacks, Controller, evaluate_locally
from seamark.worker.ipc.outcomes import RunOutcome
from seamark.worker.ipc.process_control import die_with_parent


@dataclass(frozen=True, slots=True, kw_only=True)
class Solution:
    """What is tuned, and the box in which it runs."""

    benchmark: str
    controller: Controller
    isolation: IsolationLevel


class LocalCores:
    """Runs candidates in processes; a context manager, an `Evaluator`.

    The processes are forks that share compiled code. They are started before anything else has
    threads. On leaving, candidates that are running are given up.
    """

    def __init__(
        self,
        solution: Solution,
        *,
        seed: int,
        trials: int,
        jobs: int,
        on_progress: Callable[[float], None],
    ) -> None:
        self._solution, self._seed, self._trials, self._jobs = solution, seed, trials, jobs
        self._on_progress = on_progress  # of `repeat`
        self._pool = ProcessPoolExecutor(
            jobs,
            mp_context=multiprocessing.get_context("fork"),
            initializer=_be_a_job,
            initargs=(os.getpid(),),
        )

    def __enter__(self) -> Self:
        """Start the processes."""
        warm_up_benchmark(self._solution.benchmark)
        self._pool.submit(os.getpid).result()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """End the processes, with their boxes."""
        self._pool.shutdown(wait=False, cancel_futures=True)
        for process in multiprocessing.active_children():
            process.terminate()
        self._pool.shutdown()

    def evaluate(self, orders: Sequence[Order]) -> Iterator[tuple[Order, Evaluated]]:
        """Yield each order when its run has ended."""
        waiting: dict[Future[Evaluated], Order] = {
            self._pool.submit(
                _evaluate, self._solution, order.config, self._seed, self._trials
            ): order
            for order in orders
        }
        for done in as_completed(waiting):
            yield waiting[done], done.result()

    def repeat(self, config: Mapping[str, Any], *, seed: int, trials: int) -> Evaluated:
        """Run one configuration with another seed, its trials in parallel."""
        outcome = evaluate_locally(
            self._solution.benchmark,
            config,
            seed=seed,
            trials=trials,
            controller=self._solution.controller,
            isolation=self._solution.isolation,
            processes=self._jobs,
            callbacks=Callbacks(progress=lambda p: self._on_progress(p.fraction)),
        )
        return _ended(outcome)


def _be_a_job(parent: int) -> None:
    """Prepare a process of the pool: Ctrl-C is for the parent, which then ends this one."""
    die_with_parent(parent)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, _leave)


def _leave(_number: int, _frame: object) -> NoReturn:
    """Leave a run by an exception, so that its box is closed."""
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    raise SystemExit


def _evaluate(solution: Solution, config: Mapping[str, Any], seed: int, trials: int) -> Evaluated:
    outcome = evaluate_locally(
        solution.benchmark,
        config,
        seed=seed,
        trials=trials,
        controller=solution.controller,
        isolation=solution.isolation,
        processes=1,
    )
    return _ended(outcome)


def _ended(outcome: RunOutcome) -> Evaluated:
    failure = outcome.failure
    return evaluated(outcome.metrics, (outcome.sentence or failure) if failure else "")
