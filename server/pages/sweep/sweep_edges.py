"""Whether the best point of a sweep lies at the edge of what was swept, and where to go on."""

from collections.abc import Mapping
from typing import Any

from seamark.server.runs.submission.sweep_axes import Axis, Value, numbers_of, shown
from seamark.server.runs.submission.sweeps import SweepView


def warnings(sweep: SweepView, entries: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """Return a sentence for each axis at an end of which the best point lies.

    There is none for choices, for an axis on which no value is better than another one, and where
    the range of the setting ends.

    Parameters
    ----------
    entries
        Name -> schema of a setting or parameter; one that is missing has no range.
    """
    best = sweep.best
    if best is None:
        return []
    pairs = zip(sweep.axes, best.values, strict=True)
    sentences = (
        _warning(axis, value, entries.get(axis.name, {}))
        for axis, value in pairs
        if _matters(sweep, axis)
    )
    return [sentence for sentence in sentences if sentence]


def _matters(sweep: SweepView, axis: Axis) -> bool:
    scores = {cell.run.score for cell in sweep.cells if cell.run and cell.run.score is not None}
    return len(scores) > 1 and numbers_of(axis.values) is not None


def _warning(axis: Axis, value: Value, entry: Mapping[str, Any]) -> str:
    numbers = [float(each) for each in axis.values]
    if float(value) == max(numbers) and not float(value) >= _end(entry, "aximum", float("inf")):
        extreme, wanted = "largest", "larger"
    elif float(value) == min(numbers) and not float(value) <= _end(entry, "inimum", -float("inf")):
        extreme, wanted = "smallest", "smaller"
    else:
        return ""
    title = entry.get("title", axis.name)
    point = f"{shown(value)} {entry.get('x-unit', '')}".rstrip()
    return (
        f"The best point has the {extreme} {title} of this sweep, {point}. "
        f"Try {wanted} values: a better point may lie beyond."
    )


def _end(entry: Mapping[str, Any], name: str, none: float) -> float:
    limit = entry.get(f"m{name}", entry.get(f"exclusiveM{name}", none))
    return float(limit)
