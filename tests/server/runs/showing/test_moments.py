"""Moments of a trial that a viewer jumps to."""

from pathlib import Path

import numpy as np

from seamark.server.runs.data.files import RunFiles
from seamark.server.runs.showing.moments import LOSSES_MAX, moments
from seamark.sim.recording.telemetry import (
    INDEX,
    ROUTE_INDEX,
    SEARCH_INDEX,
    WIDTH,
    Rows,
    width_for,
)

ROWS = 40_000  # more than is read at once


def _files(folder: Path, **columns: np.ndarray) -> RunFiles:
    table = np.zeros((ROWS, WIDTH))
    table[:, INDEX["t"]] = 0.05 * np.arange(ROWS)
    table[:, INDEX["tracker_ok"]] = 1.0
    for name, values in columns.items():
        table[:, INDEX[name]] = values
    files = RunFiles(folder, 1, 1)
    files.append_rows(table)
    return files


def test_levels_are_listed_in_the_order_in_which_they_ran(tmp_path: Path) -> None:
    files = _files(tmp_path, level=np.repeat([2.0, 0.0, 1.0, 0.0], ROWS // 4))

    found = moments(files, 0, "distance")["levels"]

    assert [(one["level"], one["t"]) for one in found] == [(2, 0), (0, 500), (1, 1000), (0, 1500)]


def test_the_largest_error_is_found_beside_values_that_are_missing(tmp_path: Path) -> None:
    distance = np.linspace(0.0, 1.0, ROWS)
    distance[30_000:] = np.nan

    found = moments(_files(tmp_path, distance=distance), 0, "distance")["largest_error"]

    assert found == {"column": "distance", "t": 0.05 * 29_999, "value": distance[29_999]}


def test_a_loss_is_where_the_tracker_begins_to_fail(tmp_path: Path) -> None:
    tracker_ok = np.ones(ROWS)
    tracker_ok[16_380:16_390] = 0.0  # across two reads
    tracker_ok[30_000:] = 0.0
    level = np.repeat([0.0, 1.0], [35_000, 5_000])  # lost at the start of the second level too

    found = moments(_files(tmp_path, tracker_ok=tracker_ok, level=level), 0, "distance")["losses"]

    assert found == [0.05 * 16_380, 0.05 * 30_000, 0.05 * 35_000]


def test_what_a_detector_still_looks_for_is_not_lost(tmp_path: Path) -> None:
    table = np.zeros((100, width_for(8, arm=True, work=True, search=True)))
    table[:, INDEX["t"]] = np.arange(100)
    table[:, INDEX["level"]] = np.repeat([0.0, 1.0], 50)
    table[[*range(10), *range(50, 60)], SEARCH_INDEX["searching"]] = 1.0
    table[[*range(10, 30), *range(60, 100)], INDEX["tracker_ok"]] = 1.0
    files = RunFiles(tmp_path, 1, 1)
    files.append_rows(table)

    assert moments(files, 0, "distance")["losses"] == [30.0]


def test_a_route_is_lost_where_the_vehicle_gets_farther_than_a_metre_off_it(tmp_path: Path) -> None:
    table = np.zeros((100, width_for(8, route=True)))  # without a tracker, which would be lost
    table[:, INDEX["t"]] = np.arange(100)
    table[:, INDEX["level"]] = np.repeat([0.0, 1.0], 50)
    table[:, ROUTE_INDEX["cross_track"]] = 0.9
    table[20:30, ROUTE_INDEX["cross_track"]] = 1.1
    table[70, ROUTE_INDEX["cross_track"]] = 2.5
    files = RunFiles(tmp_path, 1, 1)
    files.append_rows(table)

    found = moments(files, 0, "cross_track")

    assert found["losses"] == [20.0, 70.0]
    assert found["largest_error"] == {"column": "cross_track", "t": 70.0, "value": 2.5}


def test_a_route_is_completed_once_in_each_level_that_gets_to_its_end(tmp_path: Path) -> None:
    table = np.zeros((ROWS, width_for(8, route=True)))
    table[:, INDEX["t"]] = np.arange(ROWS)
    table[:, INDEX["level"]] = np.repeat([1.0, 0.0], ROWS // 2)
    table[:, ROUTE_INDEX["route_length"]] = 30.0
    table[:, ROUTE_INDEX["route_along"]] = 29.9
    table[16_000 : ROWS // 2, ROUTE_INDEX["route_along"]] = 29.96  # across two reads
    files = RunFiles(tmp_path, 1, 1)
    files.append_rows(table)

    assert moments(files, 0, "cross_track")["completed"] == [16_000.0]


def test_a_tracker_that_flickers_gives_a_list_of_bounded_length(tmp_path: Path) -> None:
    files = _files(tmp_path, tracker_ok=np.arange(ROWS) % 2)

    assert len(moments(files, 0, "distance")["losses"]) == LOSSES_MAX


def test_a_log_without_a_tracker_has_no_losses(tmp_path: Path) -> None:
    files = _files(tmp_path, tracker_ok=np.full(ROWS, np.nan))

    assert moments(files, 0, "distance")["losses"] == []


def test_a_touch_is_the_first_contact_of_a_level(tmp_path: Path) -> None:
    contact = np.zeros(ROWS)
    contact[[100, 101, 20_000, 35_010, 39_000]] = 3.0  # 20 000 is in a later read of level 0
    level = np.repeat([0.0, 1.0, 2.0], [30_000, 5_000, 5_000])

    found = moments(_files(tmp_path, contact_n=contact, level=level), 0, "distance")["touches"]

    assert found == [0.05 * 100, 0.05 * 35_010]


def test_stages_are_found_in_each_level_by_itself(tmp_path: Path) -> None:
    level = np.repeat([1.0, 0.0, 2.0], [10_000, 20_000, 10_000])
    files = _files(tmp_path, level=level, distance=np.arange(ROWS))

    def reached(rows: Rows) -> tuple[int, ...]:
        """Find a stage in the fifth row of a level, and another in the last of a long one."""
        return (5, len(rows) - 1) if len(rows) == 20_000 else (5,)

    stages = moments(files, 0, "distance", reached)["stages"]

    assert [(one["level"], one["stage"], one["t"]) for one in stages] == [
        (1, 0, 0.05 * 5),
        (0, 0, 0.05 * 10_005),
        (0, 1, 0.05 * 29_999),
        (2, 0, 0.05 * 30_005),
    ]


def test_a_trial_without_rows_has_no_moments(tmp_path: Path) -> None:
    files = _files(tmp_path)

    found = moments(files, 3, "distance")
    before_any = moments(RunFiles(tmp_path, 2, 1), 0, "cross_track")

    assert found == before_any == {"levels": [], "largest_error": None, "losses": [], "touches": []}
