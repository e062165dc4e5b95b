"""Metrics of a detector over one level, from its telemetry; `detection` says what counts.

A class of which no object counted in a level has no average precision there, and is left out of
the mean over the classes.
"""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from seamark.sim.metrics.average_precision import (
    RECALLS,
    Ranked,
    average_precision,
    interpolated_precision,
    ranked,
)
from seamark.sim.metrics.detection import COUNTS, FALSE_ALARM, FIRST_DECOY, HIT
from seamark.sim.metrics.metric import (
    SUM,
    Aggregation,
    LevelMetric,
    Levels,
    Metric,
    MetricGroup,
    compute_all,
    weighted_by,
)
from seamark.sim.numerics.arrays import Array, Flags, Integers
from seamark.sim.numerics.statistics import mean, percentile
from seamark.sim.recording.telemetry import (
    ANSWER,
    OBJECT,
    Rows,
    answers_of,
    detections,
    objects_of,
)
from seamark.sim.vehicles.patterns import CLASSES, DECOYS, MARKERS

HELD_PERCENT = 50.0  # E: average precision from which a level is held
ALARMS_PER_MIN = 5.0  # [1/min] E: what somebody who checks each alarm has time for
BACKGROUND = "background"
LIES_ON = (*CLASSES, *DECOYS, BACKGROUND)  # rows of the confusion matrix

_MARKERS = [at for at, name in enumerate(CLASSES) if name in MARKERS]
_MINUTE_S = 60.0


@dataclass(frozen=True, slots=True)
class Threshold:
    """What a detector achieves with the answers from some confidence on."""

    confidence: float
    hits: int
    false_alarms: int


class Recognition:
    """The objects and answers of a level: (images, classes) and (images, slots)."""

    def __init__(self, rows: Rows, *, image_period_s: float, focal_px: float) -> None:
        columns = detections(rows)
        self._objects, self._answers = objects_of(columns), answers_of(columns)
        self.minutes = len(rows) * image_period_s / _MINUTE_S
        self.focal_px = focal_px
        outcome = self._of_answers("outcome")
        self.hit: Flags = outcome == HIT
        self.counting: Flags = self.hit | (outcome == FALSE_ALARM)
        self.label: Integers = self._of_answers("label").astype(np.int64)
        self.confidence = self._of_answers("confidence")

    def _of_answers(self, name: str) -> Array:
        values: Array = self._answers[:, :, ANSWER[name]]
        return values

    @cached_property
    def objects(self) -> list[int]:
        """How many objects of each class counted."""
        counts: list[int] = (self._objects[:, :, OBJECT["state"]] == COUNTS).sum(axis=0).tolist()
        return counts

    def of_class(self, number: int) -> tuple[Array, Flags, int]:
        """Return confidence and hit of the answers of a class, and how many objects it has."""
        mine = self.counting & (self.label == number)
        return self.confidence[mine], self.hit[mine], self.objects[number]

    def average_precision(self, number: int) -> float:
        """Return that of a class, 0 to 1; nan if none of its objects counted."""
        return average_precision(*self.of_class(number))

    @cached_property
    def ranked(self) -> Ranked:
        """The answers of all classes together, at the possible thresholds."""
        return ranked(self.confidence[self.counting], self.hit[self.counting]).at_thresholds()

    @cached_property
    def hits(self) -> int:
        """How many answers are hits."""
        return int(self.hit.sum())

    @cached_property
    def false_alarms(self) -> int:
        """How many are false alarms."""
        return int(self.counting.sum()) - self.hits

    def f_measures(self) -> Array:
        """Return the F measure at each threshold."""
        answered = self.ranked.hits + self.ranked.false_alarms
        result: Array = 2.0 * self.ranked.hits / (answered + sum(self.objects))
        return result

    @cached_property
    def quiet(self) -> Threshold | None:
        """The lowest threshold with few enough false alarms; None if no threshold has."""
        few = self.ranked.false_alarms <= ALARMS_PER_MIN * self.minutes
        last = int(few.sum()) - 1
        return Threshold(*(column[last].item() for column in self.ranked)) if last >= 0 else None

    def of_hits(self, name: str) -> Array:
        """Return a column of the object that each hit found, (hits,)."""
        images, slots = np.nonzero(self.hit)
        values: Array = self._objects[images, self.label[images, slots], OBJECT[name]]
        return values

    def errors_px(self) -> Array:
        """Return the corner error of each hit, (hits,) [px]."""
        return self._of_answers("error")[self.hit]

    @cached_property
    def marker_hits(self) -> Flags:
        """Which of the hits found a marker, (hits,)."""
        return np.isin(self.label[self.hit], _MARKERS)

    def marker_sides(self) -> Array:
        """Return the mean side of each marker that was found, (found,) [px]."""
        x, y = (
            np.stack([self.of_hits(f"{axis}{corner}") for corner in range(4)])[:, self.marker_hits]
            for axis in "xy"
        )
        dx, dy = (np.roll(along, -1, axis=0) - along for along in (x, y))
        first, second, third, fourth = np.sqrt(dx * dx + dy * dy)
        result: Array = 0.25 * (first + second + third + fourth)
        return result

    def of_markers(self, name: str) -> Array:
        """Return a column of each marker that was found, (found,)."""
        return self.of_hits(name)[self.marker_hits]

    def lies_on(self) -> Integers:
        """Return what each answer lies on, as an index of `LIES_ON`, (images, slots)."""
        on = self._of_answers("on").astype(np.int64)
        on[on >= FIRST_DECOY] += len(CLASSES) - FIRST_DECOY
        on[on < 0] = len(LIES_ON) - 1
        return on


