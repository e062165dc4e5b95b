"""What is stored and shown of how the evaluation of a run ended."""

from typing import Any

from seamark.programs.failure_reasons import describe
from seamark.server.runs.data.error_curve import error_curve
from seamark.server.runs.data.files import RunFiles
from seamark.server.runs.ending.results import Report
from seamark.server.runs.record.states import RunState
from seamark.worker.ipc.outcomes import RunOutcome

LOG_TAIL = 2000  # [character] of the log shown with a failure


def of(
    outcome: RunOutcome,
    files: RunFiles,
    *,
    benchmark: str,
    progress: float,
    t_simulated: float,
    isolation: str | None,
) -> Report:
    """Return the report of an outcome, whose files are those that may be seen."""
    failure = outcome.failure
    detail: dict[str, Any] = {"usage": outcome.usage}
    if failure is not None:
        detail |= describe(failure, sentence=outcome.sentence)
        detail |= {"traceback": outcome.traceback, "log_tail": log_tail(files)}
        detail["t_reached"] = t_simulated
    return Report(
        state=RunState.SUCCEEDED if failure is None else RunState.FAILED,
        cause=failure,
        detail=detail,
        metrics=outcome.metrics,
        manifest=outcome.manifest,
        digest=outcome.digest,
        progress=progress,
        t_simulated=t_simulated,
        isolation=isolation,
        error_curve=error_curve(files, benchmark),
    )


def log_tail(files: RunFiles) -> str:
    """Return the end of what the program has printed."""
    return files.log_text()[-LOG_TAIL:]
