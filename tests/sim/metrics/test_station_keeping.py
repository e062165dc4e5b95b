"""Metrics against cases that a person can compute, and against laws."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from seamark.sim.metrics.metric import over_run
from seamark.sim.metrics.station_keeping import (
    METRICS,
    SETTLING,
    level_metrics,
    overall,
    points,
    settling_time,
)
from seamark.sim.metrics.windows import LevelFacts
from seamark.sim.recording.telemetry import INDEX, WIDTH, Rows

FACTS = LevelFacts(level=1, speed=0.2, dt=0.5, settle_s=1.0, limits_n=(100.0, 80.0))


def rows_of(distances: list[float], **columns: list[float]) -> Rows:
    rows = np.zeros((len(distances), WIDTH))
    rows[:, INDEX["distance"]] = distances
    rows[:, INDEX["tracker_ok"]] = 1.0
    for name, values in columns.items():
        rows[:, INDEX[name]] = values
    return rows


def test_settled_metrics_ignore_the_settle_window() -> None:
    result = level_metrics(rows_of([9.0, 9.0, 0.3, 0.4]), FACTS)

    assert result["rmse_m"] == pytest.approx(math.sqrt((0.09 + 0.16) / 2))
    assert result["mae_m"] == pytest.approx(0.35)
    assert result["max_m"] == 0.4
    assert result["whole_max_m"] == 9.0
    assert result["whole_mae_m"] == pytest.approx(18.7 / 4)


def test_iae_ise_and_itae_are_what_their_names_say() -> None:
    result = level_metrics(rows_of([0.0, 1.0, 2.0]), FACTS)

    assert result["whole_iae_m_s"] == pytest.approx(0.5 * (0 + 1 + 2))
    assert result["whole_ise_m2_s"] == pytest.approx(0.5 * (0 + 1 + 4))
    assert result["whole_itae_m_s2"] == pytest.approx(0.5 * (0.5 * 1 + 1.0 * 2))


def test_time_within_the_watch_circles_is_a_percentage_of_the_control_steps() -> None:
    result = level_metrics(rows_of([0.05, 0.2, 0.4, 0.6]), FACTS)

    circles = [result[f"whole_in_{name}_m_percent"] for name in ("0_1", "0_25", "0_5")]
    assert circles == [25.0, 50.0, 75.0]


def test_the_target_is_lost_by_the_trackers_report_or_by_ground_truth() -> None:
    rows = rows_of([0.0] * 4, tracker_ok=[1, 0, 1, 1], tracker_error=[0, 0, 15.1, math.nan])

    assert level_metrics(rows, FACTS)["whole_lost_percent"] == 75.0


def test_effort_metrics_of_a_known_thrust() -> None:
    rows = rows_of([0.0] * 2, thrust_0=[99.0, 4.0], thrust_1=[0.0, -79.0], ref_u=[0.1, -0.2])

    result = level_metrics(rows, FACTS)

    squares = (99.0**2 + 4.0**2 + 79.0**2) / 2
    assert result["whole_thrust_rms_n"] == pytest.approx(math.sqrt(squares))
    assert result["whole_energy_n15_s"] == pytest.approx(0.5 * (99**1.5 + 8.0 + 79**1.5))
    assert result["whole_variation_m_s"] == pytest.approx(0.3)
    assert result["whole_saturated_s"] == 1.0


def test_contacts_within_half_a_second_are_one_collision() -> None:
    force = [0.0, 40.0, 0.0, 25.0, 5.0, 0.0, 0.0, 0.0, 7.0, 0.0]
    facts = replace(FACTS, dt=0.25)

    result = level_metrics(rows_of([0.0] * 10, contact_n=force), facts)

    assert result["whole_collisions"] == 2.0
    assert result["whole_contact_s"] == 1.0
    assert result["whole_contact_max_n"] == 40.0


def test_a_level_without_contact_has_no_collision() -> None:
    result = level_metrics(rows_of([0.0] * 3), FACTS)

    assert (result["whole_collisions"], result["whole_contact_s"]) == (0.0, 0.0)
    assert result["whole_contact_max_n"] == 0.0


def test_the_vrx_error_weights_the_heading_more_at_small_distances() -> None:
    result = level_metrics(rows_of([1.0], yaw=[0.4]), FACTS)

    assert result["whole_vrx_m"] == pytest.approx(1.0 + 0.75 * 0.4)
    assert result["whole_heading_rmse_rad"] == pytest.approx(0.4)


def test_distance_metrics_are_nan_if_the_target_is_out_of_view() -> None:
    result = level_metrics(rows_of([0.1] * 3, distance_px=[1.0, math.nan, 2.0]), FACTS)

    assert all(math.isnan(result[f"whole_{name}_px"]) for name in ("rmse", "mae", "p95", "max"))
    assert result["whole_max_m"] == 0.1


@pytest.mark.parametrize(
    ("distances", "settled"),
    [
        ([0.3, 0.2, 0.05, 0.05], 1.0),
        ([0.3, 0.05, 0.2, 0.05], 1.5),
        ([0.05, 0.05], 0.0),
        ([0.05, 0.3], None),
        ([math.nan, 0.0], 0.5),
    ],
)
def test_settled_means_within_the_circle_from_then_on(
    distances: list[float], settled: float | None
) -> None:
    assert settling_time(distances, 0.5) == settled


@pytest.mark.parametrize(
    ("distances", "ok", "held"),
    [([0.4] * 4, 1, True), ([0.6] * 4, 1, False), ([0.1] * 4, 0, False)],
)
def test_a_level_is_held_within_half_a_metre_and_never_lost(
    distances: list[float], ok: int, held: bool
) -> None:
    assert level_metrics(rows_of(distances, tracker_ok=[ok] * 4), FACTS)["held"] is held


def test_an_rmse_of_a_quarter_of_a_metre_earns_half_of_the_points() -> None:
    assert points(0.25, 0.0) == pytest.approx(50.0)
    assert points(0.0, 0.0) == 100.0
    assert points(0.0, 1.0) == 0.0


def test_a_level_has_exactly_the_declared_metrics() -> None:
    result = level_metrics(rows_of([0.1, 0.2, 0.3]), FACTS)

    named = {metric.name for metric in METRICS}
    rest = {"level", "speed", "points", "held", SETTLING.name}
    assert set(result) == named | {f"whole_{name}" for name in named} | rest
    assert {metric.better for metric in METRICS} == {"lower", "higher"}


distances = st.lists(st.floats(0.0, 10.0), min_size=3, max_size=20)


@given(values=distances)
def test_mean_rms_percentile_and_maximum_are_ordered(values: list[float]) -> None:
    result = level_metrics(rows_of(values), FACTS)

    slack = 1e-9
    assert result["mae_m"] <= result["rmse_m"] + slack
    assert result["rmse_m"] <= result["max_m"] + slack
    assert result["p95_m"] <= result["max_m"] + slack
    assert 0.0 <= result["points"] <= 100.0


@given(values=distances, factor=st.floats(1.0, 10.0))
def test_a_larger_error_never_earns_more_points(values: list[float], factor: float) -> None:
    near = level_metrics(rows_of(values), FACTS)["points"]
    far = level_metrics(rows_of([factor * value for value in values]), FACTS)["points"]

    assert far <= near + 1e-9


@given(first=distances, second=distances)
def test_metrics_over_the_run_equal_those_of_all_rows(
    first: list[float], second: list[float]
) -> None:
    length = min(len(first), len(second))
    one, two = rows_of(first[:length]), rows_of(second[:length])
    two[:, INDEX["thrust_0"]] = 3.0

    run = over_run(overall(), [level_metrics(one, FACTS), level_metrics(two, FACTS)])

    all_rows = level_metrics(np.concatenate([one, two]), replace(FACTS, settle_s=0.0))
    for name in ("rmse_m", "mae_m", "max_m", "iae_m_s", "in_0_25_m_percent", "thrust_rms_n"):
        assert run[f"whole_{name}"] == pytest.approx(all_rows[f"whole_{name}"], abs=1e-12)


def test_a_level_that_does_not_settle_leaves_the_run_without_a_settling_time() -> None:
    settled, unsettled = (
        level_metrics(rows_of([0.0] * 3), FACTS),
        level_metrics(rows_of([1.0] * 3), FACTS),
    )

    assert over_run(overall(), [settled, settled])["settling_s"] == 0.0
    assert over_run(overall(), [settled, unsettled])["settling_s"] is None
