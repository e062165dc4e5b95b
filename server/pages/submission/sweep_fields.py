"""The sweep in the submission form: the fields `sweep-0-name`, `sweep-0-values` and so on."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from seamark.programs import configurations
from seamark.programs.parameters import Parameter
from seamark.server.programs.store import StoredProgram
from seamark.server.runs.submission import sweeps
from seamark.server.runs.submission.sweep_axes import AXES_MAX, RUNS_MAX, TEXT_MAX, Axis, read_axis
from seamark.server.runs.submission.validation import SubmissionRejected
from seamark.sim.benchmarks.benchmark import Benchmark


@dataclass(frozen=True, slots=True)
class Row:
    """The fields of one axis."""

    name: str
    values: str


def read(posted: Mapping[str, str]) -> list[Axis]:
    """Return the axes of a posted form, [] if it is no sweep; raises SubmissionRejected."""
    rows = [row for row in _rows(posted) if row.name and row.values]
    return [read_axis(row.name, row.values) for row in rows]


def shown(
    benchmark: Benchmark,
    program: StoredProgram | None,
    posted: Mapping[str, str],
    *,
    fixed: bool = False,
) -> dict[str, Any]:
    """Return the variables of the template; a `fixed` scenario offers no axis over its settings."""
    declared: tuple[Parameter, ...] = ()
    if program is not None:
        declared = configurations.declared_in(benchmark, program.language, program.parameters)
    rows = _rows(posted)
    return {
        "rows": rows,
        "open": any(row.name for row in rows),
        "choices": sweeps.sweepable(benchmark, declared, fixed=fixed),
        "runs": _count(posted),
        "runs_max": RUNS_MAX,
        "text_max": TEXT_MAX,
    }


def _count(posted: Mapping[str, str]) -> int:
    """Return how many runs the fields ask for; 0 without a sweep, or if they are wrong."""
    try:
        axes = read(posted)
    except SubmissionRejected:
        return 0
    return math.prod(len(axis.values) for axis in axes) if axes else 0


def _rows(posted: Mapping[str, str]) -> list[Row]:
    return [
        Row(
            posted.get(f"sweep-{index}-name", "").strip(),
            posted.get(f"sweep-{index}-values", "").strip(),
        )
        for index in range(AXES_MAX)
    ]
