"""A check of a program: compile, start, two simulated seconds, and what was seen."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seamark.sandbox.outcome import Outcome, ProgramEnded, Verdict
from seamark.server.checks import report
from seamark.server.checks.report import CheckOutcome
from seamark.server.runs import trial_limits
from seamark.sim import registry
from seamark.sim.recording.telemetry import INDEX, STEP_US
from seamark.worker.evaluation.evaluation import BENCHMARK_ERROR, Ending
from seamark.worker.evaluation.job import Job
from seamark.worker.evaluation.program_adapters import Compile, MakeBox
from seamark.worker.evaluation.trial import Enough, OneTrial, TrialListener

SIMULATED_S = 1.9  # [s] rows come by the second: those of two seconds end just above
LOG_MAX = 64 * 1024  # [B] kept of what the program prints
Rows = NDArray[np.float64]


class Glimpse:
    """A listener that keeps what a check shows; it may stand before another one."""

    def __init__(self) -> None:
        self.seen = CheckOutcome()
        self._log = bytearray()

    def rows(self, rows: Rows) -> None:
        """Keep how long each answer took."""
        self.seen.step_us += rows[:, STEP_US].tolist()
        self.seen.t_simulated = float(rows[-1, INDEX["t"]])

    def log(self, text: bytes) -> None:
        """Keep the end of what is printed."""
        self._log += text
        del self._log[:-LOG_MAX]

    def cut(self, trial: int, why: str) -> None:
        """Forget all: the host was slow and it is done again."""
        self.seen, self._log = CheckOutcome(), bytearray()

    def end(self, ending: Mapping[str, Any]) -> CheckOutcome:
        """Return everything; `ending` has the fields of `Ending`."""
        for name in ("verdict", "sentence", "traceback", "usage"):
            setattr(self.seen, name, ending[name])
        self.seen.output = self._log.decode("utf-8", "replace")
        return self.seen


class _Brief:
    """Passes on what a listener hears until it is enough."""

    def __init__(self, listener: TrialListener) -> None:
        self._listener = listener
        self._over = False

    def rows(self, rows: Rows) -> None:
        """Pass the rows on; raise Enough after two seconds of them."""
        if self._over:  # the rest that a trial delivers on its way out
            return
        self._listener.rows(rows)
        if rows[-1, INDEX["t"]] >= SIMULATED_S:
            self._over = True
            raise Enough

    def log(self, text: bytes) -> None:
        """Pass on what the program printed."""
        self._listener.log(text)

    def cut(self, trial: int, why: str) -> None:
        """Pass on that it is done again."""
        self._over = False
        self._listener.cut(trial, why)


def check(job: Job, listener: TrialListener, make_box: MakeBox, compile_program: Compile) -> Ending:
    """Run the first two simulated seconds of a job's first trial; no metrics, no manifest."""
    brief = _Brief(listener)
    one = OneTrial(job, make_box, compile_program, limits=trial_limits.CHECK)
    try:
        one.prepare(brief)
    except ProgramEnded as ended:
        return _ending(ended.outcome)
    end = one.run(0, brief)
    if end.outcome is None:
        return Ending(verdict=BENCHMARK_ERROR, sentence=end.lost)
    return _ending(end.outcome)


def _ending(outcome: Outcome) -> Ending:
    return Ending(
        verdict=str(outcome.verdict),
        sentence="" if outcome.verdict is Verdict.OK else outcome.sentence,
        traceback=outcome.traceback,
        usage={"cpu_s": outcome.cpu_s, "memory_mib": outcome.memory_mib},
    )


def answer_of(job: Job, seen: CheckOutcome) -> dict[str, Any]:
    """Return the document for what was seen, measured against what a whole run may use."""
    entry = registry.benchmark(job.benchmark)
    config = entry.read(job.config)
    trial_s = entry.trial_duration_s(config)
    steps_per_s = len(seen.step_us) / max(seen.t_simulated, 1.0)
    allowed_s = trial_limits.for_trial(trial_s).cpu_s / max(trial_s * steps_per_s, 1.0)
    return report.from_outcome(seen, step_allowed_us=allowed_s * 1e6)
