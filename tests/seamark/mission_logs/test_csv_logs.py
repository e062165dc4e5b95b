"""A log as CSV: measured as the run that it came from, or refused with the line at fault."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from seamark.mission_logs.mapping import LogMapping
from seamark.mission_logs.measuring import measure
from seamark.mission_logs.result import LogRefused
from seamark.sim.recording.telemetry import INDEX, STEP_US
from tests.seamark.mission_logs.conftest import (
    CORNERS,
    POSE,
    SETTINGS,
    Measure,
    Run,
    telemetry_csv,
)

MINIMAL = ("level", "t", *POSE, *CORNERS)


def test_the_telemetry_of_a_run_has_the_metrics_of_that_run(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "telemetry.csv"
    path.write_text(telemetry_csv(run.rows))
    mapping = LogMapping.model_validate({"settings": SETTINGS})

    found = measure(path, mapping, benchmark="currents-v1")

    same = {"score", "overall", "measures", "levels"}
    assert {name: found.metrics[name] for name in same} == {
        name: run.metrics[name] for name in same
    }
    kept = np.delete(run.rows, STEP_US, axis=1)
    assert np.array_equal(np.delete(found.rows, STEP_US, axis=1), kept, equal_nan=True)


def test_pose_and_corners_imply_what_the_simulator_wrote_bit_for_bit(
    run: Run, measured: Measure
) -> None:
    found = measured({name: run.column(name) for name in MINIMAL})

    implied = ("target_x", "target_y", "tracked_x", "tracked_y", "tracker_error", "distance")
    for name in (*implied, "error_x_px", "error_y_px", "distance_px", "tracker_ok"):
        assert np.array_equal(found.rows[:, INDEX[name]], run.column(name)), name
    levels = run.metrics["levels"]
    for metric in ("points", "rmse_m", "p95_px", "lost_percent", "whole_vrx_m", "settling_s"):
        assert [level[metric] for level in found.metrics["levels"]] == [
            level[metric] for level in levels
        ]


def test_metrics_without_their_columns_are_none_and_name_the_columns(
    run: Run, measured: Measure
) -> None:
    found = measured({name: run.column(name) for name in MINIMAL})

    level, missing = found.metrics["levels"][0], found.metrics["not_measured"]
    assert level["collisions"] is level["energy_n15_s"] is level["variation_m_s"] is None
    assert missing["collisions"] == ["contact_n"]
    assert missing["variation_m_s"] == ["ref_u", "ref_v", "ref_w"]
    assert "rmse_m" not in missing
    assert found.manifest["kind"] == "measured log, not simulated"
    assert found.metrics["rankable"] is False


def test_corners_alone_are_measured_in_pixels(run: Run, measured: Measure) -> None:
    single = run.level(1)
    columns: dict[str, Any] = {name: single.column(name) for name in ("t", *CORNERS)}
    columns |= {f"true_{name}": single.column(name) + 1.0 for name in CORNERS}

    found = measured(columns, {"settings": {"settle_s": 0.0}})

    level = found.metrics["levels"][0]
    assert found.rows[:, INDEX["tracker_error"]] == pytest.approx(np.full(60, np.sqrt(2.0)))
    assert level["rmse_px"] == pytest.approx(
        np.sqrt(np.mean(found.rows[:, INDEX["distance_px"]] ** 2))
    )
    assert level["rmse_m"] is None
    assert found.metrics["score"] is None


def test_a_level_without_a_known_current_has_no_score(run: Run, measured: Measure) -> None:
    single = run.level(1)

    found = measured(
        {name: single.column(name) for name in MINIMAL[1:]}, {"settings": {"settle_s": 1.0}}
    )

    assert found.metrics["score"] is None
    assert found.metrics["levels"][0]["rmse_m"] == run.metrics["levels"][1]["rmse_m"]


def test_names_and_units_of_the_mapping_are_converted(run: Run, measured: Measure) -> None:
    single = run.level(0)
    named = {f"my {name}": single.column(name) for name in POSE}
    named["heading"] = np.rad2deg(named.pop("my yaw"))
    named["stamp"] = 1000.0 * single.column("t")
    columns = {name: f"my {name}" for name in POSE[:-1]} | {
        "yaw": {"name": "heading", "unit": "deg"},
        "t": {"name": "stamp", "unit": "ms"},
    }

    found = measured(named, {"columns": columns, "settings": {"settle_s": 1.0}})

    assert found.rows[:, INDEX["yaw"]] == pytest.approx(single.column("yaw"), abs=1e-15)
    assert found.manifest["period_s"] == 0.05


def test_a_log_in_enu_about_another_place_is_measured_as_the_same_path(
    run: Run, measured: Measure
) -> None:
    single = run.level(1)
    x, y, z, roll, pitch, yaw = (single.column(name) for name in POSE)
    columns = {"t": single.column("t"), "x": y + 500.0, "y": x - 40.0, "z": -z + 3.0}
    columns |= {"roll": roll, "pitch": -pitch, "yaw": 0.5 * np.pi - yaw}
    place = {"position": [500.0, -40.0, -4.87 + 3.0], "heading": 0.5 * np.pi}

    found = measured(columns, {"frame": "ENU", "target": place, "settings": {"settle_s": 1.0}})

    assert found.rows[:, INDEX["x"] : INDEX["yaw"] + 1] == pytest.approx(
        single.rows[:, INDEX["x"] : INDEX["yaw"] + 1], abs=1e-12
    )
    assert found.metrics["levels"][0]["rmse_m"] == pytest.approx(
        run.metrics["levels"][1]["rmse_m"], abs=1e-9
    )


def _without_row(columns: dict[str, Any]) -> dict[str, Any]:
    return {name: np.delete(column, 7) for name, column in columns.items()}


def _swapped(columns: dict[str, Any]) -> dict[str, Any]:
    order = np.arange(len(columns["t"]))
    order[[7, 8]] = order[[8, 7]]
    return {name: column[order] for name, column in columns.items()}


def _with(name: str, value: float) -> Any:
    def changed(columns: dict[str, Any]) -> dict[str, Any]:
        columns[name] = columns[name].copy()
        columns[name][7] = value
        return columns

    return changed


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (_without_row, "Between line 8 and line 9 of the file 0.1 s pass instead of 0.05 s"),
        (_swapped, "Line 10 of the file is not later than the one before it"),
        (_with("yaw", np.nan), "Line 9: yaw is missing or nan"),
        (_with("x", np.inf), "Line 9: x is infinite"),
        (_with("corner_3", -np.inf), "Line 9: corner_3 is infinite"),
        (lambda columns: {"clock": columns["t"]}, "The file has no column t"),
        (lambda columns: {"t": columns["t"], "x": columns["x"]}, "neither a whole pose"),
        (lambda columns: columns | {"t": 100.0 * columns["t"]}, "The usual interval is 5 s"),
    ],
)
def test_what_is_wrong_with_a_log_is_said_with_its_line(
    run: Run, measured: Measure, change: Any, sentence: str
) -> None:
    single = run.level(0)
    columns = change({name: single.column(name) for name in MINIMAL[1:]})

    with pytest.raises(LogRefused, match=sentence):
        measured(columns, {"settings": {"settle_s": 1.0}})


def test_a_gap_is_filled_only_as_the_mapping_says(run: Run, measured: Measure) -> None:
    single = run.level(0)
    columns = _without_row({name: single.column(name) for name in MINIMAL[1:]})
    time = {"period_s": 0.05, "max_gap_s": 0.11}

    found = measured(columns, {"settings": {"settle_s": 1.0}, "time": time})

    assert found.manifest["resampled"] is True
    assert np.array_equal(found.rows[7, :8], found.rows[6, :8]) is False  # the time goes on
    assert found.rows[7, INDEX["x"]] == found.rows[6, INDEX["x"]]
    with pytest.raises(LogRefused, match=r"no value within 0.04 s before 0.350 s"):
        measured(columns, {"time": time | {"max_gap_s": 0.04}})


@pytest.mark.parametrize(
    ("mapping", "sentence"),
    [
        ('frame = "NWU"', "frame: Input should be 'NED' or 'ENU'"),
        ('[columns]\nheading = "h"', "heading is no column of the telemetry"),
        ('[columns]\nyaw = {name = "h", unit = "m"}', "yaw is in rad, not in m"),
        ('[columns]\nyaw = {name = "h", unit = "gon"}', "the unit 'gon' is none of"),
        ("a = [", "neither TOML nor JSON"),
        ("{" * 9000, "neither TOML nor JSON"),
        ("#" * 20_000, "longer than 16384 characters"),
        ("speed = 1", "speed: Extra inputs are not permitted"),
        ("[time]\nperiod_s = inf", "time.period_s"),
    ],
)
def test_a_wrong_mapping_is_refused_with_its_place(mapping: str, sentence: str) -> None:
    with pytest.raises(LogRefused, match=sentence):
        LogMapping.parse(mapping)
