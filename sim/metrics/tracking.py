"""Metrics of a tracker over one level, from its telemetry alone.

A picture succeeds if the tracker gives corners and their alignment error, the root mean square
distance of the four corners from the true ones, is at most the limit (POT-210, Liang et al. 2018:
precision at 5 px). "Lost" is an alignment error above 10 px (Lieberknecht et al. 2009). The first
picture of a level does not count: the tracker is told where the target is.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seamark.sim.metrics.metric import Metric
from seamark.sim.numerics.statistics import mean
from seamark.sim.recording.telemetry import INDEX, Rows

FAR_PX, NEAR_PX = 5.0, 1.0  # [px] limits of p@5 and p@1
LOST_PX = 10.0
FAILED_PERCENT = 50.0  # of p@5: a level with less is the first that the tracker fails
HELD_PERCENT = 95.0  # of p@5: a level with at least so much is held

METRICS: tuple[Metric, ...] = (
    Metric("p5_percent", "p@5", "%", "higher", meaning="pictures within 5 px"),
    Metric("p1_percent", "p@1", "%", "higher", meaning="pictures within 1 px"),
    Metric("corner_px", "Corner error", "px", "lower", meaning="mean of the pictures within 5 px"),
    Metric(
        "admitted_percent",
        "Lost and admitted",
        "%",
        "lower",
        meaning="pictures in which the tracker says that the target is lost",
    ),
    Metric(
        "not_admitted_percent",
        "Lost, not admitted",
        "%",
        "lower",
        meaning="pictures in which it says that it has the target and is more than 10 px off",
    ),
)
HELD = Metric("held", "Held", "", "higher", meaning="p@5 of at least 95 %")


def level_metrics(rows: Rows) -> dict[str, Any]:
    """Return the metrics of one level, name -> float; `corner_px` is None without any success."""
    asked = rows[1:]
    error = asked[:, INDEX["tracker_error"]]
    says_ok = asked[:, INDEX["tracker_ok"]] == 1.0
    # Comparisons with nan are False: an error that is no number is no success, and it is lost.
    within = {limit: says_ok & (error <= limit) for limit in (FAR_PX, NEAR_PX)}
    good = error[within[FAR_PX]].tolist()
    result: dict[str, Any] = {
        "p5_percent": _percent(within[FAR_PX]),
        "p1_percent": _percent(within[NEAR_PX]),
        "corner_px": mean(good) if good else None,
        "admitted_percent": _percent(~says_ok),
        "not_admitted_percent": _percent(says_ok & ~(error <= LOST_PX)),
    }
    result["held"] = result["p5_percent"] >= HELD_PERCENT
    return result


def failure_value(values: Sequence[float], p5_percent: Sequence[float]) -> float:
    """Return the first of the rising values, two or more, at which p@5 is below half.

    A tracker that never fails gets the value that would come next: more than one that fails last.
    """
    for value, share in zip(values, p5_percent, strict=True):
        if share < FAILED_PERCENT:
            return value
    return round(2.0 * values[-1] - values[-2], 9)


def held_value(values: Sequence[float], held: Sequence[bool]) -> float | None:
    """Return the last value up to which all levels are held; None if not even the first."""
    last = None
    for value, kept in zip(values, held, strict=True):
        if not kept:
            break
        last = value
    return last


def over_levels(levels: Sequence[Mapping[str, Any]]) -> dict[str, float | None]:
    """Return each metric over all levels, which have equally many pictures."""
    result: dict[str, float | None] = {
        metric.name: mean([level[metric.name] for level in levels])
        for metric in METRICS
        if metric.unit == "%"
    }
    errors = [level["p5_percent"] * (level["corner_px"] or 0.0) for level in levels]
    successes = mean([level["p5_percent"] for level in levels])
    result["corner_px"] = mean(errors) / successes if successes > 0.0 else None
    return result


def _percent(flags: NDArray[np.bool_]) -> float:
    return 100.0 * int(flags.sum()) / len(flags) if len(flags) else 0.0
