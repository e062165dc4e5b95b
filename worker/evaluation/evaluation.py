"""All trials of one run: the same code on the server and in `seamark run`."""

import json
from collections.abc import Generator, Mapping, Sequence
from contextlib import closing
from hashlib import sha256
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seamark.programs.failure_reasons import FailureReason
from seamark.programs.parameters import KEY
from seamark.sandbox.outcome import Outcome, ProgramEnded, Verdict
from seamark.sandbox.pool import Pool
from seamark.sim import registry
from seamark.sim.engine.program import Program
from seamark.sim.engine.summary import summarise
from seamark.sim.engine.trial import TrialResult
from seamark.sim.recording.manifest import manifest
from seamark.sim.recording.telemetry import Digest
from seamark.worker.evaluation.cores import Cores
from seamark.worker.evaluation.job import Job
from seamark.worker.evaluation.parallel_trials import ParallelTrials, WarmBoxes
from seamark.worker.evaluation.program_adapters import Compile, MakeBox, without_compiling
from seamark.worker.evaluation.trial import TrialRunner
from seamark.worker.ipc.listener import Listener
from seamark.worker.ipc.outcomes import RunOutcome, TrialOutcome

NO_SCORE = "A trial ended without a score: its state left the range in which numbers are finite."


class Evaluation:
    """Runs a job's trials: in parallel on `cores`; without `cores` one after the other, here.

    With a `pool`, whose `take` is `make_box`, the boxes of parallel trials come from it too. A
    `connected` program, which runs outside, takes part in all trials instead of the job's.
    """

    def __init__(
        self,
        job: Job,
        listener: Listener,
        make_box: MakeBox,
        *,
        compile_program: Compile = without_compiling,
        cores: Cores | None = None,
        pool: Pool | None = None,
        connected: Program | None = None,
    ) -> None:
        self._job = job
        self._connected = connected is not None
        self._listener = _DigestingListener(listener)
        self._runner = TrialRunner(job, make_box, compile_program, connected=connected)
        self._cores = cores
        self._warm_boxes: WarmBoxes | None = None
        if cores is not None and pool is not None and job.languages:
            self._warm_boxes = WarmBoxes(pool, job.languages, cores.count)
        self._programs: list[Outcome] = []  # one per trial of uploads
        self._box_starts_s: list[float] = []

    def run(self) -> RunOutcome:
        """Run all trials; a program that fails ends the evaluation, as data."""
        try:
            self._runner.compile(self._listener)
        except ProgramEnded as ended:
            return self._failed(TrialOutcome(program=ended.outcome))
        results: list[TrialResult] = []
        with closing(self._trial_outcomes()) as outcomes:
            for trial, outcome in enumerate(outcomes):
                if outcome.box_start_s is not None:
                    self._box_starts_s.append(outcome.box_start_s)
                if outcome.result is None:
                    return self._failed(outcome)
                if outcome.program is not None:
                    self._programs.append(outcome.program)
                self._listener.trial_ended(trial)
                results.append(outcome.result)
        return self._scored(results)

    def _trial_outcomes(self) -> Generator[TrialOutcome, None, None]:
        count = len(self._job.seeds)
        if self._cores is not None:
            trials = ParallelTrials(
                self._runner.run, self._cores, count, warm_boxes=self._warm_boxes
            )
            yield from trials.outcomes(self._listener)
        else:
            for trial in range(count):
                yield self._runner.run(trial, self._listener)

    def _scored(self, results: Sequence[TrialResult]) -> RunOutcome:
        job = self._job
        metrics = summarise(job.benchmark, self._runner.config, results, ranked=job.ranked)
        if not _is_json(metrics):
            return self._outcome(failure=FailureReason.BENCHMARK_ERROR, sentence=NO_SCORE)
        if metrics["score"] is None:
            return self._outcome(
                failure=FailureReason.BENCHMARK_ERROR, sentence=NO_SCORE, metrics=dict(metrics)
            )
        return self._outcome(metrics=dict(metrics))

    def _failed(self, outcome: TrialOutcome) -> RunOutcome:
        if outcome.program is not None:
            self._programs.append(outcome.program)
        return self._outcome(**reason_of(outcome))

    def _outcome(self, **values: Any) -> RunOutcome:
        digest = self._listener.digest.hexdigest()
        return RunOutcome(
            usage=_usage(self._programs),
            manifest=self._manifest(digest),
            digest=digest,
            box_starts_s=self._box_starts_s,
            **values,
        )

    def _manifest(self, digest: str) -> dict[str, Any]:
        """Return the manifest; seeds that concern other runs too stay hidden."""
        job, source = self._job, self._runner.source
        own: dict[str, Any] = {}
        if self._runner.parameters:
            own[KEY] = dict(self._runner.parameters)
        if self._connected:
            own["same_bits_on_every_cpu"] = False  # nobody knows what it computes with
        if parts := self._runner.part_sources:
            own["parts"] = {role: sha256(text).hexdigest() for role, text in parts.items()}
            own["same_bits_on_every_cpu"] = False
        disclosed = job.ranked and registry.benchmark(job.benchmark).protocol is not None
        return manifest(
            job.benchmark,
            self._runner.config,
            seed=None if job.ranked else job.seeds[0],
            seeds=job.seeds if disclosed else None,
            trials=len(job.seeds),
            controller=job.controller,
            program_sha256=sha256(source).hexdigest() if source else None,
            digest=digest,
            **own,
        )


def reason_of(trial: TrialOutcome) -> dict[str, Any]:
    """Return why a trial has no result, as fields of a RunOutcome; none if nothing failed."""
    program = trial.program
    if program is None:
        return {"failure": FailureReason.BENCHMARK_ERROR, "sentence": trial.divergence}
    if program.verdict is Verdict.OK:
        return {}
    return {
        "failure": FailureReason(program.verdict),
        "sentence": program.sentence,
        "traceback": program.traceback,
    }


def _usage(programs: Sequence[Outcome]) -> dict[str, float]:
    """Return what the program used over all trials: a report, no part of any score."""
    if not programs:
        return {}
    return {
        "cpu_s": sum(program.cpu_s for program in programs),
        "wall_s": sum(program.wall_s for program in programs),
        "memory_mib": max(program.memory_mib for program in programs),
    }


def _is_json(metrics: Mapping[str, Any]) -> bool:
    """Return whether the metrics are JSON, which has no NaN and no infinity."""
    try:
        json.dumps(metrics, allow_nan=False)
    except ValueError:
        return False
    return True


class _DigestingListener:
    """Forwards everything, and computes the digest of the rows that count."""

    def __init__(self, listener: Listener) -> None:
        self._listener = listener
        self.digest = Digest()
        self._before_trial = Digest()

    def rows(self, rows: NDArray[np.float64]) -> None:
        self.digest.add(rows)
        self._listener.rows(rows)

    def log(self, text: bytes) -> None:
        self._listener.log(text)

    def trial_ended(self, trial: int) -> None:
        self._before_trial = self.digest.copy()
        self._listener.trial_ended(trial)

    def trial_restarted(self, trial: int, reason: str) -> None:
        self.digest = self._before_trial.copy()
        self._listener.trial_restarted(trial, reason)
