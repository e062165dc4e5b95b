"""All trials of one run, one after the other: the same code on the server and in `seamark run`."""

import hashlib
import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from sandbox.outcome import Outcome, ProgramEnded, SandboxBroken
from server import run_limits
from sim import registry
from sim.configuration import Configuration
from sim.loop import StateInvalid
from sim.manifest import manifest
from sim.telemetry import Digest
from sim.trial import TrialResult, run_trial, summarise
from worker.boxed import SOLUTIONS, BoxLike, Compile, MakeBox, as_it_is
from worker.job import Job

BENCHMARK_ERROR = "benchmark_error"
NO_SCORE = "A trial ended without a score: its state left the range in which numbers are finite."
Rows = NDArray[np.float64]


class Listener(Protocol):
    """Who hears what happens while the trials run."""

    def rows(self, rows: Rows) -> None:
        """Take telemetry, (k, number of columns), in order."""

    def log(self, text: bytes) -> None:
        """Take what the program printed."""

    def trial_ended(self, trial: int) -> None:
        """Hear that a trial has ended."""

    def cut(self, trial: int, why: str) -> None:
        """Forget the rows of this trial: it is done again."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Ending:
    """How the evaluation ended; without metrics if the program ended it."""

    verdict: str = "ok"  # a value of sandbox.outcome.Verdict, or "benchmark_error"
    sentence: str = ""
    traceback: str = ""
    usage: dict[str, float] = field(default_factory=dict)  # of the program; never compared
    metrics: dict[str, Any] | None = None
    manifest: dict[str, Any] | None = None
    digest: str = ""


class Evaluation:
    """Runs a job's trials. With an upload, each trial has a new box; it is compiled once."""

    def __init__(
        self,
        job: Job,
        listener: Listener,
        make_box: MakeBox,
        *,
        compile_program: Compile = as_it_is,
        warm: BoxLike | None = None,
    ) -> None:
        self._job = job
        self._listener = listener
        self._make_box = make_box
        self._compile = compile_program
        self._compiled: bytes | None = None
        self._warm = warm  # a box that was started before the job was known
        benchmark = registry.benchmark(job.benchmark)
        self._config: Configuration = benchmark.read(job.config)
        self._experiment = benchmark.load()
        self._wrap = SOLUTIONS[benchmark.role]
        self._limits = run_limits.for_trial(benchmark.trial_duration_s(self._config))
        self._source = job.program.read_bytes() if job.program is not None else b""
        self._digest = Digest()
        self._kept: list[Rows] = []
        self._outcomes: list[Outcome] = []

    def run(self) -> Ending:
        """Run all trials; a program that ends early ends the evaluation, as data."""
        results: list[TrialResult] = []
        for trial in range(len(self._job.seeds)):
            try:
                results.append(self._trial(trial))
            except ProgramEnded as ended:
                return self._ended(ended.outcome)
            except StateInvalid as lost:
                self._digest_trial()
                return self._ending(verdict=BENCHMARK_ERROR, sentence=str(lost))
            self._digest_trial()
            self._listener.trial_ended(trial)
        metrics = summarise(self._job.benchmark, self._config, results)
        if not _storable(metrics):
            return self._ending(verdict=BENCHMARK_ERROR, sentence=NO_SCORE)
        if metrics["score"] is None:
            return self._ending(verdict=BENCHMARK_ERROR, sentence=NO_SCORE, metrics=metrics)
        return self._ending(metrics=metrics)

    def _trial(self, trial: int) -> TrialResult:
        """Run one trial, once more if the host and not the program may have been too slow."""
        try:
            return self._attempt(trial)
        except ProgramEnded as ended:
            if not ended.outcome.suspect_host:
                raise
            self._listener.cut(trial, ended.outcome.sentence)
        return self._attempt(trial)

    def _attempt(self, trial: int) -> TrialResult:
        if self._job.program is None:
            built_in = self._experiment.built_in(self._job.controller, self._config)
            return self._simulate(trial, built_in, _nothing)
        box = self._loaded_box()
        try:
            result = self._simulate(trial, self._wrap(box), lambda: self._pass_output(box))
            self._outcomes.append(box.finish())
            return result
        finally:
            self._pass_output(box)
            box.close()

    def _loaded_box(self) -> BoxLike:
        """Return a box with the program in it; a warm one that has gone stale is replaced."""
        self._program()
        warm, self._warm = self._warm, None
        if warm is not None:
            try:
                self._load(warm)
                return warm
            except SandboxBroken:
                warm.close()
        box = self._make_box(self._job.language, self._limits)
        self._load(box)
        return box

    def _load(self, box: BoxLike) -> None:
        try:
            config, layout = self._config.model_dump(), self._experiment.layout(self._config)
            box.load(self._program(), self._job.filename, config, layout)
        except ProgramEnded:
            self._pass_output(box)
            box.close()
            raise

    def _program(self) -> bytes:
        """Return what a box runs; raises ProgramEnded if the source cannot be compiled."""
        if self._compiled is None:
            job = self._job
            self._compiled = self._compile(job.language, self._source, job.filename)
        return self._compiled

    def _simulate(self, trial: int, solution: Any, after_rows: Callable[[], None]) -> TrialResult:
        self._kept = []

        def on_rows(rows: Rows) -> None:
            self._kept.append(rows)
            self._listener.rows(rows)
            after_rows()

        seed = self._job.seeds[trial]
        return run_trial(
            self._job.benchmark, self._config, solution, seed=seed, trial=trial, on_rows=on_rows
        )

    def _digest_trial(self) -> None:
        """Add the trial's rows, at its end only: one that is done again must not count twice."""
        for rows in self._kept:
            self._digest.add(rows)
        self._kept = []

    def _pass_output(self, box: BoxLike) -> None:
        if text := box.take_output():
            self._listener.log(text)

    def _ended(self, outcome: Outcome) -> Ending:
        self._outcomes.append(outcome)
        self._digest_trial()
        return self._ending(
            verdict=str(outcome.verdict), sentence=outcome.sentence, traceback=outcome.traceback
        )

    def _ending(
        self,
        *,
        verdict: str = "ok",
        sentence: str = "",
        traceback: str = "",
        metrics: Mapping[str, Any] | None = None,
    ) -> Ending:
        digest = self._digest.hexdigest()
        return Ending(
            verdict=verdict,
            sentence=sentence,
            traceback=traceback,
            usage=_usage(self._outcomes),
            metrics=None if metrics is None else dict(metrics),
            manifest=self._manifest(digest),
            digest=digest,
        )

    def _manifest(self, digest: str) -> dict[str, Any]:
        """Return the manifest; the seed of a ranked run stays hidden."""
        return manifest(
            self._job.benchmark,
            self._config,
            seed=self._job.shown_seed,
            trials=len(self._job.seeds),
            controller=self._job.controller,
            program_sha256=hashlib.sha256(self._source).hexdigest() if self._source else None,
            digest=digest,
        )


def _usage(outcomes: list[Outcome]) -> dict[str, float]:
    """Return what the program used over all trials: a report, no part of any score."""
    if not outcomes:
        return {}
    return {
        "cpu_s": sum(outcome.cpu_s for outcome in outcomes),
        "wall_s": sum(outcome.wall_s for outcome in outcomes),
        "memory_mib": max(outcome.memory_mib for outcome in outcomes),
    }


def _storable(metrics: Mapping[str, Any]) -> bool:
    """Return whether the metrics are JSON, which has no NaN and no infinity."""
    try:
        json.dumps(metrics, allow_nan=False)
    except ValueError:
        return False
    return True


def _nothing() -> None:
    """Do nothing: what is built in prints nothing."""