def _over_known(description: str, combine: Callable[[Sequence[float]], float]) -> Aggregation:
    """Return an aggregation of the levels that have a value; None if none has."""

    def of(name: str, levels: Levels) -> float | None:
        known = [level[name] for level in levels if level[name] is not None]
        return combine(known) if known else None

    return Aggregation(f"{description} of the levels that have one", of)


_MEAN_KNOWN = _over_known("mean", mean)


def _known(value: float) -> float | None:
    return None if math.isnan(value) else value


def _extreme(values: Array, choose: Callable[[Iterable[float]], float]) -> float | None:
    return choose(values.tolist()) if len(values) else None


def _mean_precision(level: Recognition) -> float:
    """Return the mean of the average precision over the classes [%]; nan without any object."""
    known = [level.average_precision(number) for number in range(len(CLASSES))]
    return 100.0 * mean([value for value in known if not math.isnan(value)])


def _class_precision(number: int) -> Callable[[Recognition], float | None]:
    return lambda level: _known(100.0 * level.average_precision(number))


def _f_measure(level: Recognition) -> float:
    if not any(level.objects):
        return math.nan
    return float(level.f_measures().max(initial=0.0))


def _f_threshold(level: Recognition) -> float | None:
    if not level.hits:
        return None
    return float(level.ranked.confidence[level.f_measures().argmax()])


def _precision(level: Recognition) -> float | None:
    found = level.quiet
    return None if found is None else 100.0 * found.hits / (found.hits + found.false_alarms)


def _recall(level: Recognition) -> float | None:
    objects = sum(level.objects)
    hits = 0 if level.quiet is None else level.quiet.hits
    return 100.0 * hits / objects if objects else None


def _alarm_rate(level: Recognition) -> float:
    return level.false_alarms / level.minutes if level.minutes else math.nan


def _corner_px(level: Recognition) -> float | None:
    return _known(percentile(level.errors_px().tolist(), 0.5))


def _corner_m(level: Recognition) -> float | None:
    errors = level.errors_px() * level.of_hits("distance") / level.focal_px
    return _known(percentile(errors.tolist(), 0.5))


