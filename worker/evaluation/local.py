"""One evaluation in this process, without server or broker: what `seamark run` does.

The same trials, boxes and digest as on the server, so the same bytes.
"""

import os
import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.languages import language_of
from seamark.server.checks import queue
from seamark.server.programs.store import PreparedProgram
from seamark.sim import registry
from seamark.sim.engine.warm_up import warm_up
from seamark.worker.evaluation.check import Glimpse, answer_of, check
from seamark.worker.evaluation.evaluation import Ending, Evaluation
from seamark.worker.evaluation.job import Job, Place
from seamark.worker.evaluation.program_adapters import pool_of, real_compiler

Rows = NDArray[np.float64]
Controller = str | tuple[bytes, str] | PreparedProgram


@dataclass(frozen=True, slots=True)
class Progress:
    """How far an evaluation is: 0 to 1, and simulated seconds over all trials."""

    fraction: float
    t_simulated: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Hearing:
    """What to call while the trials run."""

    rows: Callable[[Rows], None]
    log: Callable[[bytes], None]
    progress: Callable[[Progress], None]
    cut: Callable[[int], None]  # forget the rows of this trial: it is done again


def evaluate_here(
    benchmark: str,
    config: Mapping[str, object],
    *,
    seed: int,
    trials: int = 1,
    controller: Controller,
    hearing: Hearing,
    isolation: IsolationLevel = IsolationLevel.NONE,
    processes: int | None = None,
) -> Ending:
    """Evaluate a controller and return how it ended, with metrics, manifest and digest.

    Parameters
    ----------
    controller
        Name of a built-in one, or a program, which runs in a box: (source, file name) of a single
        file, or what `seamark.server.programs.store.prepare` made of any upload.
    isolation
        How strongly the box isolates the program; see `seamark.sandbox.probing.probes.probe`.
    processes
        How many trials run side by side; as many as there are cores if it is not given. It makes
        no difference to what comes out.

    Raises
    ------
    ConfigurationInvalid, SandboxBroken
        The configuration is wrong; the box failed, not the program.
    """
    entry = registry.benchmark(benchmark)
    duration = entry.trial_duration_s(entry.read(config))
    listener = _Listener(hearing, duration, trials)
    with job_of(benchmark, config, controller, seeds=(seed,) * trials) as job:
        place = Place(isolation, None, share=tuple(sorted(os.sched_getaffinity(0))[:processes]))
        compile_, cores = real_compiler(place), place.cores_for(trials)
        if cores is not None:
            warm_up()  # once, and not in each of the trials' processes
        with pool_of(place) as pool:
            return Evaluation(
                job, listener, pool.take, compile_program=compile_, cores=cores, pool=pool
            ).run()


def check_here(
    benchmark: str,
    config: Mapping[str, object],
    program: PreparedProgram,
    *,
    isolation: IsolationLevel,
) -> dict[str, Any]:
    """Return what `seamark.server.checks.report` says of a program after two simulated seconds.

    Raises
    ------
    SandboxBroken
        The box failed, not the program.
    """
    place, glimpse = Place(isolation, None), Glimpse()
    with job_of(benchmark, config, program, seeds=(queue.SEED,)) as job:
        ending = check(job, glimpse, pool_of(place).take, real_compiler(place))
    return answer_of(job, glimpse.end(asdict(ending)))


@contextmanager
def job_of(
    benchmark: str, config: Mapping[str, object], controller: Controller, *, seeds: tuple[int, ...]
) -> Iterator[Job]:
    """Give a job, with the program in a file that is gone afterwards."""
    plain = Job(
        benchmark=benchmark,
        config=dict(config),
        seeds=seeds,
        shown_seed=seeds[0],
        controller=controller if isinstance(controller, str) else "upload",
    )
    if isinstance(controller, str):
        yield plain
        return
    if isinstance(controller, PreparedProgram):
        source, name, language = controller.content, controller.name, controller.language
    else:
        source, name = controller
        language = language_of(name) or "python"
    with tempfile.TemporaryDirectory(prefix="seamark-") as folder:
        program = Path(folder, "program")
        program.write_bytes(source)
        yield replace(plain, program=program, filename=name, language=language)


class _Listener:
    """A `seamark.worker.evaluation.evaluation.Listener` that also knows how far the run is."""

    def __init__(self, hearing: Hearing, trial_s: float, trials: int) -> None:
        self._hearing = hearing
        self._trial_s = trial_s
        self._trials = trials

    def rows(self, rows: Rows) -> None:
        """Pass the rows on, and the progress that they show."""
        self._hearing.rows(rows)
        t = float(rows[-1, 0]) * self._trial_s + float(rows[-1, 2])
        self._hearing.progress(Progress(min(t / (self._trial_s * self._trials), 1.0), t))

    def log(self, text: bytes) -> None:
        """Pass the program's output on."""
        self._hearing.log(text)

    def trial_ended(self, trial: int) -> None:
        """Show that the trial is complete."""
        t = (trial + 1) * self._trial_s
        self._hearing.progress(Progress((trial + 1) / self._trials, t))

    def cut(self, trial: int, why: str) -> None:
        """Pass on that the trial is done again."""
        self._hearing.cut(trial)
        self._hearing.log(f"[Trial {trial + 1} is done again: {why}]\n".encode())
