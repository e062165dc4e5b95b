"""Template filters: how pages write numbers, times and sizes."""

import json
import math
import time
from datetime import UTC, datetime
from functools import lru_cache
from typing import NamedTuple

from flask import Flask

from seamark.competitions import zones
from seamark.sandbox.languages import LANGUAGES
from seamark.server.runs.data.error_curve import UNITS, error_column
from seamark.server.runs.data.run_size import size
from seamark.server.runs.record.qualifier import qualifier
from seamark.server.runs.record.solutions import entry_name, solution, team
from seamark.server.runs.showing.views import RunView
from seamark.sim import registry

_ENDINGS = {1: "st", 2: "nd", 3: "rd"}  # of places
_STEPS = ((86_400, "day"), (3600, "hour"), (60, "minute"))


class _Headline(NamedTuple):
    unit: str
    changed: bool  # the scenario is not that of the leaderboard


def register(app: Flask) -> None:
    """Add the functions below, `solution`, `team`, `entry_name` and `qualifier` as filters."""
    of_runs = (solution, team, entry_name, qualifier, score_unit, error_unit, changed_scenario)
    of_scores = (score, signed)
    of_values = (number, plain, ordinal, duration, about, size, words, language)
    for function in (*of_runs, *of_scores, *of_values, utc, iso, ago, ahead, in_zone):
        app.add_template_filter(function)


def changed_scenario(run: RunView) -> bool:
    """Return whether the score of a run measures another scenario than the leaderboard."""
    return run.benchmark in registry.BENCHMARKS and _headline(run).changed


def error_unit(run: RunView) -> str:
    """Return the unit of the curve of the error of a run."""
    column = error_column(run.benchmark) if run.benchmark in registry.BENCHMARKS else None
    return "" if column is None else UNITS[column]


def score_unit(run: RunView) -> str:
    """Return the unit of the score of a run, or its name if that says more."""
    return _headline(run).unit if run.benchmark in registry.BENCHMARKS else ""


def _headline(run: RunView) -> _Headline:
    return _headline_of(run.benchmark, json.dumps(run.config, sort_keys=True))


@lru_cache(maxsize=1024)  # lists show many runs of few configurations; reading one takes 0.1 ms
def _headline_of(name: str, config: str) -> _Headline:
    benchmark = registry.benchmark(name)
    restored = benchmark.restore(json.loads(config))
    headline = benchmark.headline_of(restored)
    unit = headline.unit if headline.label == "Score" else headline.label
    return _Headline(unit, benchmark.changes_scenario(restored))


def score(value: float | None) -> str:
    """Return a score with two decimals, a small one with three."""
    if value is None:
        return "–"
    return f"{value:.{2 if abs(value) >= 1.0 else 3}f}".replace("-", "−")


def signed(value: float) -> str:
    """Return a difference of scores with its sign and three decimals."""
    return f"{value:+.3f}".replace("-", "−")


def number(value: object, digits: int = 3) -> str:
    """Return a number with `digits` significant digits; other values as text."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, list | tuple):
        return ", ".join(number(item, digits) for item in value)
    if isinstance(value, int | float):
        return _figures(value, digits).replace("-", "−") if math.isfinite(value) else "–"
    return "–" if value is None else str(value)


def plain(value: float | None) -> str:
    """Return a number without trailing zeros."""
    return "–" if value is None else f"{value:g}".replace("-", "−")


def language(name: str) -> str:
    """Return the label of a language of programs, also of one that an earlier version had."""
    return LANGUAGES[name].label if name in LANGUAGES else name


def ordinal(value: int) -> str:
    """Return a number as a place: 1st, 2nd, 11th."""
    tens = value // 10 % 10
    return f"{value}{'th' if tens == 1 else _ENDINGS.get(value % 10, 'th')}"


def _figures(value: float, digits: int) -> str:
    size = abs(value)
    if size >= 10 ** (digits - 1) or value == int(value):
        return f"{value:,.0f}".replace(",", "\u202f")
    return f"{value:.{digits}g}" if size < 1e-3 else f"{value:.{_decimals(size, digits)}f}"


def _decimals(size: float, digits: int) -> int:
    """Return the number of decimal places for so many significant digits."""
    return digits - 1 - math.floor(math.log10(size))


def utc(epoch_s: float) -> str:
    """Return a time for people."""
    return datetime.fromtimestamp(epoch_s, UTC).strftime("%d %b %Y, %H:%M UTC")


def iso(epoch_s: float) -> str:
    """Return a time in ISO 8601."""
    return datetime.fromtimestamp(epoch_s, UTC).isoformat(timespec="seconds")


def ago(epoch_s: float) -> str:
    """Return how long ago a time was; the date if it was more than a week ago."""
    passed = time.time() - epoch_s
    if passed > 7 * 86_400:
        return datetime.fromtimestamp(epoch_s, UTC).strftime("%d %b %Y")
    for length, name in _STEPS:
        count = int(passed // length)
        if count:
            return f"{count} {name}{'s' if count > 1 else ''} ago"
    return "just now"


def ahead(epoch_s: float) -> str:
    """Return how far ahead a time is, in the largest whole unit."""
    left = epoch_s - time.time()
    for length, name in _STEPS:
        count = int(left // length)
        if count:
            return f"in {count} {name}{'s' if count > 1 else ''}"
    return "in less than a minute"


def in_zone(epoch_s: float, zone: str) -> str:
    """Return a time as clocks in a zone (IANA) show it."""
    return zones.in_zone(epoch_s, zone).strftime("%a %d %b %Y, %H:%M")


def duration(seconds: float | None) -> str:
    """Return a duration in one or two units."""
    if seconds is None:
        return "–"
    if seconds < 9.95:
        return f"{seconds:.1f} s"
    if seconds < 59.5:
        return f"{seconds:.0f} s"
    minutes, rest = divmod(round(seconds), 60)
    if minutes < 60:
        return f"{minutes} min {rest} s" if rest else f"{minutes} min"
    hours, rest = divmod(minutes, 60)
    return f"{hours} h {rest} min" if rest else f"{hours} h"


def about(seconds: float) -> str:
    """Return an estimated duration as precisely as an estimate deserves."""
    if seconds < 55:
        return f"{max(5, 5 * round(seconds / 5))} s"
    minutes = max(1, round(seconds / 60))
    if minutes < 60:
        return f"{minutes} min"
    hours, rest = divmod(5 * round(minutes / 5), 60)
    return f"{hours} h {rest} min" if rest else f"{hours} h"


def words(name: str) -> str:
    """Return an identifier as words: "rmse_m" gives "rmse m"."""
    return name.replace("_", " ").replace("-", " ").strip()
