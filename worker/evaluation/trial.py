"""One trial of a run: a box for its program, the simulation, and how it ended, as data."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from seamark.sandbox.limits import Limits
from seamark.sandbox.outcome import Outcome, ProgramEnded
from seamark.server.runs import trial_limits
from seamark.sim import registry
from seamark.sim.engine.closed_loop import StateInvalid
from seamark.sim.engine.trial import TrialResult, run_trial
from seamark.sim.settings.configuration import Configuration
from seamark.worker.evaluation.job import Job
from seamark.worker.evaluation.program_adapters import SOLUTIONS, BoxLike, Compile, MakeBox

Rows = NDArray[np.float64]
_T = TypeVar("_T")


class Enough(Exception):
    """A listener has seen all that it wants of a trial: the program is told to end."""


class TrialListener(Protocol):
    """Who hears what happens during a trial."""

    def rows(self, rows: Rows) -> None:
        """Take telemetry, (k, number of columns), in order."""

    def log(self, text: bytes) -> None:
        """Take what the program printed."""

    def cut(self, trial: int, why: str) -> None:
        """Forget the rows of this trial: it is done again."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TrialEnd:
    """How a trial ended: with a result, or by the program, or because the state was lost."""

    result: TrialResult | None = None
    outcome: Outcome | None = None  # of the program in its box; None for a built-in controller
    lost: str = ""  # why the simulation could not go on


class OneTrial:
    """Runs single trials of a job. With an upload, each has a new box; it is compiled once."""

    def __init__(
        self,
        job: Job,
        make_box: MakeBox,
        compile_program: Compile,
        *,
        limits: Limits | None = None,
    ) -> None:
        self._job = job
        self._make_box = make_box
        self._compile = compile_program
        benchmark = registry.benchmark(job.benchmark)
        self.config: Configuration = benchmark.read(job.config)
        self._experiment = benchmark.load()
        self._wrap = SOLUTIONS[benchmark.role]
        trial_s = benchmark.trial_duration_s(self.config)
        self._limits = limits or trial_limits.for_trial(trial_s)
        self.source = job.program.read_bytes() if job.program is not None else b""
        self._compiled = b""

    def prepare(self, listener: TrialListener) -> None:
        """Compile the program, if there is one; raises ProgramEnded if it cannot be."""
        job = self._job
        if job.program is not None:
            self._compiled = _once_more(
                lambda: self._compile(job.language, self.source, job.filename), 0, listener
            )

    def run(self, trial: int, listener: TrialListener) -> TrialEnd:
        """Run one trial, once more if the host and not the program may have been too slow."""
        try:
            return _once_more(lambda: self._attempt(trial, listener), trial, listener)
        except ProgramEnded as ended:
            return TrialEnd(outcome=ended.outcome)
        except StateInvalid as lost:
            return TrialEnd(lost=str(lost))

    def _attempt(self, trial: int, listener: TrialListener) -> TrialEnd:
        if self._job.program is None:
            built_in = self._experiment.built_in(self._job.controller, self.config)
            return TrialEnd(result=self._simulate(trial, built_in, listener.rows))
        box = self._loaded_box(listener)

        def on_rows(rows: Rows) -> None:
            listener.rows(rows)
            _pass_output(box, listener)

        solution = self._wrap(box)
        try:
            result = self._simulate(trial, solution, on_rows)
            return TrialEnd(result=result, outcome=box.finish())
        except Enough:
            return TrialEnd(outcome=box.finish())
        finally:
            _pass_output(box, listener)
            if remark := solution.remark():
                listener.log(remark.encode())
            box.close()

    def _loaded_box(self, listener: TrialListener) -> BoxLike:
        """Return a box with the program in it."""
        box = self._make_box(self._job.language, self._limits)
        self._load(box, listener)
        return box

    def _load(self, box: BoxLike, listener: TrialListener) -> None:
        try:
            config, layout = self.config.model_dump(), self._experiment.layout(self.config)
            box.load(self._compiled, self._job.filename, config, layout)
        except ProgramEnded:
            _pass_output(box, listener)
            box.close()
            raise

    def _simulate(self, trial: int, solution: Any, on_rows: Callable[[Rows], None]) -> TrialResult:
        seed = self._job.seeds[trial]
        return run_trial(
            self._job.benchmark, self.config, solution, seed=seed, trial=trial, on_rows=on_rows
        )


def _once_more(what: Callable[[], _T], trial: int, listener: TrialListener) -> _T:
    """Do it, and again if the host and not the program may have been too slow."""
    try:
        return what()
    except ProgramEnded as ended:
        if not ended.outcome.suspect_host:
            raise
        listener.cut(trial, ended.outcome.sentence)
    return what()


def _pass_output(box: BoxLike, listener: TrialListener) -> None:
    if text := box.take_output():
        listener.log(text)
