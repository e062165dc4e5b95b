"""A check of a program: compile it, start it, simulate two seconds, and record what happened."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from seamark.programs import check_report, parameters, trial_limits
from seamark.programs.check_report import CheckOutcome
from seamark.sandbox.outcome import ProgramEnded
from seamark.sim import registry
from seamark.sim.recording.telemetry import INDEX, STEP_US
from seamark.worker.evaluation.evaluation import reason_of
from seamark.worker.evaluation.job import Job
from seamark.worker.evaluation.program_adapters import Compile, MakeBox
from seamark.worker.evaluation.trial import StopTrial, TrialRunner
from seamark.worker.ipc.listener import Listener
from seamark.worker.ipc.outcomes import RunOutcome, TrialOutcome

SEED = 1  # the same for all checks, so that they are repeatable
# [s] rows come once per simulated second, so that those of two seconds end just above this
SIMULATED_S = 1.9
LOG_MAX = 64 * 1024  # [B] kept of what the program prints
Rows = NDArray[np.float64]


class CheckRecorder:
    """A listener that keeps what the report of a check shows."""

    def __init__(self) -> None:
        self._outcome = CheckOutcome()
        self._log = bytearray()

    def rows(self, rows: Rows) -> None:
        """Keep how long each answer took."""
        self._outcome.step_us += rows[:, STEP_US].tolist()
        self._outcome.t_simulated = float(rows[-1, INDEX["t"]])

    def log(self, text: bytes) -> None:
        """Keep the end of what is printed."""
        self._log += text
        del self._log[:-LOG_MAX]

    def trial_ended(self, trial: int) -> None:
        """Do nothing: a check ends within its first trial."""

    def trial_restarted(self, trial: int, reason: str) -> None:
        """Discard everything: the host was slow."""
        self._outcome, self._log = CheckOutcome(), bytearray()

    def report(self, job: Job, run: RunOutcome) -> dict[str, Any]:
        """Return the report, which compares the steps with what a whole run may use."""
        outcome = self._outcome
        if run.failure is not None:
            outcome.verdict, outcome.sentence = str(run.failure), run.sentence
        outcome.traceback, outcome.usage = run.traceback, run.usage
        outcome.output = self._log.decode("utf-8", "replace")
        entry = registry.benchmark(job.benchmark)
        trial_s = entry.trial_duration_s(entry.read(parameters.split(job.config)[0]))
        steps_per_s = len(outcome.step_us) / max(outcome.t_simulated, 1.0)
        allowed_s = trial_limits.for_trial(trial_s).cpu_s / max(trial_s * steps_per_s, 1.0)
        return check_report.from_outcome(outcome, step_allowed_us=allowed_s * 1e6)


class _TimeLimited:
    """Forwards to a listener, and stops the trial after two simulated seconds."""

    def __init__(self, listener: Listener) -> None:
        self._listener = listener
        self._stopped = False

    def rows(self, rows: Rows) -> None:
        """Forward the rows; raise StopTrial after two seconds of them."""
        if self._stopped:  # the rest that a trial delivers on its way out
            return
        self._listener.rows(rows)
        if rows[-1, INDEX["t"]] >= SIMULATED_S:
            self._stopped = True
            raise StopTrial

    def log(self, text: bytes) -> None:
        self._listener.log(text)

    def trial_ended(self, trial: int) -> None:
        self._listener.trial_ended(trial)

    def trial_restarted(self, trial: int, reason: str) -> None:
        self._stopped = False
        self._listener.trial_restarted(trial, reason)


def check(job: Job, listener: Listener, make_box: MakeBox, compile_program: Compile) -> RunOutcome:
    """Run the first two simulated seconds of a job's first trial; no metrics, no manifest."""
    limited = _TimeLimited(listener)
    runner = TrialRunner(job, make_box, compile_program, limits=trial_limits.CHECK)
    try:
        runner.compile(limited)
        trial = runner.run(0, limited)
    except ProgramEnded as ended:
        trial = TrialOutcome(program=ended.outcome)
    program = trial.program
    usage = {"cpu_s": program.cpu_s, "memory_mib": program.memory_mib} if program else {}
    return RunOutcome(usage=usage, **reason_of(trial))
