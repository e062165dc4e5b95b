"""What a run is, in a few words: whatever shows its score elsewhere says them beside it."""

from collections.abc import Mapping
from typing import Any, Protocol

from seamark.server.runs.record.states import RunKind
from seamark.sim import registry
from seamark.sim.benchmarks.benchmark import Benchmark
from seamark.sim.settings.configuration import Configuration

LOG = "log of a real mission"
ENTRY = "entry of a competition"
NOT_ELIGIBLE = "not eligible for a rank"


class Qualified(Protocol):
    """What decides the words; a view of a run has it."""

    @property
    def benchmark(self) -> str: ...  # noqa: D102 - the attribute of tables.Run
    @property
    def kind(self) -> RunKind: ...  # noqa: D102
    @property
    def config(self) -> Mapping[str, Any]: ...  # noqa: D102
    @property
    def trials(self) -> int: ...  # noqa: D102
    @property
    def score(self) -> float | None: ...  # noqa: D102
    @property
    def rankable(self) -> bool | None: ...  # noqa: D102


def qualifier(run: Qualified) -> str:
    """Return how a run differs from a ranked one; empty for a ranked run that may have a rank.

    Such as "practice, 1 trial" or "practice, changed scenario with 2 of 5 levels of 60 s, 1 trial".
    """
    if run.kind is RunKind.LOG:
        return LOG
    if run.kind is RunKind.RANKED:
        return NOT_ELIGIBLE if run.score is not None and run.rankable is False else ""
    if run.kind is RunKind.ENTRY:
        return ENTRY
    trials = "1 trial" if run.trials == 1 else f"{run.trials} trials"
    return ", ".join(filter(None, ("practice", _scenario(run), trials)))


def _scenario(run: Qualified) -> str:
    if run.benchmark not in registry.BENCHMARKS:  # of an earlier version
        return ""
    benchmark = registry.benchmark(run.benchmark)
    config = benchmark.restore(run.config)
    parts = [_changes(benchmark, config)] if benchmark.changes_scenario(config) else []
    if config.ranking_errors():
        parts.append("a solution that cannot rank")
    return ", ".join(parts)


def _changes(benchmark: Benchmark, config: Configuration) -> str:
    usual = benchmark.configuration()
    levels, all_levels = config.level_values(), usual.level_values()
    duration_s = getattr(config, "level_duration_s", None)
    parts = []
    if levels != all_levels:
        fewer = len(levels) < len(all_levels) and set(levels) <= set(all_levels)
        parts.append(f"{len(levels)} of {len(all_levels)} levels" if fewer else _other(levels))
    if duration_s != getattr(usual, "level_duration_s", None):
        parts = [f"{' '.join(parts) or 'levels'} of {duration_s:g} s"]
    return " with ".join(("changed scenario", *parts))


def _other(levels: tuple[float, ...]) -> str:
    return "1 other level" if len(levels) == 1 else f"{len(levels)} other levels"
