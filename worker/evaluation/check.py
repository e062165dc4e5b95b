"""A check of a program: compile it, start it, and simulate two seconds."""

from seamark.programs import trial_limits
from seamark.sandbox.outcome import ProgramEnded
from seamark.sim.recording.telemetry import INDEX
from seamark.worker.evaluation.check_recorder import Rows
from seamark.worker.evaluation.evaluation import reason_of
from seamark.worker.evaluation.job import Job
from seamark.worker.evaluation.program_adapters import Compile, MakeBox
from seamark.worker.evaluation.trial import StopTrial, TrialRunner
from seamark.worker.ipc.listener import Listener
from seamark.worker.ipc.outcomes import RunOutcome, TrialOutcome

# [s] rows come once per simulated second, so that those of two seconds end just above this
SIMULATED_S = 1.9


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
