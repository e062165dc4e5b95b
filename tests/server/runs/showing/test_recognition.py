"""Curves, confusion and examples of a detector's run, from its rows."""

from itertools import count
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from seamark.server.runs.data.files import RunFiles
from seamark.server.runs.record.states import RunKind, RunState
from seamark.server.runs.showing import recognition as recognitions
from seamark.server.runs.showing.detection_examples import EXAMPLES, OF_CLASS
from seamark.server.runs.showing.recognition import recognition
from seamark.sim.metrics.recognition import AP, level_metrics
from seamark.sim.recording.telemetry import INDEX, STEP_US, Rows
from seamark.sim.vehicles.patterns import CLASSES
from tests.sim.metrics.detector_rows import Answered, Image, rectangle, rows_of, seen

BOX, PIPE, ROCK = (
    rectangle(10, 10, 80, 40),
    rectangle(200, 100, 60, 30),
    rectangle(300, 200, 50, 50),
)
CLEAR = Image({"box": seen(BOX), "pipe": seen(PIPE, 0.7)}, [Answered("box", BOX, 0.9)])
FOOLED = Image(
    {"box": seen(BOX), "pipe": seen(PIPE, 0.9)},
    [Answered("amphora", ROCK, 0.8), Answered("box", BOX, 0.3)],
    {"rock": ROCK},
)
NOTHING = Image({"box": seen(BOX)}, [])


_numbers = count(1)  # the answers of a run are kept


def _run(data: Path, levels: list[list[Rows]], **changes: Any) -> tuple[Any, RunFiles]:
    """Return a run of patterns-v1 with the rows of each level of each trial."""
    (data / "runs").mkdir()
    number = next(_numbers)
    files = RunFiles(data, number, 1)
    for trial, of_levels in enumerate(levels):
        for level, rows in enumerate(of_levels):
            rows[:, INDEX["trial"]], rows[:, INDEX["level"]] = trial, level
            rows[:, INDEX["t"]] = 10.0 * level + 0.5 * np.arange(len(rows))
            rows[:, STEP_US] = 1000.0 * (1.0 + np.arange(len(rows)))
            files.append_rows(rows)
    values: dict[str, Any] = {
        "id": number,
        "data_id": number,
        "attempt": 1,
        "state": RunState.SUCCEEDED,
        "kind": RunKind.PRACTICE,
        "benchmark": "patterns-v1",
        "config": {"optical_depths": [0.0, 3.0]},
    }
    return SimpleNamespace(**values | changes), files


def test_the_mean_height_of_a_curve_is_the_average_precision_over_the_trials(
    tmp_path: Path,
) -> None:
    trials = [[rows_of([CLEAR, FOOLED]), rows_of([NOTHING])] for _ in range(2)]
    trials[1][0] = rows_of([CLEAR, NOTHING, FOOLED])

    levels = recognition(*_run(tmp_path, trials))["levels"]

    expected = [
        level_metrics(trial[0], image_period_s=0.5, focal_px=200.0)[AP.name] for trial in trials
    ]
    assert [level["value"] for level in levels] == [0.0, 3.0]
    assert 100.0 * np.mean(levels[0]["precision"]) == pytest.approx(np.mean(expected), abs=0.01)
    assert set(levels[1]["precision"]) == {0.0}
    assert levels[0]["time_ms"] == {"median": 2.0, "longest": 3.0}


def test_the_curves_of_a_ranked_run_are_those_of_its_fresh_trials(tmp_path: Path) -> None:
    reference = [[rows_of([CLEAR])] for _ in range(8)]
    fresh = [[rows_of([NOTHING])]]

    found = recognition(*_run(tmp_path, [*reference, *fresh], kind=RunKind.RANKED))

    assert set(found["levels"][0]["precision"]) == {0.0}
    assert found["images"] == 9


def test_confusion_and_missed_objects_are_counted_over_all_levels(tmp_path: Path) -> None:
    found = recognition(*_run(tmp_path, [[rows_of([CLEAR, FOOLED]), rows_of([NOTHING])]]))

    at = found["labels"].index
    assert found["confusion"][found["lies_on"].index("Rock")][at("amphora")] == 1
    assert found["confusion"][at("box")][at("box")] == 2
    assert (found["objects"][at("box")], found["missed"][at("box")]) == (3, 1)
    assert (found["objects"][at("pipe")], found["missed"][at("pipe")]) == (2, 2)


def test_examples_are_the_surest_alarms_the_clearest_misses_and_the_least_sure_hits(
    tmp_path: Path,
) -> None:
    found = recognition(*_run(tmp_path, [[rows_of([CLEAR, FOOLED]), rows_of([NOTHING])]]))

    alarms, misses, hits = (found["examples"][kind] for kind in ("false_alarms", "misses", "hits"))
    assert [(one["label"], one["confidence"], one["lies_on"]) for one in alarms] == [
        ("amphora", 0.8, "Rock")
    ]
    # the pipe where more of it was visible; in clear water before the box in turbid water
    assert [(one["label"], one["level"], one["t"]) for one in misses] == [
        ("pipe", 0, 0.5),
        ("box", 1, 10.0),
    ]
    assert misses[0]["corners"] == PIPE.tolist()
    assert [(one["label"], one["confidence"]) for one in hits] == [("box", 0.3)]


@pytest.mark.parametrize(("classes", "shown"), [(8, EXAMPLES), (3, 3 * OF_CLASS)])
def test_examples_are_few_of_each_class_and_few_in_all(
    tmp_path: Path, classes: int, shown: int
) -> None:
    labels = list(CLASSES)[:classes]
    every = [Answered(label, rectangle(30 * at, 200, 20, 20)) for at, label in enumerate(labels)]
    trials = [[rows_of([Image({"box": seen(BOX)}, every)])] for _ in range(4)]

    alarms = recognition(*_run(tmp_path, trials))["examples"]["false_alarms"]

    found = [one["label"] for one in alarms]
    assert len(found) == shown
    assert {found.count(label) for label in labels} == {shown // classes}


def test_a_run_that_has_not_ended_has_no_levels_yet(tmp_path: Path) -> None:
    run, files = _run(tmp_path, [[rows_of([CLEAR])]], state=RunState.RUNNING)

    assert recognition(run, files)["levels"] == []


def test_of_a_run_with_more_rows_than_are_read_the_first_levels_are_shown(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(recognitions, "ROWS_MAX", 3)
    trials = [[rows_of([CLEAR, CLEAR]), rows_of([CLEAR, CLEAR])]]

    found = recognition(*_run(tmp_path, trials))

    assert (found["images"], found["recorded"]) == (2, 4)
    assert [level["value"] for level in found["levels"]] == [0.0]
