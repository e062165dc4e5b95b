"""Rows of runs that evaluate once more what an earlier run evaluated."""

import time
from typing import Any

from seamark.server.database.tables import Run, RunFile, RunPart
from seamark.server.runs.record.states import RunState

# Never changed after the submission, and all that an evaluation depends on.
_SPECIFICATION = (
    *("benchmark", "kind", "config", "seed", "trials", "controller", "program_sha256"),
    *("program_name", "language", "program_parameters", "vehicle_sha256"),
)
_PART = ("role", "program_sha256", "program_name", "language", "program_parameters")


def copy_of(original: Run, owner: str, **changes: Any) -> Run:
    """Return a new queued run that evaluates the same, with some other columns; not inserted yet.

    `original` has its deferred columns loaded.
    """
    return Run(
        **{name: getattr(original, name) for name in _SPECIFICATION}
        | {
            "owner": owner,
            "expected_s": _expected_s(original),
            "state": RunState.QUEUED,
            "queued_at": time.time(),
            "data_bytes": original.data_bytes,
            "parts": [
                RunPart(**{name: getattr(part, name) for name in _PART}) for part in original.parts
            ],
            "files": [RunFile(setting=file.setting, sha256=file.sha256) for file in original.files],
        }
        | changes
    )


def _expected_s(run: Run) -> float | None:
    if run.started_at is None or run.finished_at is None:
        return run.expected_s
    return max(run.finished_at - run.started_at, 0.0)
