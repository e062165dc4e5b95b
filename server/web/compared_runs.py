"""The runs of a comparison, from the query string; for the page and the API alike."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from seamark.server.runs.showing.side_by_side import RUNS_MAX
from seamark.server.runs.showing.views import RunView
from seamark.server.web import access
from seamark.server.web.problems import Problem
from seamark.server.web.url_converters import row_id
from seamark.sim import registry


def ids_of(texts: Iterable[str]) -> list[int]:
    """Return the different ids in texts such as "1,2", in their order.

    Raises
    ------
    Problem
        invalid-request if something is no id, or if there are too many.
    """
    parts = [part.strip().removeprefix("#") for text in texts for part in text.split(",")]
    try:
        ids = list(dict.fromkeys(row_id(part) for part in parts if part))
    except ValueError:
        raise _refusal("Write the numbers of the runs with commas, such as 12,17.") from None
    if len(ids) > RUNS_MAX:
        raise _refusal(f"At most {RUNS_MAX} runs can be compared at once. Leave some out.")
    return ids


def runs_of(ids: Sequence[int]) -> list[RunView]:
    """Return the runs; refused as anywhere else if the viewer may not see one of them."""
    runs = [access.run_for(run_id) for run_id in ids]
    for run in runs:
        if run.benchmark not in registry.BENCHMARKS:
            raise _refusal(f"Run {run.id} is of {run.benchmark}, which this version does not have.")
    return runs


def _refusal(detail: str) -> Problem:
    return Problem("invalid-request", detail, errors={"runs": detail})
