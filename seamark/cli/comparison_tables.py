"""Runs side by side as tables for a terminal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any
from unicodedata import combining, east_asian_width

BEST = "*"


def tables(comparison: Mapping[str, Any]) -> str:
    """Return the tables of a comparison as the API shows it; a run may have a `label`."""
    labels = {run["id"]: run.get("label") or f"run {run['id']}" for run in comparison["runs"]}
    heads = ["", *labels.values()]
    blocks = [_scores(comparison["scores"], labels)]
    blocks += [comparison["note"]] if comparison["note"] else []
    if comparison["settings"]:
        rows = [
            [_title(row), *(value or "-" for value in row["values"])]
            for row in comparison["settings"]
        ]
        blocks.append(table("Settings that differ", heads, rows))
    if comparison["metrics"]:
        rows = [[_label(row), *_values(row)] for row in comparison["metrics"]]
        blocks.append(table(f"Metrics ({BEST} best)", heads, rows))
    return "\n\n".join(blocks)


def _scores(scores: Sequence[Mapping[str, Any]], labels: Mapping[int, str]) -> str:
    lines = ["Differences of scores"]
    for each in scores:
        value = "-" if each["difference"] is None else f"{each['difference']:+.4g}"
        if each["low"] is not None:
            value += f" (95 % interval {each['low']:+.4g} to {each['high']:+.4g})"
        names = f"{labels[each['run']]} - {labels[each['other']]}"
        lines.append(f"  {names}: {value}  {each['sentence']}")
    return "\n".join(lines)


def _title(row: Mapping[str, Any]) -> str:
    return f"{row['title']} [{row['unit']}]" if row["unit"] else str(row["title"])


def _label(row: Mapping[str, Any]) -> str:
    level = f" at {row['level']}" if row["level"] else ""
    return f"{row['label']}{level}" + (f" [{row['unit']}]" if row["unit"] else "")


def _values(row: Mapping[str, Any]) -> list[str]:
    return [
        "-" if value is None else f"{value:.4g}{BEST if at in row['best'] else ' '}"
        for at, value in enumerate(row["values"])
    ]


def cell_len(text: str) -> int:
    """Return how many cells of a terminal a text takes: wide characters take two."""
    return sum(2 if east_asian_width(c) in "WF" else 1 for c in text if not combining(c))


def table(title: str, heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a table with a title: the first column to the left, the others to the right."""
    lines = [heads, *rows]
    widths = [max(cell_len(row[at]) for row in lines) for at in range(len(heads))]
    return "\n".join([title, *(_line(row, widths) for row in lines)])


def _line(row: Sequence[str], widths: Sequence[int]) -> str:
    """Return a row: the first column to the left, the others to the right."""
    first, *others = zip(row, widths, strict=True)
    cells = [_padded(*first, after=True), *(_padded(*cell, after=False) for cell in others)]
    return "  " + "  ".join(cells).rstrip()


def _padded(text: str, width: int, *, after: bool) -> str:
    spaces = " " * (width - cell_len(text))
    return text + spaces if after else spaces + text