AP: LevelMetric[Recognition] = LevelMetric(
    name="ap_percent",
    label="Average precision",
    unit="%",
    better="higher",
    meaning="mean over the classes of the average precision at an intersection over union of 0.5",
    formula="100 x mean over the classes of mean over the recalls 0, 0.01, ..., 1 of the largest "
    "precision at that recall or above",
    compute=_mean_precision,
)
F_MEASURE: LevelMetric[Recognition] = LevelMetric(
    name="f_measure",
    label="F measure",
    unit="",
    better="higher",
    meaning="harmonic mean of precision and recall of all classes together, at the best threshold",
    formula="max over the thresholds of 2 hits / (answers + objects)",
    compute=_f_measure,
)
RECALL: LevelMetric[Recognition] = LevelMetric(
    name="recall_percent",
    label="Recall",
    unit="%",
    better="higher",
    meaning=f"with at most {ALARMS_PER_MIN:g} false alarms per minute",
    formula=f"100 x hits / objects, at the lowest threshold with at most {ALARMS_PER_MIN:g} false "
    "alarms per minute",
    compute=_recall,
    over=_MEAN_KNOWN,
)
_COMMON: tuple[LevelMetric[Recognition], ...] = (
    AP,
    F_MEASURE,
    LevelMetric(
        name="f_threshold",
        label="Threshold of the F measure",
        unit="",
        better="higher",
        meaning="confidence from which answers count where the F measure is largest",
        formula="the highest such threshold; none without a hit",
        compute=_f_threshold,
        over=_MEAN_KNOWN,
    ),
    RECALL,
    LevelMetric(
        name="precision_percent",
        label="Precision",
        unit="%",
        better="higher",
        meaning=f"with at most {ALARMS_PER_MIN:g} false alarms per minute",
        formula="100 x hits / answers, at the same threshold; none without an answer there",
        compute=_precision,
        over=_MEAN_KNOWN,
    ),
    LevelMetric(
        name="false_alarms_per_min",
        label="False alarms",
        unit="1/min",
        better="lower",
        meaning="without a threshold",
        formula="false alarms / duration of the level",
        compute=_alarm_rate,
    ),
    LevelMetric(
        name="hits",
        label="Hits",
        unit="",
        better="higher",
        meaning="without a threshold",
        formula="number of hits",
        compute=lambda level: float(level.hits),
        over=SUM,
    ),
    LevelMetric(
        name="hit_corner_px",
        label="Corner error of hits",
        unit="px",
        better="lower",
        meaning="median of the RMS corner error",
        formula="median over the hits of the RMS corner error; none without a hit",
        compute=_corner_px,
        over=weighted_by("hits"),
    ),
    LevelMetric(
        name="hit_corner_m",
        label="Corner error of hits, on the bottom",
        unit="m",
        better="lower",
        meaning="the same as a length at the distance of the object",
        formula="median over the hits of RMS corner error x distance / focal length in px",
        compute=_corner_m,
        over=weighted_by("hits"),
    ),
)
_BY_CLASS: tuple[LevelMetric[Recognition], ...] = tuple(
    LevelMetric(
        name=f"ap_{name}_percent",
        label=title,
        unit="%",
        better="higher",
        meaning="average precision",
        formula="as `ap_percent`; none if no object of the class counted",
        compute=_class_precision(number),
        over=_MEAN_KNOWN,
    )
    for number, (name, title) in enumerate(CLASSES.items())
)
_OF_MARKERS: tuple[LevelMetric[Recognition], ...] = (
    LevelMetric(
        name="marker_side_px",
        label="Smallest marker found",
        unit="px",
        better="lower",
        formula="min over the hits of ArUco markers and AprilTags of the mean true side",
        compute=lambda level: _extreme(level.marker_sides(), min),
        over=_over_known("minimum", min),
    ),
    LevelMetric(
        name="marker_angle_rad",
        label="Largest angle of a marker found",
        unit="rad",
        better="higher",
        formula="max over the same of the angle between line of sight and normal",
        compute=lambda level: _extreme(level.of_markers("angle"), max),
        over=_over_known("maximum", max),
    ),
    LevelMetric(
        name="marker_distance_m",
        label="Largest distance of a marker found",
        unit="m",
        better="higher",
        formula="max over the same of the distance from the camera",
        compute=lambda level: _extreme(level.of_markers("distance"), max),
        over=_over_known("maximum", max),
    ),
)
METRICS = (*_COMMON, *_BY_CLASS, *_OF_MARKERS)
HELD = Metric(
    "held", "Held", "", "higher", meaning=f"average precision of at least {HELD_PERCENT:g} %"
)
GROUP = MetricGroup("Detectors", _COMMON)
CLASS_GROUP = MetricGroup("Detectors: average precision of each class", _BY_CLASS)
MARKER_GROUP = MetricGroup("Detectors: markers, after Cesar et al. 2015", _OF_MARKERS)


def level_metrics(
    rows: Rows,
    metrics: Iterable[LevelMetric[Recognition]] = METRICS,
    *,
    image_period_s: float,
    focal_px: float,
) -> dict[str, Any]:
    """Return the metrics of one level, name -> float, or None where there is no such thing."""
    level = Recognition(rows, image_period_s=image_period_s, focal_px=focal_px)
    result: dict[str, Any] = compute_all(metrics, level)
    result["held"] = result[AP.name] >= HELD_PERCENT
    return result


def curve_metrics(rows: Rows) -> dict[str, float | None]:
    """Return average precision and F measure, which depend on neither time nor focal length."""
    level = Recognition(rows, image_period_s=math.nan, focal_px=math.nan)
    return compute_all((AP, F_MEASURE), level)


def precision_recall(rows: Rows) -> list[tuple[float, float]]:
    """Return recall and interpolated precision, mean over the classes, 0 to 1, for a chart.

    The mean of the precisions is the average precision. Empty if no object counted.
    """
    level = Recognition(rows, image_period_s=math.nan, focal_px=math.nan)
    classes = [level.of_class(number) for number in range(len(CLASSES))]
    curves = [interpolated_precision(*one).tolist() for one in classes if one[2]]
    if not curves:
        return []
    means = [mean(column) for column in zip(*curves, strict=True)]
    return list(zip(RECALLS.tolist(), means, strict=True))


def confusion(rows: Rows, *, threshold: float = 0.0) -> Integers:
    """Return how many answers of each class lie on what, (len(LIES_ON), classes).

    Ignored answers are left out, and those that are less confident than the threshold. The sum over
    the levels is that of a run.
    """
    level = Recognition(rows, image_period_s=math.nan, focal_px=math.nan)
    chosen = level.counting & (level.confidence >= threshold)
    counts = np.zeros((len(LIES_ON), len(CLASSES)), np.int64)
    np.add.at(counts, (level.lies_on()[chosen], level.label[chosen]), 1)
    return counts
