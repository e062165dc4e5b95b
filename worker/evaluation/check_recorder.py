"""What is recorded of a check, for its report. Importing it does not load the simulator."""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seamark.programs import check_report, parameters, trial_limits
from seamark.programs.check_report import CheckOutcome
from seamark.sim import registry
from seamark.sim.recording.telemetry import INDEX, STEP_US, has_detections
from seamark.worker.evaluation.job import Job
from seamark.worker.ipc.outcomes import RunOutcome

SEED = 1  # the same for all checks, so that they are repeatable
IMAGES = 5  # of a detector that its owner sees with the answers
LOG_MAX = 64 * 1024  # [B] kept of what the program prints
Rows = NDArray[np.float64]


class CheckRecorder:
    """A listener that keeps what the report of a check shows."""

    def __init__(self) -> None:
        self._outcome = CheckOutcome()
        self._log = bytearray()
        self._images: list[list[float | None]] = []

    def rows(self, rows: Rows) -> None:
        """Keep how long each answer took, and the first rows of a detector."""
        if has_detections(rows.shape[1]):
            self._images += [
                [value if math.isfinite(value) else None for value in row]
                for row in rows[: IMAGES - len(self._images)].tolist()
            ]
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
        self._outcome, self._log, self._images = CheckOutcome(), bytearray(), []

    def seen(self) -> dict[str, Any]:
        """Return what the images are rendered from: the seed, and the row of each as JSON."""
        return {"seed": SEED, "rows": self._images}

    def report(self, job: Job, run: RunOutcome) -> dict[str, Any]:
        """Return the report, which compares the steps with what a whole run may use."""
        outcome = self._outcome
        if run.failure is not None:
            outcome.verdict, outcome.sentence = str(run.failure), run.sentence
        outcome.traceback, outcome.usage = run.traceback, run.usage
        outcome.output = self._log.decode("utf-8", "replace")
        entry = registry.benchmark(job.benchmark)
        trial_s = entry.trial_duration_s(entry.restore(parameters.split(job.config)[0]))
        steps_per_s = len(outcome.step_us) / max(outcome.t_simulated, 1.0)
        allowed_s = trial_limits.for_trial(trial_s).cpu_s / max(trial_s * steps_per_s, 1.0)
        return check_report.from_outcome(outcome, step_allowed_us=allowed_s * 1e6)
