"""The result of a run as lines for a terminal."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from seamark.sandbox.printable_text import printable_text

# Columns of the table of levels; the other metrics are in metrics.json.
COLUMNS = (
    *("level", "speed", "rmse_m", "p95_m", "rmse_px", "mean_x_px", "mean_y_px"),
    *("settling_s", "lost_percent", "points"),
    *("credit", "turned_deg", "time_s", "push_n", "hull_n"),
    *(
        "value",
        "optical_depth",
        "ap_percent",
        "f_measure",
        "hit_corner_px",
        "p5_percent",
        "p1_percent",
        "corner_px",
        "not_admitted_percent",
    ),
)


def summary(run: Mapping[str, Any]) -> str:
    """Return the lines for a run as the API shows it."""
    if run["state"] == "succeeded":
        refusal = [f"Not ranked. {run['not_ranked']}"] if run.get("not_ranked") else []
        return printable_text(
            "\n".join(_success(run["result"] or {}, run.get("metrics") or {}) + refusal)
        )
    if run["state"] == "failed":
        return printable_text("\n".join(_failure(run["failure"] or {})))
    return "The run was cancelled."


def exit_code(run: Mapping[str, Any]) -> int:
    """Return how a command ends with a run that has ended: 3 for a failure of the service."""
    if run["state"] == "succeeded":
        return 0
    return 3 if (run["failure"] or {}).get("cause") == "platform_error" else 1


def _success(result: Mapping[str, Any], metrics: Mapping[str, Any]) -> list[str]:
    lines = [f"Score {_number(result.get('score'))}{_interval(result)}"]
    lines += _parts(metrics)
    lines += custom_score(metrics)
    lines += level_table(metrics)
    if result.get("digest"):
        lines.append(f"Digest {result['digest']}")
    return lines


def _interval(result: Mapping[str, Any]) -> str:
    low, high = result.get("score_low"), result.get("score_high")
    if low is None or high is None or low == high:
        return ""
    return f" (95 % interval {_number(low)} to {_number(high)})"


def _parts(metrics: Mapping[str, Any]) -> list[str]:
    """Return the lines of a ranked run on reference and fresh trials."""
    reference, gap = metrics.get("reference"), metrics.get("gap")
    if not reference or not gap:
        return []
    of_gap = {"score_low": gap["low"], "score_high": gap["high"]}
    return [
        f"Reference score {_number(reference['score'])}{_interval(reference)}",
        f"Generalisation gap {_number(gap['value'])}{_interval(of_gap)}",
    ]


def custom_score(metrics: Mapping[str, Any]) -> list[str]:
    """Return the line of the custom score, if there is one."""
    custom = metrics.get("own_score")
    if not custom:
        return []
    return [f"{custom['expression']} = {_number(custom['value'])} {custom['why']}".rstrip()]


def level_table(metrics: Mapping[str, Any]) -> list[str]:
    """Return a table of the metrics, one line per level."""
    levels = metrics.get("levels") or []
    if not levels:
        return []
    levels = [{**level, **(level.get("grid") or {})} for level in levels]
    grid = [name for name in levels[0].get("grid") or {} if name != "current_speed"]
    names = [*COLUMNS[:1], *grid, *(name for name in COLUMNS[1:] if name in levels[0])]
    rows = [names, *([_number(level.get(name)) for name in names] for level in levels)]
    widths = [max(len(row[at]) for row in rows) for at in range(len(names))]
    return ["  ".join(cell.rjust(w) for cell, w in zip(row, widths, strict=True)) for row in rows]


def _number(value: object) -> str:
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
