"""One evaluation in this process, without server or broker: what `seamark run` does.

The same trials, boxes and digest as on the server, so the same bytes.
"""

import os
import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seamark.programs import parameters
from seamark.programs.preparation import PreparedProgram
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.languages import DEFAULT_LANGUAGE, language_of
from seamark.sim import registry
from seamark.sim.engine.program import Program
from seamark.sim.engine.warm_up import warm_up_benchmark
from seamark.sim.recording.telemetry import INDEX
from seamark.worker.evaluation.check import check
from seamark.worker.evaluation.check_recorder import SEED, CheckRecorder
from seamark.worker.evaluation.evaluation import Evaluation
from seamark.worker.evaluation.job import Job, PartProgram
from seamark.worker.evaluation.program_adapters import box_pool, sandboxed_compiler
from seamark.worker.evaluation.worker_slot import WorkerSlot
from seamark.worker.ipc.outcomes import RunOutcome

Rows = NDArray[np.float64]
Controller = str | tuple[bytes, str] | PreparedProgram
Parts = Mapping[str, PreparedProgram]  # role -> program in place of the built-in solution


@dataclass(frozen=True, slots=True)
class Progress:
    """How far an evaluation is: 0 to 1, and simulated seconds over all trials."""

    fraction: float
    t_simulated: float


