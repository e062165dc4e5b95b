"""Competitions of a server as text for a terminal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from datetime import datetime, timezone, tzinfo
from typing import Any
from zoneinfo import ZoneInfo

import click

from seamark.cli.comparison_tables import table
from seamark.sandbox.printable_text import printable_text

COLOURS = {"good": "green", "warning": "yellow", "problem": "red"}


def finding_line(level: str, sentence: str) -> str:
    """Return what a check has found, with its level in colour."""
    mark = click.style(f"{printable_text(level):<7}", fg=COLOURS.get(level))
    return f"{mark} {printable_text(sentence)}"


def overview(competition: Mapping[str, Any]) -> str:
    """Return a competition with the times of its rounds, in its zone and in the user's."""
    title = f"{competition['title']} ({competition['name']}), {competition['state']}"
    lines = [title, *([competition["question"]] if competition["question"] else [])]
    teams = "1 team" if competition["teams"] == 1 else f"{competition['teams']} teams"
    lines.append(f"Benchmark {competition['benchmark']}, {teams}")
    if competition["own_team"]:
        lines.append(f"Your team is {competition['own_team']}.")
    return printable_text("\n".join([*lines, "", _rounds(competition)]))


def _rounds(competition: Mapping[str, Any]) -> str:
    zone, own = zone_of(competition["zone"]), datetime.now().astimezone().tzinfo
    rows = []
    for one in competition["rounds"]:
        ends = [one["opens_at"], one["closes_at"]]
        state = "open" if one["accepts"] else "decided" if one["decided_at"] else ""
        quota = "-" if one["quota"] is None else str(one["quota"])
        row = [f"{one['number']} {one['kind']}", *(_time(at, zone) for at in ends)]
        rows.append([*row, *(_time(at, own) for at in ends), quota, str(one["trials"]), state])
    there, here = competition["zone"], "here"
    heads = ["Round", f"Opens ({there})", "Closes", f"Opens ({here})", "Closes"]
    return table("Rounds", [*heads, "Quota", "Trials", ""], rows)


def zone_of(name: str) -> tzinfo:
    """Return the time zone of a competition; UTC where this machine does not know it."""
    try:
        return ZoneInfo(name)
    except (LookupError, ValueError, OSError):
        return timezone.utc


def _time(at: float | None, zone: tzinfo | None) -> str:
    if at is None:
        return "-"
    try:
        return f"{datetime.fromtimestamp(at, zone):%Y-%m-%d %H:%M}"
    except (OverflowError, ValueError, OSError):
        return "?"


def board(found: Mapping[str, Any]) -> str:
    """Return the board of a round."""
    heads = ["Place", "Team", "Method", "Score", "95 % interval", "Run"]
    rows = [_row(row) for row in found["rows"]]
    title = f"Round {found['round']}"
    if found["hidden"]:
        title += ", hidden: the rows of your team alone"
    if not rows:
        return printable_text(f"{title}: no scores to show yet.")
    return printable_text(table(title, heads, [*rows, *map(_row, found["reference_entries"])]))


def _row(row: Mapping[str, Any]) -> Sequence[str]:
    place = "-" if row["place"] is None else str(row["place"])
    if row["place_low"] != row["place_high"]:
        place += f" ({row['place_low']}-{row['place_high']})"
    score = "-" if row["score"] is None else f"{row['score']:.4g}"
    interval = "-"
    if row["score_low"] is not None and row["score_high"] is not None:
        interval = f"{row['score_low']:.4g} to {row['score_high']:.4g}"
    team = row["team"] or "(reference entry)"
    return [place, team, row["method"], score, interval, str(row["run"])]
