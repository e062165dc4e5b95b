"""What the page of a log says that those of runs do not."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from seamark.server.pages.run.metric_tables import Row, SettingValue, Table
from seamark.server.runs.record.states import RunKind
from seamark.server.runs.showing.views import RunView
from seamark.sim import registry
from seamark.sim.benchmarks.benchmark import Benchmark
from seamark.sim.metrics.metric import Metric

PIXELS = "px"
WHOLE = "whole log"  # in place of a current that nobody measured
_READ_GROUPS = ("Experiment", "Water and camera")
_PART = Metric("part", "Part", "", "higher")


@dataclass(frozen=True, slots=True)
class LogView:
    """Where a log came from, and what it lacks."""

    sha256: str
    measured: Sequence[str]
    derived: Sequence[str]
    absent: Sequence[str]
    resampled: bool
    period_s: float


def of_run(run: RunView) -> LogView | None:
    """Return what there is to say about a log; None of a simulated run."""
    if run.kind is not RunKind.LOG or not run.manifest:
        return None
    manifest = run.manifest
    return LogView(
        sha256=manifest["log"]["sha256"],
        measured=[name for name in manifest["measured"] if name not in {"trial", "level"}],
        derived=manifest["derived"],
        absent=manifest["absent"],
        resampled=manifest["resampled"],
        period_s=manifest["period_s"],
    )


def absent_columns(run: RunView) -> frozenset[str]:
    """Return the columns of the telemetry that a log does not have; none of a simulated run."""
    if run.kind is not RunKind.LOG:
        return frozenset()
    return frozenset((run.manifest or {}).get("absent", ()))


def tracks(run: RunView) -> bool:
    """Return whether a tracker saw the target.

    A log without corners cannot say that, and above a bottom with many objects there is none.
    """
    if run.kind is RunKind.LOG:
        return "tracker_ok" not in absent_columns(run)
    benchmark = registry.benchmark(run.benchmark)
    unused = benchmark.restore(run.config).unused_columns()
    return not benchmark.follows_route and "tracker_ok" not in unused


def key_number(run: RunView, tables: Sequence[Table], name: str) -> Row | None:
    """Return the metric that says most about a log, which has one part; None of a simulated run."""
    if run.kind is not RunKind.LOG:
        return None
    rows = (row for table in tables for row in table.rows if len(row.values) == 1)
    return next((row for row in rows if row.name == name), None)


def has_unknown_current(run: RunView) -> bool:
    """Return whether this is a log whose mapping names no current."""
    if run.kind is not RunKind.LOG:
        return False
    mapping = (run.manifest or {}).get("mapping", {})
    return "levels" not in mapping.get("settings", {})


def settings(
    run: RunView, benchmark: Benchmark, groups: Mapping[str, Sequence[SettingValue]]
) -> Mapping[str, Sequence[SettingValue]]:
    """Return the settings of a run; of a log those alone that its measuring reads."""
    if run.kind is not RunKind.LOG:
        return groups
    levels = benchmark.configuration.model_fields["levels"].title
    unknown = levels if has_unknown_current(run) else ""
    return {
        group: [one for one in groups[group] if one.title != unknown]
        for group in _READ_GROUPS
        if group in groups
    }


def measured(run: RunView, tables: Sequence[Table]) -> Sequence[Table]:
    """Return the tables of a run; of a log without the metrics that it has no columns for.

    Without a tracker, those in the image say nothing that those in metres do not. Without a known
    current, the values stand under the name of the whole log.
    """
    if run.kind is not RunKind.LOG:
        return tables
    unwanted = None if tracks(run) else PIXELS
    kept = [
        replace(table, rows=tuple(r for r in table.rows if _has_value(r) and r.unit != unwanted))
        for table in tables
    ]
    if has_unknown_current(run):
        kept = [replace(table, level=_PART, levels=(WHOLE,)) for table in kept]
    return [table for table in kept if table.rows]


def _has_value(row: Row) -> bool:
    return any(value is not None for value in row.values)