def _ignore(_: object) -> None:
    """Do nothing."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Callbacks:
    """Functions that are called while the trials run."""

    rows: Callable[[Rows], None] = _ignore
    log: Callable[[bytes], None] = _ignore
    progress: Callable[[Progress], None] = _ignore
    trial_restarted: Callable[[int], None] = _ignore  # the rows of this trial are void


def evaluate_locally(  # noqa: PLR0913 - one argument for each thing that decides a run
    benchmark: str,
    config: Mapping[str, object],
    *,
    seed: int,
    trials: int = 1,
    controller: Controller,
    parts: Parts | None = None,
    callbacks: Callbacks | None = None,
    isolation: IsolationLevel = IsolationLevel.NONE,
    processes: int | None = None,
) -> RunOutcome:
    """Evaluate a controller and return how it ended, with metrics, manifest and digest.

    Parameters
    ----------
    controller
        Name of a built-in one, or a program, which runs in a box: (source, file name) of a single
        file, or what `seamark.programs.preparation.prepare` made of any upload.
    parts
        Further programs by role, as far as the benchmark has such parts.
    isolation
        Isolation level of the box; see `seamark.sandbox.probing.probes.probe`.
    processes
        How many trials run in parallel; as many as there are cores by default. It makes no
        difference to the result.

    Raises
    ------
    ConfigurationInvalid, SandboxBroken
        The configuration is wrong; the box failed, not the program.
    """
    return evaluate_seeds(
        *(benchmark, config),
        seeds=(seed,) * trials,
        controller=controller,
        parts=parts,
        callbacks=callbacks,
        isolation=isolation,
        processes=processes,
    )


def evaluate_seeds(  # noqa: PLR0913 - one argument for each thing that decides a run
    benchmark: str,
    config: Mapping[str, object],
    *,
    seeds: tuple[int, ...],
    ranked: bool = False,
    controller: Controller,
    parts: Parts | None = None,
    callbacks: Callbacks | None = None,
    isolation: IsolationLevel = IsolationLevel.NONE,
    processes: int | None = None,
) -> RunOutcome:
    """Evaluate a controller as `evaluate_locally`, with a seed of its own for each trial.

    Parameters
    ----------
    ranked
        Whether the metrics are those of a ranked run.
    """
    entry = registry.benchmark(benchmark)
    duration = entry.trial_duration_s(entry.read(parameters.split(config)[0]))
    trials = len(seeds)
    listener = _CallbackListener(callbacks or Callbacks(), duration, trials)
    with job_of(benchmark, config, controller, parts=parts, seeds=seeds, ranked=ranked) as job:
        shared_cores = tuple(sorted(os.sched_getaffinity(0))[:processes])
        slot = WorkerSlot(isolation, None, shared_cores=shared_cores)
        cores = slot.cores_for(trials)
        if cores is not None:
            warm_up_benchmark(benchmark)  # once, and not in the process of each trial
        with box_pool(slot) as pool:
            return Evaluation(
                job,
                listener,
                pool.take,
                compile_program=sandboxed_compiler(slot),
                cores=cores,
                pool=pool,
            ).run()


def evaluate_connected(
    benchmark: str,
    config: Mapping[str, object],
    program: Program,
    *,
    name: str,
    seed: int,
    trials: int = 1,
    callbacks: Callbacks | None = None,
) -> RunOutcome:
    """Evaluate a program that runs outside and is connected, one trial after the other.

    Parameters
    ----------
    program
        May raise ProgramEnded, as a box does.
    name
        Of the connection, which the manifest names as the controller.

    Raises
    ------
    ConfigurationInvalid
        The configuration is wrong.
    """
    entry = registry.benchmark(benchmark)
    duration = entry.trial_duration_s(entry.read(config))
    listener = _CallbackListener(callbacks or Callbacks(), duration, trials)
    with job_of(benchmark, config, name, seeds=(seed,) * trials) as job:
        slot = WorkerSlot(IsolationLevel.NONE, None)
        return Evaluation(job, listener, box_pool(slot).take, connected=program).run()


def check_locally(
    benchmark: str,
    config: Mapping[str, object],
    program: PreparedProgram,
    *,
    isolation: IsolationLevel,
) -> dict[str, Any]:
    """Return the report (`seamark.programs.check_report`) on a program after two simulated seconds.

    Raises
    ------
    SandboxBroken
        The box failed, not the program.
    """
    slot, recorder = WorkerSlot(isolation, None), CheckRecorder()
    with job_of(benchmark, config, program, seeds=(SEED,)) as job:
        outcome = check(job, recorder, box_pool(slot).take, sandboxed_compiler(slot))
    return recorder.report(job, outcome)


@contextmanager
def job_of(
    benchmark: str,
    config: Mapping[str, object],
    controller: Controller,
    *,
    parts: Parts | None = None,
    seeds: tuple[int, ...],
    ranked: bool = False,
) -> Iterator[Job]:
    """Provide a job, with its programs in files that are deleted afterwards."""
    plain = Job(
        benchmark=benchmark,
        config=dict(config),
        seeds=seeds,
        ranked=ranked,
        controller=controller if isinstance(controller, str) else "upload",
    )
    if isinstance(controller, str) and not parts:
        yield plain
        return
    with tempfile.TemporaryDirectory(prefix="seamark-") as name:
        folder = Path(name)
        files = tuple(_part(role, program, folder) for role, program in (parts or {}).items())
        yield replace(_with_program(plain, controller, folder), parts=files)


def _with_program(job: Job, controller: Controller, folder: Path) -> Job:
    if isinstance(controller, str):
        return job
    if isinstance(controller, PreparedProgram):
        source, name, language = controller.content, controller.name, controller.language
    else:
        source, name = controller
        language = language_of(name) or DEFAULT_LANGUAGE
    program = folder / "program"
    program.write_bytes(source)
    return replace(job, program=program, filename=name, language=language)


def _part(role: str, prepared: PreparedProgram, folder: Path) -> PartProgram:
    program = folder / role
    program.write_bytes(prepared.content)
    return PartProgram(
        role=role,
        program=program,
        filename=prepared.name,
        language=prepared.language,
        parameters=parameters.defaults(prepared.parameters),
    )


class _CallbackListener:
    """A `seamark.worker.ipc.listener.Listener` that calls back, with the progress of the run."""

    def __init__(self, callbacks: Callbacks, trial_s: float, trials: int) -> None:
        self._callbacks = callbacks
        self._trial_s = trial_s
        self._trials = trials

    def rows(self, rows: Rows) -> None:
        self._callbacks.rows(rows)
        t = float(rows[-1, INDEX["trial"]]) * self._trial_s + float(rows[-1, INDEX["t"]])
        self._callbacks.progress(Progress(min(t / (self._trial_s * self._trials), 1.0), t))

    def log(self, text: bytes) -> None:
        self._callbacks.log(text)

    def trial_ended(self, trial: int) -> None:
        t = (trial + 1) * self._trial_s
        self._callbacks.progress(Progress((trial + 1) / self._trials, t))

    def trial_restarted(self, trial: int, reason: str) -> None:
        self._callbacks.trial_restarted(trial)
        self._callbacks.log(f"[Trial {trial + 1} starts again: {reason}]\n".encode())
