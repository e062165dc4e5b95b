"""The small curve of the error that is stored with a result, and its picture."""

import math
from pathlib import Path

import numpy as np

from seamark.server.pages.run.sparkline import segments
from seamark.server.runs.data.error_curve import POINTS, error_curve
from seamark.server.runs.data.files import RunFiles
from seamark.sim.recording.telemetry import INDEX, ROUTE_INDEX, WIDTH, width_for


def _files(data: Path, errors: list[float], trials: int = 1) -> RunFiles:
    """Return the files of a run with these distances in each trial."""
    (data / "runs").mkdir(exist_ok=True)
    files = RunFiles(data, 1, 1)
    for trial in range(trials):
        rows = np.zeros((len(errors), WIDTH))
        rows[:, INDEX["trial"]] = trial
        rows[:, INDEX["t"]] = 0.05 * np.arange(len(errors))
        rows[:, INDEX["distance"]] = np.array(errors) + trial
        files.append_rows(rows)
    return files


def test_the_curve_follows_the_error_of_the_first_trial(tmp_path: Path) -> None:
    errors = np.linspace(0.0, 3.2, 6400).tolist()

    curve = error_curve(_files(tmp_path, errors, trials=2), "currents-v2")

    assert curve is not None
    assert len(curve) == POINTS
    expected = np.linspace(0.05, 3.15, POINTS)
    assert all(
        value is not None and math.isclose(value, wanted, abs_tol=0.02)
        for value, wanted in zip(curve, expected, strict=True)
    )


def test_a_run_of_a_few_rows_has_as_many_points_and_one_without_rows_no_curve(
    tmp_path: Path,
) -> None:
    assert error_curve(_files(tmp_path, [1.0, math.nan, 3.0]), "currents-v2") == [1.0, None, 3.0]
    assert error_curve(RunFiles(tmp_path, 2, 1), "currents-v2") is None


def test_the_curve_of_a_route_is_the_distance_from_it(tmp_path: Path) -> None:
    (tmp_path / "runs").mkdir()
    rows = np.zeros((2, width_for(8, route=True)))
    rows[:, ROUTE_INDEX["cross_track"]] = 0.5, 2.0
    files = RunFiles(tmp_path, 1, 1)
    files.append_rows(rows)

    assert error_curve(files, "track-v1") == [0.5, 2.0]


def test_the_lines_of_the_picture_end_where_there_is_no_value() -> None:
    assert segments([0.0, 2.0, None, 1.0]) == ["0.0,22.0 32.0,2.0", "96.0,12.0"]
    assert segments(None) == []
