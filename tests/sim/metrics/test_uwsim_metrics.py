"""The original module's metrics on rows that can be computed by hand."""

import math

import numpy as np
import pytest

from seamark.sim.metrics import uwsim_metrics
from seamark.sim.metrics.metric import over_run
from seamark.sim.recording.telemetry import INDEX, ROUTE_INDEX, WIDTH, Rows, width_for


def rows_of(count: int, **columns: list[float]) -> Rows:
    rows = np.zeros((count, WIDTH))
    rows[:, INDEX["tracker_ok"]] = 1.0
    for name, values in columns.items():
        rows[:, INDEX[name]] = values
    return rows


def test_time_is_simulated() -> None:
    assert uwsim_metrics.time(rows_of(3, t=[1.0, 1.5, 2.0], step_us=[1e9, 1e9, 1e9])) == 1.0


def test_the_travelled_distance_ignores_the_reset_between_levels() -> None:
    rows = rows_of(4, x=[0.0, 3.0, 0.0, 0.0], y=[0.0, 4.0, 0.0, 1.0], level=[0.0, 0.0, 1.0, 1.0])

    assert uwsim_metrics.distance(rows) == 6.0


def test_a_collision_costs_its_mean_and_maximum_speed() -> None:
    rows = rows_of(3, u=[0.1, 0.0, 9.0], v=[0.0, 0.2, 0.0], contact_n=[5.0, 1.0, 0.0])

    assert uwsim_metrics.contacts(rows) == pytest.approx(
        {"steps": 2.0, "mean_speed": 0.15, "max_speed": 0.2}
    )
    score = uwsim_metrics.collision(**uwsim_metrics.contacts(rows))
    assert score == pytest.approx(1.0 - 0.15 / 0.5 - 0.2 / 0.5)
    assert uwsim_metrics.collision(**uwsim_metrics.contacts(rows[2:])) == 1.0
    assert uwsim_metrics.collision(steps=1.0, mean_speed=9.0, max_speed=9.0) == 0.0


def test_the_position_error_is_given_in_total_and_by_axis() -> None:
    result = uwsim_metrics.position_error(rows_of(2, x=[4.0, -2.0], y=[4.0, 4.0]), (1.0, 0.0, 0.0))

    assert result == {"total": 5.0, "x": 3.0, "y": 4.0, "z": 0.0}


def test_a_lost_target_does_not_count_in_the_norms() -> None:
    rows = rows_of(2, tracked_x=[3.0, -1.0], tracked_y=[4.0, -1.0], tracker_error=[5.0, 99.0])
    rows[1, INDEX["tracker_ok"]] = 0.0

    assert uwsim_metrics.euclidean_norm(rows) == {"corners": 10.0, "centroid": 5.0}
    assert math.isnan(uwsim_metrics.euclidean_norm(rows[1:])["corners"])


def test_path_following_distinguishes_iae_and_ise() -> None:
    rows = rows_of(3, x=[0.0, 1.0, 5.0], y=[0.0, 2.0, 4.0])

    result = uwsim_metrics.path_following(rows, [(0.0, 0.0, 0.0), (2.0, 0.0, 0.0)], 0.5)

    assert result == pytest.approx({"iae": 3.5, "ise": 14.5, "distanceToPath": 7.0 / 3.0})


def test_the_distance_to_the_image_centre_is_given_in_total_and_by_axis() -> None:
    rows = rows_of(2, distance_px=[5.0, 5.0], error_x_px=[3.0, -3.0], error_y_px=[4.0, 4.0])

    assert uwsim_metrics.object_centered_on_cam(rows) == {"total": 5.0, "x": 3.0, "y": 4.0}


@pytest.mark.parametrize("axis", ["roll", "pitch", "yaw"])
def test_the_attitude_error_of_a_rotation_about_one_axis_is_its_angle(axis: str) -> None:
    rows = rows_of(2, **{axis: [0.0, 0.3]})

    assert uwsim_metrics.attitude_error(rows) == pytest.approx(0.15)


def test_the_attitude_error_is_relative_to_the_start_of_the_level() -> None:
    rows = rows_of(3, yaw=[3.1, 3.1, 3.4 - 2 * math.pi])

    assert uwsim_metrics.attitude_error(rows) == pytest.approx(0.1)


def test_a_level_has_exactly_the_metrics_of_the_original_module() -> None:
    rows = rows_of(3, t=[0.0, 0.5, 1.0], x=[0.0, 3.0, 3.0], distance_px=[0.0, 1.0, 2.0])

    result = uwsim_metrics.level_metrics(rows)

    assert tuple(result) == uwsim_metrics.NAMES
    assert (result["time"], result["distance"], result["positionError"]) == (1.5, 3.0, 2.0)
    assert (result["pathFollowingIAE"], result["pathFollowingISE"]) == (3.0, 9.0)
    assert (result["collision"], result["seenTicks"], result["objectCenteredOnCam"]) == (1, 3, 1)


def levels() -> list[Rows]:
    one = rows_of(4, t=[0.0, 0.5, 1.0, 1.5], x=[0.0, 1.0, 2.0, 4.0], tracker_error=[1.0] * 4)
    two = rows_of(4, t=[2.0, 2.5, 3.0, 3.5], u=[0.0, 0.1, 0.3, 0.0], tracker_error=[3.0] * 4)
    two[:, INDEX["level"]] = 1.0
    two[1:3, INDEX["contact_n"]] = 7.0
    two[1:, INDEX["tracker_ok"]] = 0.0
    return [one, two]


def test_metrics_over_the_run_equal_those_of_all_rows_together() -> None:
    one, two = levels()
    rows = np.concatenate([one, two])

    result = over_run(
        uwsim_metrics.METRICS, [uwsim_metrics.level_metrics(one), uwsim_metrics.level_metrics(two)]
    )

    assert result["time"] == uwsim_metrics.time(rows) + 0.5
    assert result["distance"] == uwsim_metrics.distance(rows)
    assert result["corners"] == pytest.approx(uwsim_metrics.euclidean_norm(rows)["corners"])
    assert result["collision"] == pytest.approx(
        uwsim_metrics.collision(**uwsim_metrics.contacts(rows))
    )
    assert result["positionError"] == pytest.approx(7.0 / 8.0)
    assert result["pathFollowingIAE"] == pytest.approx(3.5)


def test_a_run_that_never_tracks_its_target_has_no_norm() -> None:
    level = uwsim_metrics.level_metrics(levels()[1][1:])

    assert math.isnan(over_run(uwsim_metrics.METRICS, [level, level])["corners"])


def test_on_a_route_the_path_is_the_route() -> None:
    rows = np.zeros((41, width_for(8, route=True)))
    rows[:, INDEX["t"]] = 0.05 * np.arange(41)
    rows[:, INDEX["x"]] = 7.0  # far from where the level starts
    rows[:, ROUTE_INDEX["cross_track"]] = 0.5

    found = uwsim_metrics.level_metrics(rows)

    assert found["pathFollowingIAE"] == pytest.approx(41 * 0.05 * 0.5)
    assert found["pathFollowingISE"] == pytest.approx(41 * 0.05 * 0.25)
    assert found["distanceToPath"] == 0.5
