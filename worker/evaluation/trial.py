"""One trial of a run: boxes for its programs, the simulation, and how it ended, as data."""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from seamark.programs import parameters, trial_limits
from seamark.sandbox.limits import Limits
from seamark.sandbox.outcome import ProgramEnded
from seamark.sim import registry
from seamark.sim.engine.closed_loop import StateInvalid
from seamark.sim.engine.program import Program
from seamark.sim.engine.team import Team
from seamark.sim.engine.trial import TrialResult, run_trial
from seamark.sim.settings.configuration import Configuration
from seamark.worker.evaluation.boxed_programs import BoxedPrograms, of_role
from seamark.worker.evaluation.job import Job
from seamark.worker.evaluation.program_adapters import BoxLike, Compile, MakeBox
from seamark.worker.ipc.listener import Listener
from seamark.worker.ipc.outcomes import TrialOutcome

Rows = NDArray[np.float64]
_T = TypeVar("_T")


class StopTrial(Exception):
    """Raised by a listener to end the trial early and in order."""


@dataclass(slots=True, kw_only=True)
class _Upload:
    """An uploaded program of a job."""

    role: str
    language: str
    filename: str
    source: bytes
    parameters: Mapping[str, Any]  # values of those that it declares
    compiled: bytes = b""


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
        self._role = benchmark.role
        trial_s = benchmark.trial_duration_s(self.config)
        self._limits = limits or trial_limits.for_trial(trial_s)
        self.source = job.program.read_bytes() if job.program is not None else b""
        self.part_sources = {part.role: part.program.read_bytes() for part in job.parts}
        self._uploads = self._all_uploads()

    def _all_uploads(self) -> list[_Upload]:
        """Return the programs of the job: that of the benchmark's own role, then the parts."""
        job = self._job
        main = _Upload(
            role=self._role,
            language=job.language,
            filename=job.filename,
            source=self.source,
            parameters=self.parameters,
        )
        parts = [
            _Upload(
                role=part.role,
                language=part.language,
                filename=part.filename,
                source=self.part_sources[part.role],
                parameters=part.parameters,
            )
            for part in job.parts
        ]
        return parts if job.program is None else [main, *parts]

    def compile(self, listener: Listener) -> None:
        """Compile the programs, if there are any; raises ProgramEnded if that fails."""
        for upload in self._uploads:
            compile_it = partial(self._compile, upload.language, upload.source, upload.filename)
            try:
                upload.compiled = _retry_once(compile_it, 0, listener)
            except ProgramEnded as ended:
                if not self._job.parts:
                    raise
                raise of_role(ended, upload.role) from None

    def run(self, trial: int, listener: Listener) -> TrialOutcome:
        """Run one trial, a second time if the host and not the program may have been too slow."""
        try:
            return _retry_once(lambda: self._attempt(trial, listener), trial, listener)
        except ProgramEnded as ended:
            return TrialOutcome(program=ended.outcome)
        except StateInvalid as invalid:
            return TrialOutcome(divergence=str(invalid))

    def _attempt(self, trial: int, listener: Listener) -> TrialOutcome:
        if not self._uploads:
            solution = self._own_solution(trial)
            return TrialOutcome(result=self._simulate(trial, solution, listener.rows))
        programs = BoxedPrograms(listener, named=bool(self._job.parts))
        try:
            return self._attempt_in_boxes(trial, listener, programs)
        except ProgramEnded as ended:
            raise programs.named(ended) from None
        finally:
            programs.close()

    def _attempt_in_boxes(
        self, trial: int, listener: Listener, programs: BoxedPrograms
    ) -> TrialOutcome:
        asked_at = time.perf_counter()
        for upload in self._uploads:
            box = self._make_box(upload.language, self._limits)
            programs.load(upload.role, box, partial(self._send_program, upload, trial))
        start_s = time.perf_counter() - asked_at

        def on_rows(rows: Rows) -> None:
            listener.rows(rows)
            programs.forward_output()

        solution = self._team(trial, programs.solutions)
        try:
            result = self._simulate(trial, solution, on_rows)
            return TrialOutcome(result=result, program=programs.finish(), box_start_s=start_s)
        except StopTrial:
            return TrialOutcome(program=programs.finish(), box_start_s=start_s)

    def _own_solution(self, trial: int) -> Any:
        """Return the solution that is no upload: connected, or built in."""
        if self._connected is not None:
            return self._connected
        return self._experiment.built_in(self._job.controller, self.config.for_trial(trial))

    def _team(self, trial: int, uploaded: Mapping[str, Any]) -> Any:
        """Return what takes part: the uploaded programs, and built-in solutions beside them."""
        main = uploaded[self._role] if self._role in uploaded else self._own_solution(trial)
        if not self._job.parts:
            return main
        return Team(main, **{part.role: uploaded[part.role] for part in self._job.parts})

    def _send_program(self, upload: _Upload, trial: int, box: BoxLike) -> None:
        config = self.config.for_trial(trial)
        is_main = upload.role == self._role
        layout = self._experiment.layout(config) if is_main else {"role": upload.role}
        given = {**config.for_program(), **upload.parameters}
        box.load(upload.compiled, upload.filename, given, layout)

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
