"""The original module's measures on rows that a person can work out."""

import math

import numpy as np
import pytest

from sim import measures
from sim.score_expression import score_of
from sim.telemetry import INDEX, WIDTH, Rows


def rows_of(count: int, **columns: list[float]) -> Rows:
    rows = np.zeros((count, WIDTH))
    rows[:, INDEX["tracker_ok"]] = 1.0
    for name, values in columns.items():
        rows[:, INDEX[name]] = values
    return rows


def test_time_is_simulated() -> None:
    assert measures.time(rows_of(3, t=[1.0, 1.5, 2.0], step_us=[1e9, 1e9, 1e9])) == 1.0


def test_the_path_leaves_out_the_way_back_to_a_levels_start() -> None:
    rows = rows_of(4, x=[0.0, 3.0, 0.0, 0.0], y=[0.0, 4.0, 0.0, 1.0], level=[0.0, 0.0, 1.0, 1.0])

    assert measures.distance(rows) == 6.0


def test_a_collision_costs_its_mean_and_its_greatest_speed() -> None:
    rows = rows_of(3, u=[0.1, 0.0, 9.0], v=[0.0, 0.2, 0.0], contact_n=[50.0, 1.0, 0.0])

    assert measures.collision(rows) == pytest.approx(1.0 - 0.15 / 0.5 - 0.2 / 0.5)
    assert measures.collision(rows[2:]) == 1.0
    rows[2, INDEX["contact_n"]] = 1.0
    assert measures.collision(rows) == 0.0


def test_the_position_error_is_whole_and_by_axis() -> None:
    result = measures.position_error(rows_of(2, x=[4.0, -2.0], y=[4.0, 4.0]), (1.0, 0.0, 0.0))

    assert result == {"total": 5.0, "x": 3.0, "y": 4.0, "z": 0.0}


def test_a_lost_target_is_no_part_of_the_norms() -> None:
    rows = rows_of(2, tracked_x=[3.0, -1.0], tracked_y=[4.0, -1.0], tracker_error=[5.0, 99.0])
    rows[1, INDEX["tracker_ok"]] = 0.0

    assert measures.euclidean_norm(rows) == {"corners": 10.0, "centroid": 5.0}
    assert math.isnan(measures.euclidean_norm(rows[1:])["corners"])


def test_a_path_is_followed_with_iae_and_ise_apart() -> None:
    rows = rows_of(3, x=[0.0, 1.0, 5.0], y=[0.0, 2.0, 4.0])

    result = measures.path_following(rows, [(0.0, 0.0, 0.0), (2.0, 0.0, 0.0)], 0.5)

    assert result == pytest.approx({"iae": 3.5, "ise": 14.5, "distanceToPath": 7.0 / 3.0})


def test_a_score_is_an_expression_over_the_measures() -> None:
    rows = rows_of(2, tracked_x=[3.0, 3.0], tracker_error=[1.0, 1.0])

    assert score_of("corners + centroid", measures.named(rows)) == 5.0


def test_the_target_is_centred_by_axis() -> None:
    rows = rows_of(2, distance_px=[5.0, 5.0], error_x_px=[3.0, -3.0], error_y_px=[4.0, 4.0])

    assert measures.object_centered_on_cam(rows) == {"total": 5.0, "x": 3.0, "y": 4.0}
