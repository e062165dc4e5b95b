"""How a run ended, in a few lines for a person."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

# The columns that say how the controller did; the others are in metrics.json.
TABLE = (
    *("level", "speed", "rmse_m", "p95_m", "rmse_px", "mean_x_px", "mean_y_px"),
    *("settling_s", "lost_percent", "points"),
    *("value", "optical_depth", "p5_percent", "p1_percent", "corner_px", "not_admitted_percent"),
)


def explain(run: Mapping[str, Any]) -> str:
    """Return the lines for a run as the HTTP interface shows it."""
    if run["state"] == "succeeded":
        return "\n".join(_success(run["result"] or {}, run.get("metrics") or {}))
    if run["state"] == "failed":
        return "\n".join(_failure(run["failure"] or {}))
    return "The run was cancelled."


def _success(result: Mapping[str, Any], metrics: Mapping[str, Any]) -> list[str]:
    lines = [f"Score {_figure(result.get('score'))}{_interval(result)}"]
    lines += own_score(metrics)
    lines += table(metrics)
    if result.get("digest"):
        lines.append(f"Digest {result['digest']}")
    return lines


def _interval(result: Mapping[str, Any]) -> str:
    low, high = result.get("score_low"), result.get("score_high")
    if low is None or high is None or low == high:
        return ""
    return f" (95 % interval {_figure(low)} to {_figure(high)})"


def own_score(metrics: Mapping[str, Any]) -> list[str]:
    """Return the line about the user's own expression, if there is one."""
    own = metrics.get("own_score")
    if not own:
        return []
    return [f"{own['expression']} = {_figure(own['value'])} {own['why']}".rstrip()]


def table(metrics: Mapping[str, Any]) -> list[str]:
    """Return the numbers per level, one line each."""
    levels = metrics.get("levels") or []
    if not levels:
        return []
    levels = [{**level, **(level.get("grid") or {})} for level in levels]
    grid = [name for name in levels[0].get("grid") or {} if name != "current_speed"]
    names = [*TABLE[:1], *grid, *(name for name in TABLE[1:] if name in levels[0])]
    rows = [names, *([_figure(level.get(name)) for name in names] for level in levels)]
    widths = [max(len(row[at]) for row in rows) for at in range(len(names))]
    return ["  ".join(cell.rjust(w) for cell, w in zip(row, widths, strict=True)) for row in rows]


def _figure(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, int | float) else "-"


def _failure(failure: Mapping[str, Any]) -> list[str]:
    lines = [f"Failed: {failure.get('title') or failure.get('cause')}"]
    for name in ("sentence", "remedy"):
        if failure.get(name):
            lines.append(str(failure[name]))
    if failure.get("traceback"):
        lines += ["", str(failure["traceback"]).rstrip()]
    if failure.get("log_tail"):
        lines += ["", "The end of its output:", str(failure["log_tail"]).rstrip()]
    return lines
