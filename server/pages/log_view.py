"""What the page of a log says that those of runs do not."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from seamark.server.pages.metric_tables import SettingValue, Table
from seamark.server.runs.states import RunKind
from seamark.server.runs.views import RunView
from seamark.sim.benchmarks.benchmark import Benchmark
from seamark.sim.metrics.metric import Metric

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


def without_current(run: RunView, tables: Sequence[Table]) -> Sequence[Table]:
    """Return the tables of a run; of a log without a known current, under the name of the whole."""
    if not has_unknown_current(run):
        return tables
    return [replace(table, level=_PART, levels=(WHOLE,)) for table in tables]
