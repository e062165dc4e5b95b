"""All trials of one run: the same code on the server and in `seamark run`."""

import hashlib
import json
from collections.abc import Generator, Mapping
from contextlib import closing
from dataclasses import dataclass, field
from typing import Any, Protocol

from seamark.sandbox.outcome import Outcome, ProgramEnded
from seamark.sandbox.pool import Pool
from seamark.sim.engine.trial import TrialResult, summarise
from seamark.sim.recording.manifest import manifest
from seamark.sim.recording.telemetry import Digest
from seamark.worker.evaluation.box_supply import Supply
from seamark.worker.evaluation.cores import Cores
from seamark.worker.evaluation.job import Job
from seamark.worker.evaluation.parallel_trials import SideBySide
from seamark.worker.evaluation.program_adapters import Compile, MakeBox, as_it_is
from seamark.worker.evaluation.trial import OneTrial, Rows, TrialEnd, TrialListener

BENCHMARK_ERROR = "benchmark_error"
NO_SCORE = "A trial ended without a score: its state left the range in which numbers are finite."


class Listener(TrialListener, Protocol):
    """Who hears what happens while the trials run."""

    def trial_ended(self, trial: int) -> None:
        """Hear that a trial has ended."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Ending:
    """How the evaluation ended; without metrics if the program ended it."""

    verdict: str = "ok"  # a value of seamark.sandbox.outcome.Verdict, or "benchmark_error"
    sentence: str = ""
    traceback: str = ""
    usage: dict[str, float] = field(default_factory=dict)  # of the program; never compared
    metrics: dict[str, Any] | None = None
    manifest: dict[str, Any] | None = None
    digest: str = ""


class Evaluation:
    """Runs a job's trials: side by side on `cores`, or without them one after the other, here.

    With a `pool`, whose `take` is `make_box`, the boxes of trials side by side come from it too.
    """

    def __init__(
        self,
        job: Job,
        listener: Listener,
        make_box: MakeBox,
        *,
        compile_program: Compile = as_it_is,
        cores: Cores | None = None,
        pool: Pool | None = None,
    ) -> None:
        self._job = job
        self._listener = _Digesting(listener)
        self._one = OneTrial(job, make_box, compile_program)
        self._cores = cores
        self._supply: Supply | None = None
        if cores is not None and pool is not None and job.program is not None:
            self._supply = Supply(pool, job.language, cores.count)
        self._outcomes: list[Outcome] = []

    def run(self) -> Ending:
        """Run all trials; a program that ends early ends the evaluation, as data."""
        try:
            self._one.prepare(self._listener)
        except ProgramEnded as ended:
            return self._ended(TrialEnd(outcome=ended.outcome))
        results: list[TrialResult] = []
        with closing(self._ends()) as ends:
            for trial, end in enumerate(ends):
                if end.result is None:
                    return self._ended(end)
                if end.outcome is not None:
                    self._outcomes.append(end.outcome)
                self._listener.trial_ended(trial)
                results.append(end.result)
        return self._summary(results)

    def _ends(self) -> Generator[TrialEnd, None, None]:
        count = len(self._job.seeds)
        if self._cores is not None:
            trials = SideBySide(self._one.run, self._cores, count, supply=self._supply)
            yield from trials.ends(self._listener)
        else:
            for trial in range(count):
                yield self._one.run(trial, self._listener)

    def _summary(self, results: list[TrialResult]) -> Ending:
        metrics = summarise(self._job.benchmark, self._one.config, results)
        if not _storable(metrics):
            return self._ending(verdict=BENCHMARK_ERROR, sentence=NO_SCORE)
        if metrics["score"] is None:
            return self._ending(verdict=BENCHMARK_ERROR, sentence=NO_SCORE, metrics=metrics)
        return self._ending(metrics=metrics)

    def _ended(self, end: TrialEnd) -> Ending:
        outcome = end.outcome
        if outcome is None:
            return self._ending(verdict=BENCHMARK_ERROR, sentence=end.lost)
        self._outcomes.append(outcome)
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
        digest = self._listener.digest.hexdigest()
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
        source = self._one.source
        return manifest(
            self._job.benchmark,
            self._one.config,
            seed=self._job.shown_seed,
            trials=len(self._job.seeds),
            controller=self._job.controller,
            program_sha256=hashlib.sha256(source).hexdigest() if source else None,
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


class _Digesting:
    """Passes everything on, and computes the digest of the rows that count."""

    def __init__(self, listener: Listener) -> None:
        self._listener = listener
        self.digest = Digest()
        self._before_trial = Digest()

    def rows(self, rows: Rows) -> None:
        self.digest.add(rows)
        self._listener.rows(rows)

    def log(self, text: bytes) -> None:
        self._listener.log(text)

    def trial_ended(self, trial: int) -> None:
        self._before_trial = self.digest.copy()
        self._listener.trial_ended(trial)

    def cut(self, trial: int, why: str) -> None:
        self.digest = self._before_trial.copy()
        self._listener.cut(trial, why)
