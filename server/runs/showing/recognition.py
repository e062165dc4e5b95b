"""What a detector recognised in a run that has ended, from its rows.

Precision over recall at each level, what its answers lay on, how long it took, and examples.
"""

import json
import threading
from collections import defaultdict
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np

from seamark.server.runs.data.files import RunFiles
from seamark.server.runs.data.level_spans import level_spans
from seamark.server.runs.record.states import RunKind
from seamark.server.runs.showing import detection_examples
from seamark.server.runs.showing.detection_examples import KINDS, Example
from seamark.server.runs.showing.views import RunView
from seamark.sim import registry
from seamark.sim.metrics.average_precision import RECALLS
from seamark.sim.metrics.detection import COUNTS, HIT
from seamark.sim.metrics.recognition import LIES_ON, confusion, precision_recall
from seamark.sim.recording.telemetry import (
    ANSWER,
    INDEX,
    OBJECT,
    STEP_US,
    Rows,
    answers_of,
    detections,
    has_detections,
    objects_of,
)
from seamark.sim.vehicles.patterns import CLASSES, DECOYS

ROWS_MAX = 32_768  # that are read, 100 MB; a ranked run of patterns-v1 has a sixth
KEPT = 32  # answers in memory, of 30 KB
_DIGITS = 4  # of a precision
# One at a time: of many viewers who ask for the same run, all but the first find it.
_lock = threading.Lock()


@dataclass(frozen=True, slots=True)
class _Recorded:
    """The rows of a run that has ended; equal if it is the same run with the same rows."""

    run: int
    data_run: int
    attempt: int
    benchmark: str
    config: str
    rows: int
    first_trial: int  # of the curves: those before do not count for the score
    files: RunFiles = field(compare=False)


def recognition(run: RunView, files: RunFiles) -> dict[str, Any]:
    """Return the recognition of a run as JSON; without levels before its end, or of no detector.

    Reads at most `ROWS_MAX` rows, the first ones.
    """
    if not run.state.final or not has_detections(len(files.columns)):
        return _empty()
    config = json.dumps(run.config, sort_keys=True)
    identity = run.id, run.data_id, run.attempt, run.benchmark, config, files.row_count()
    with _lock:
        return _measured(_Recorded(*identity, _first_counted(run), files))


def _first_counted(run: RunView) -> int:
    """Return the first trial whose levels the metrics of a run are means of."""
    protocol = registry.benchmark(run.benchmark).protocol
    return protocol.reference_trials if run.kind is RunKind.RANKED and protocol else 0


def _empty() -> dict[str, Any]:
    return {
        "recalls": [],
        "levels": [],
        "labels": [],
        "classes": [],
        "lies_on": [],
        "confusion": [],
        "objects": [],
        "missed": [],
        "examples": {kind: [] for kind in KINDS},
        "images": 0,
        "recorded": 0,
    }


@lru_cache(maxsize=KEPT)
def _measured(recorded: _Recorded) -> dict[str, Any]:
    """Return the recognition, level by level: one is in memory at a time."""
    benchmark = registry.benchmark(recorded.benchmark)
    values = benchmark.restore(json.loads(recorded.config)).level_values()
    totals = _Totals()
    for first, after in level_spans(recorded.files, ended=True):
        if totals.images + after - first > ROWS_MAX:
            break
        rows = recorded.files.rows(first, after)
        totals.add(rows, float(values[int(rows[0, INDEX["level"]])]), recorded.first_trial)
    return {
        "recalls": RECALLS.round(2).tolist(),
        "levels": totals.levels(),
        "labels": list(CLASSES),
        "classes": list(CLASSES.values()),
        "lies_on": [_TITLES.get(name, name) for name in LIES_ON],
        "confusion": totals.confusion.tolist(),
        "objects": totals.objects.tolist(),
        "missed": (totals.objects - totals.hits).tolist(),
        "examples": {
            kind: [one.as_json() for one in detection_examples.best(examples)]
            for kind, examples in totals.examples.items()
        },
        "images": totals.images,
        "recorded": recorded.rows,
    }


_TITLES = CLASSES | DECOYS


class _Totals:
    """Sums over the levels of all trials."""

    def __init__(self) -> None:
        self.images = 0
        self.confusion = np.zeros((len(LIES_ON), len(CLASSES)), np.int64)
        self.objects, self.hits = (np.zeros(len(CLASSES), np.int64) for _ in range(2))
        self.examples: dict[str, list[Example]] = {kind: [] for kind in KINDS}
        self._curves: dict[float, list[list[float]]] = defaultdict(list)
        self._step_us: dict[float, list[float]] = defaultdict(list)

    def add(self, rows: Rows, value: float, first_trial: int) -> None:
        """Add one level of one trial, whose value is that on the axis of difficulty.

        Trials before `first_trial` have no part in the curves.
        """
        self.images += len(rows)
        self.confusion += confusion(rows)
        columns = detections(rows)
        answers = answers_of(columns)
        labels = answers[..., ANSWER["label"]][answers[..., ANSWER["outcome"]] == HIT]
        self.objects += (objects_of(columns)[:, :, OBJECT["state"]] == COUNTS).sum(axis=0)
        self.hits += np.bincount(labels.astype(np.int64), minlength=len(CLASSES))
        self._step_us[value] += rows[:, STEP_US].tolist()
        counts = rows[0, INDEX["trial"]] >= first_trial
        curve = [precision for _, precision in precision_recall(rows)] if counts else []
        self._curves[value] += [curve] if curve else []
        for kind, examples in detection_examples.of_level(rows, value).items():
            self.examples[kind] += examples

    def levels(self) -> list[dict[str, Any]]:
        """Return the means of each level over the trials, in increasing order of their values."""
        return [
            {
                "value": value,
                "precision": _mean_curve(self._curves[value]),
                "time_ms": {
                    "median": _milliseconds(np.median(step_us)),
                    "longest": _milliseconds(max(step_us)),
                },
            }
            for value, step_us in sorted(self._step_us.items())
        ]


def _mean_curve(curves: list[list[float]]) -> list[float]:
    return np.mean(curves, axis=0).round(_DIGITS).tolist() if curves else []


def _milliseconds(step_us: float) -> float:
    return round(1e-3 * float(step_us), 3)
