"""Candidates as practice runs on a server, several at a time."""

from __future__ import annotations

import asyncio
import shutil
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from seamark.client import AsyncClient, AsyncRun, Conflict, TooManyRequests
from seamark.client.documents import SubmissionOptions
from seamark.failures import PlatformFailed, UsageRefused
from seamark.tuning.candidates import Evaluated, Order, evaluated

PATIENCE_S = 30.0  # of pauses within a request; longer ones are announced
RETRY_S = 60.0  # after a refusal that does not say when to try again
CANCELLING_S = 20.0  # most that leaving may take
_OUR_FAILURE = "platform_error"


@dataclass(frozen=True, slots=True, kw_only=True)
class Entry:
    """What is tuned."""

    benchmark: str
    controller: str | None  # a built-in one; None: a program
    program: Path | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Listener:
    """What is told while candidates run."""

    progress: Callable[[float], None]  # of `repeat`, 0 to 1
    notice: Callable[[str], None]  # a sentence about something that delays the search


def room_for(account: Mapping[str, Any]) -> int:
    """Return how many more runs an account (`Client.account`) may have live; a new guest one."""
    quota = account["quota"]
    return 1 if quota is None else max(1, quota["live_max"] - quota["live"])


class ServerRuns:
    """Runs candidates on a server; a context manager, an `Evaluator`.

    A submission that the server refuses for now is repeated when the server says. On leaving, runs
    that have not ended are cancelled.

    Parameters
    ----------
    at_a_time
        Most runs that are live at a time; `room_for` says what the account's quota allows.
    """

    def __init__(
        self,
        client: AsyncClient,
        entry: Entry,
        *,
        seed: int,
        trials: int,
        at_a_time: int,
        listener: Listener,
    ) -> None:
        self._client, self._entry, self._listener = client, entry, listener
        self._seed, self._trials = seed, trials
        self._places = asyncio.Semaphore(at_a_time)
        self._folder = tempfile.TemporaryDirectory(prefix="seamark-tune-")
        self._runner = asyncio.Runner()
        self._candidates: dict[asyncio.Task[Evaluated], Order] = {}
        self._submissions: set[asyncio.Task[AsyncRun]] = set()  # not answered yet
        self._live: dict[int, AsyncRun] = {}
        self._not_before = 0.0  # when the server takes submissions again, in the loop's time

    def __enter__(self) -> Self:
        """Keep a copy of the program: all candidates are the same, whoever edits it meanwhile."""
        if (program := self._entry.program) is not None:
            kept = Path(self._folder.name, program.name)
            shutil.copyfile(program, kept)
            self._entry = replace(self._entry, program=kept)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Cancel what has not ended."""
        with self._folder, self._runner:
            self._runner.run(self._leave())

    def evaluate(self, orders: Sequence[Order]) -> Iterator[tuple[Order, Evaluated]]:
        """Yield each order when its run has ended; raises as `repeat`."""
        loop = self._runner.get_loop()
        for order in orders:
            self._candidates[loop.create_task(self._evaluate(order))] = order
        while self._candidates:
            for task in self._runner.run(_first_of(self._candidates)):
                order = self._candidates.pop(task)
                yield order, task.result()

    def repeat(self, config: Mapping[str, Any], *, seed: int, trials: int) -> Evaluated:
        """Run one configuration with another seed.

        Raises
        ------
        ServerRefused, ServerUnavailable
        PlatformFailed, UsageRefused
            The service failed, or somebody cancelled the run.
        """

        def show(run: AsyncRun) -> None:
            self._listener.progress(1.0 if run.ended else run.progress)

        wanted = self._wanted(config, title="Tuning: fresh trials", seed=seed, trials=trials)
        return self._runner.run(self._ended(wanted, show))

    async def _evaluate(self, order: Order) -> Evaluated:
        title = f"Tuning: candidate {order.candidate.number}"
        wanted = self._wanted(order.config, title=title, seed=self._seed, trials=self._trials)
        async with self._places:
            return await self._ended(wanted)

    def _wanted(
        self, config: Mapping[str, Any], *, title: str, seed: int, trials: int
    ) -> SubmissionOptions:
        return {
            "controller": self._entry.controller,
            "program": self._entry.program,
            "config": config,
            "seed": seed,
            "trials": trials,
            "title": title,
        }

    async def _ended(
        self, wanted: SubmissionOptions, on_change: Callable[[AsyncRun], None] | None = None
    ) -> Evaluated:
        run = await self._submitted(wanted)
        await run.wait(on_change=on_change)
        del self._live[run.id]
        if run.state == "cancelled":
            raise UsageRefused(f"Run {run.id} was cancelled on the server: {run.page}")
        failure = run.failure or {}
        sentence = str(failure.get("sentence") or failure.get("cause") or "")
        if failure.get("cause") == _OUR_FAILURE:
            raise PlatformFailed(f"Run {run.id} failed on the server: {sentence} {run.page}")
        return evaluated(run.document["metrics"], sentence)

    async def _submitted(self, wanted: SubmissionOptions) -> AsyncRun:
        """Return the run once the server has accepted it."""
        loop = asyncio.get_running_loop()
        while True:
            while (pause_s := self._not_before - loop.time()) > 0.0:
                await asyncio.sleep(pause_s)
            try:
                # Goes on if the search is stopped: the server may have accepted the run already.
                return await asyncio.shield(self._submission(wanted))
            except TooManyRequests as refusal:
                self._postpone(refusal, loop.time())

    def _submission(self, wanted: SubmissionOptions) -> asyncio.Task[AsyncRun]:
        submit = self._client.submit(self._entry.benchmark, **wanted)
        task = asyncio.get_running_loop().create_task(submit)
        self._submissions.add(task)
        task.add_done_callback(self._answered)
        return task

    def _answered(self, task: asyncio.Task[AsyncRun]) -> None:
        self._submissions.discard(task)
        if not task.cancelled() and task.exception() is None:
            run = task.result()
            self._live[run.id] = run

    def _postpone(self, refusal: TooManyRequests, now: float) -> None:
        pause_s = refusal.retry_after_s or RETRY_S
        if now >= self._not_before:  # the first refusal of several
            when = f"{pause_s:.0f} s" if pause_s < 120.0 else f"{pause_s / 60.0:.0f} min"
            self._listener.notice(f"{refusal} The search goes on in {when}.")
        self._not_before = max(self._not_before, now + pause_s)

    async def _leave(self) -> None:
        try:
            async with asyncio.timeout(CANCELLING_S):
                await self._cancel_all()
        except TimeoutError:
            numbers = ", ".join(map(str, sorted(self._live)))
            self._listener.notice(f"The server does not answer: runs {numbers} may still go on.")
        finally:
            await self._client.close()

    async def _cancel_all(self) -> None:
        for task in self._candidates:
            task.cancel()
        await asyncio.gather(*self._candidates, *self._submissions, return_exceptions=True)
        runs = list(self._live.values())
        answers = await asyncio.gather(*(run.cancel() for run in runs), return_exceptions=True)
        for run, answer in zip(runs, answers, strict=True):
            if isinstance(answer, Exception) and not isinstance(answer, Conflict):  # it has ended
                self._listener.notice(f"Run {run.id} could not be cancelled: {answer}")


async def _first_of(
    tasks: Mapping[asyncio.Task[Evaluated], Order],
) -> set[asyncio.Task[Evaluated]]:
    """Return those that have ended, once there are any."""
    ended, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
    return ended
