"""Metrics of a tracker with its losses told apart, for the benchmarks from visibility-v2 on.

A loss is admitted if the tracker reports it; the last corners that it reported are then more than
`LOST_PX` off. If they are not, it gave up a target that it still had: a false loss. A loss that is
not reported is the dangerous one, since a vehicle would follow it.
"""

from collections.abc import Iterable
from typing import Any

from seamark.sim.metrics.metric import LevelMetric, MetricGroup, compute_all
from seamark.sim.metrics.tracking import (
    COMMON,
    HELD_PERCENT,
    LOST_PX,
    P5,
    Images,
    percent,
)
from seamark.sim.recording.telemetry import Rows

LOSSES: tuple[LevelMetric[Images], ...] = (
    LevelMetric(
        name="admitted_loss_percent",
        label="Reported loss",
        unit="%",
        better="lower",
        meaning=f"it reports a loss, and its last corners are more than {LOST_PX:g} px off",
        formula=f"100 x images in which the tracker reports a loss and the last corners that it "
        f"reported are more than {LOST_PX:g} px off / all",
        compute=lambda images: percent(~images.reported & images.off),
    ),
    LevelMetric(
        name="false_loss_percent",
        label="False loss",
        unit="%",
        better="lower",
        meaning=f"it reports a loss, though its last corners are within {LOST_PX:g} px",
        formula=f"100 x images in which the tracker reports a loss and the last corners that it "
        f"reported are within {LOST_PX:g} px / all",
        compute=lambda images: percent(~images.reported & ~images.off),
    ),
    LevelMetric(
        name="unreported_loss_percent",
        label="Unreported loss",
        unit="%",
        better="lower",
        meaning=f"it reports corners that are more than {LOST_PX:g} px off",
        formula=f"100 x images more than {LOST_PX:g} px off without a report / all",
        compute=lambda images: percent(images.reported & images.off),
    ),
)
METRICS = (*COMMON, *LOSSES)
LOSS_GROUP = MetricGroup("Trackers: losses in visibility-v2", LOSSES)


def followed_metrics(
    rows: Rows, metrics: Iterable[LevelMetric[Images]] = METRICS
) -> dict[str, Any]:
    """Return the metrics of a level on a path, whose first image starts the tracker."""
    return _measured(Images(rows[1:]), metrics)


def jump_metrics(rows: Rows, metrics: Iterable[LevelMetric[Images]] = METRICS) -> dict[str, Any]:
    """Return the metrics of a level of jumps: every first image of two starts the tracker."""
    return _measured(Images(rows[1::2]), metrics)


def _measured(images: Images, metrics: Iterable[LevelMetric[Images]]) -> dict[str, Any]:
    result: dict[str, Any] = compute_all(metrics, images)
    result["held"] = result[P5.name] >= HELD_PERCENT
    return result
