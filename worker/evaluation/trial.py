"""One trial of a run: a box for its program, the simulation, and how it ended, as data."""

import time
from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from seamark.programs import parameters, trial_limits
from seamark.sandbox.limits import Limits
from seamark.sandbox.outcome import ProgramEnded
from seamark.sim import registry
from seamark.sim.engine.closed_loop import StateInvalid
from seamark.sim.engine.program import Program
from seamark.sim.engine.trial import TrialResult, run_trial
from seamark.sim.settings.configuration import Configuration
from seamark.worker.evaluation.job import Job
from seamark.worker.evaluation.program_adapters import ADAPTERS, BoxLike, Compile, MakeBox
from seamark.worker.ipc.listener import Listener
from seamark.worker.ipc.outcomes import TrialOutcome

Rows = NDArray[np.float64]
_T = TypeVar("_T")


class StopTrial(Exception):
    """Raised by a listener to end the trial early and in order."""


class TrialRunner:
    """Runs single trials of a job. An upload is compiled once and has a new box in each trial."""

    def __init__(
        self,
        job: Job,
        make_box: MakeBox,
        compile_program: Compile,
        *,
        limits: Limits | None = None,
        connected: Program | None = None,
    ) -> None:
        """Set up the trials of a job; `connected` takes part instead of its controller."""
        self._job = job
        self._connected = connected
        self._make_box = make_box
        self._compile = compile_program
        benchmark = registry.benchmark(job.benchmark)
        settings, self.parameters = parameters.split(job.config)
        self.config: Configuration = benchmark.read(settings)
        self._experiment = benchmark.load()
        self._adapter = ADAPTERS[benchmark.role]
        trial_s = benchmark.trial_duration_s(self.config)
        self._limits = limits or trial_limits.for_trial(trial_s)
        self.source = job.program.read_bytes() if job.program is not None else b""
        self._compiled = b""

    def compile(self, listener: Listener) -> None:
        """Compile the program, if there is one; raises ProgramEnded if that fails."""
        job = self._job
        if job.program is not None:
            self._compiled = _retry_once(
                lambda: self._compile(job.language, self.source, job.filename), 0, listener
            )

    def run(self, trial: int, listener: Listener) -> TrialOutcome:
        """Run one trial, a second time if the host and not the program may have been too slow."""
        try:
            return _retry_once(lambda: self._attempt(trial, listener), trial, listener)
        except ProgramEnded as ended:
            return TrialOutcome(program=ended.outcome)
        except StateInvalid as invalid:
            return TrialOutcome(divergence=str(invalid))

    def _attempt(self, trial: int, listener: Listener) -> TrialOutcome:
        if self._connected is not None:
            return TrialOutcome(result=self._simulate(trial, self._connected, listener.rows))
        if self._job.program is None:
            config = self.config.for_trial(trial)
            built_in = self._experiment.built_in(self._job.controller, config)
            return TrialOutcome(result=self._simulate(trial, built_in, listener.rows))
        asked_at = time.perf_counter()
        box = self._loaded_box(trial, listener)
        start_s = time.perf_counter() - asked_at

        def on_rows(rows: Rows) -> None:
            listener.rows(rows)
            _forward_output(box, listener)

        solution = self._adapter(box)
        try:
            result = self._simulate(trial, solution, on_rows)
            return TrialOutcome(result=result, program=box.finish(), box_start_s=start_s)
        except StopTrial:
            return TrialOutcome(program=box.finish(), box_start_s=start_s)
        finally:
            _forward_output(box, listener)
            if note := solution.note():
                listener.log(note.encode())
            box.close()

    def _loaded_box(self, trial: int, listener: Listener) -> BoxLike:
        """Return a box with the program in it."""
        box = self._make_box(self._job.language, self._limits)
        try:
            config = self.config.for_trial(trial)
            layout = self._experiment.layout(config)
            given = {**config.for_program(), **self.parameters}
            box.load(self._compiled, self._job.filename, given, layout)
        except ProgramEnded:
            _forward_output(box, listener)
            box.close()
            raise
        return box

    def _simulate(self, trial: int, solution: Any, on_rows: Callable[[Rows], None]) -> TrialResult:
        seed = self._job.seeds[trial]
        return run_trial(
            self._job.benchmark, self.config, solution, seed=seed, trial=trial, on_rows=on_rows
        )


def _retry_once(action: Callable[[], _T], trial: int, listener: Listener) -> _T:
    """Return the result of `action`, of a second call if the host may have been too slow."""
    try:
        return action()
    except ProgramEnded as ended:
        if not ended.outcome.suspect_host:
            raise
        listener.trial_restarted(trial, ended.outcome.sentence)
    return action()


def _forward_output(box: BoxLike, listener: Listener) -> None:
    if text := box.take_output():
        listener.log(text)
