"""The differences of a rejudgement as CSV."""

from collections.abc import Iterable, Iterator
from typing import Any

from seamark.server.administration.rejudgements import Difference
from seamark.server.web import csv_export

_VALUES = ("state", "cause", "score", "digest")
COLUMNS = (
    *("run", "user", "kind"),
    *(f"{name}_{when}" for name in (*_VALUES, "rank") for when in ("before", "after")),
    *("metrics_changed", "first_metrics_changed"),
)


def lines(differences: Iterable[Difference]) -> Iterator[str]:
    """Yield a header and a line for each run whose result differs."""
    yield csv_export.lines(COLUMNS, ())
    yield csv_export.lines(COLUMNS, map(_row, differences), header=False)


def _row(difference: Difference) -> dict[str, Any]:
    row: dict[str, Any] = {
        "run": difference.run_id,
        "user": difference.user,
        "kind": difference.kind.value,
    }
    for name in _VALUES:
        row |= {
            f"{name}_before": difference.before.get(name),
            f"{name}_after": difference.after.get(name),
        }
    rank = difference.rank
    row |= {
        "rank_before": None if rank is None else rank.before,
        "rank_after": None if rank is None else rank.after,
    }
    first = "; ".join(difference.metrics)
    return row | {"metrics_changed": difference.metrics_count, "first_metrics_changed": first}
