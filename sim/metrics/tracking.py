"""Metrics of a tracker over one level, from its telemetry alone.

An image succeeds if the tracker reports corners and their alignment error, the root mean square
distance of the four corners from the true ones, is at most the limit (POT-210, Liang et al. 2018:
precision at 5 px). "Lost" is an alignment error above 10 px (Lieberknecht et al. 2009). The first
image of a level does not count: the tracker is initialised with the true corners.
"""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seamark.sim.metrics.metric import (
    Aggregation,
    LevelMetric,
    Levels,
    Metric,
    MetricGroup,
    compute_all,
)
from seamark.sim.numerics.statistics import mean
from seamark.sim.recording.telemetry import INDEX, Rows

FAR_PX, NEAR_PX = 5.0, 1.0  # [px] limits of p@5 and p@1
LOST_PX = 10.0
FAILED_PERCENT = 50.0  # p@5 below which the tracker fails a level
HELD_PERCENT = 95.0  # p@5 from which a level is held


class Images:
    """The images of a level that count."""

    def __init__(self, rows: Rows) -> None:
        self.error = rows[:, INDEX["tracker_error"]]  # (n,) [px]
        self.reported = rows[:, INDEX["tracker_ok"]] == 1.0  # the tracker reports the target

    @property
    def off(self) -> NDArray[np.bool_]:
        """In which images the target is lost by ground truth, (n,); a nan error counts as lost."""
        result: NDArray[np.bool_] = ~(self.error <= LOST_PX)
        return result

    def within(self, limit_px: float) -> NDArray[np.bool_]:
        """Return which images succeed, (n,); one with a nan error does not."""
        result: NDArray[np.bool_] = self.reported & (self.error <= limit_px)
        return result


def _corner_error(images: Images) -> float | None:
    errors = images.error[images.within(FAR_PX)].tolist()
    return mean(errors) if errors else None


def _corner_error_over_run(name: str, levels: Levels) -> float | None:
    errors = [level[P5.name] * (level[name] or 0.0) for level in levels]
    successes = mean([level[P5.name] for level in levels])
    return mean(errors) / successes if successes > 0.0 else None


def _precision(limit_px: float) -> LevelMetric[Images]:
    return LevelMetric(
        name=f"p{limit_px:g}_percent",
        label=f"p@{limit_px:g}",
        unit="%",
        better="higher",
        meaning=f"share of the images whose corners are within {limit_px:g} px of the true ones",
        formula=f"100 x images with corners at most {limit_px:g} px from the true ones / all but "
        "the first",
        compute=lambda images: percent(images.within(limit_px)),
    )


P5, P1 = _precision(FAR_PX), _precision(NEAR_PX)
CORNER_PX = LevelMetric(
    name="corner_px",
    label="Corner error",
    unit="px",
    better="lower",
    meaning=f"mean of the images within {FAR_PX:g} px",
    formula=f"mean of the RMS corner error of the images within {FAR_PX:g} px",
    compute=_corner_error,
    over=Aggregation(f"mean of all images within {FAR_PX:g} px", _corner_error_over_run),
)
COMMON: tuple[LevelMetric[Images], ...] = (P5, P1, CORNER_PX)
LOSSES: tuple[LevelMetric[Images], ...] = (
    LevelMetric(
        name="admitted_percent",
        label="Reported loss",
        unit="%",
        better="lower",
        meaning="images in which the tracker reports that it lost the target",
        formula="100 x images in which the tracker reports a loss / all but the first",
        compute=lambda images: percent(~images.reported),
    ),
    LevelMetric(
        name="not_admitted_percent",
        label="Unreported loss",
        unit="%",
        better="lower",
        meaning=f"images in which it reports the target and is more than {LOST_PX:g} px off",
        formula=f"100 x images more than {LOST_PX:g} px off without a report / all but the first",
        compute=lambda images: percent(images.reported & images.off),
    ),
)
METRICS = (*COMMON, *LOSSES)
HELD = Metric("held", "Held", "", "higher", meaning=f"p@{FAR_PX:g} of at least {HELD_PERCENT:g} %")
GROUP = MetricGroup("Trackers", COMMON)
LOSS_GROUP = MetricGroup("Trackers: losses in visibility-v1", LOSSES)


def level_metrics(rows: Rows, metrics: Iterable[LevelMetric[Images]] = METRICS) -> dict[str, Any]:
    """Return the metrics of one level, name -> float; `corner_px` is None without any success."""
    result: dict[str, Any] = compute_all(metrics, Images(rows[1:]))
    result["held"] = result[P5.name] >= HELD_PERCENT
    return result


def failure_value(values: Sequence[float], p5_percent: Sequence[float]) -> float:
    """Return the first of two or more increasing values at which p@5 is below `FAILED_PERCENT`.

    A tracker that never fails scores the value that would come next: more than one that fails at
    the last level.
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


def percent(flags: NDArray[np.bool_]) -> float:
    """Return the share of the images that are flagged [%]; 0 of none."""
    return 100.0 * int(flags.sum()) / len(flags) if len(flags) else 0.0
