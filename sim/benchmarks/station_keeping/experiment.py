"""Station keeping: a vehicle in closed loop above the target, in a current that a level sets."""

import math
from collections.abc import Mapping, Sequence
from typing import Any, TypeVar

from seamark.sim.benchmarks.in_current import InCurrent
from seamark.sim.benchmarks.level_area import held_up_to
from seamark.sim.engine.experiment import TrialScore
from seamark.sim.metrics.metric import Absent, LevelMetric, over_run
from seamark.sim.metrics.station_keeping import METRICS, level_metrics, overall
from seamark.sim.metrics.windows import LevelFacts, Window
from seamark.sim.numerics.statistics import mean
from seamark.sim.recording.telemetry import Rows
from seamark.sim.settings.station_keeping import StationKeepingSettings
from seamark.sim.vehicles import load

LOST = "The target was lost throughout a level."
Settings = TypeVar("Settings", bound=StationKeepingSettings)


class StationKeeping(InCurrent[Settings]):
    """A `seamark.sim.engine.experiment.Experiment` that compares position controllers.

    `further` are metrics that it computes beside those of every station-keeping benchmark.
    """

    def __init__(self, further: tuple[LevelMetric[Window], ...] = ()) -> None:
        self._metrics = (*METRICS, *further)

    def metrics(
        self, config: Settings, level: int, rows: Rows, *, absent: Absent = frozenset()
    ) -> dict[str, Any]:
        """Return the metrics of a level, and its coordinates if there is a grid."""
        grid = config.grid_point(level)
        metrics = level_metrics(rows, level_facts(config, level, absent), self._metrics)
        return metrics | ({"grid": grid} if grid else {})

    def trial_score(self, config: Settings, levels: Sequence[Mapping[str, Any]]) -> TrialScore:
        """Return the mean of the levels' points, 0 to 100.

        A trial can rank if that is finite and the target was not lost throughout any level.
        """
        score = mean([float(level["points"]) for level in levels])
        all_lost = any(level["whole_lost_percent"] >= 100.0 for level in levels)
        return TrialScore(
            score=score,
            level_held=held_up_to(levels),
            rankable=math.isfinite(score) and not all_lost,
            reason=LOST if all_lost else "",
            overall=over_run(self.overall_metrics(), levels),
        )

    def overall_metrics(self) -> tuple[LevelMetric[Any], ...]:
        """Return the metrics over all levels of a trial."""
        return overall(self._metrics)


def level_facts(
    config: StationKeepingSettings, level: int, absent: Absent = frozenset()
) -> LevelFacts:
    """Return what the metrics of a level need beside its telemetry."""
    vehicle = load(config.vehicle)
    forward, reverse = vehicle.curve.limits.value
    return LevelFacts(
        level=level,
        speed=config.level_values()[level],
        dt=config.control_period_s,
        settle_s=config.settle_s,
        limits_n=(forward, reverse),
        thrusters=len(vehicle.thrusters),
        absent=absent,
    )


EXPERIMENT: StationKeeping[StationKeepingSettings] = StationKeeping()
