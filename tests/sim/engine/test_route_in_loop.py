"""What a program is told on a route, and what is recorded of it."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from seamark.sim.benchmarks.track_v1.experiment import EXPERIMENT
from seamark.sim.benchmarks.track_v1.settings import TrackConfiguration
from seamark.sim.control.observation import ROUTE_POINTS, Observation
from seamark.sim.engine.program import Command
from seamark.sim.metrics.following import REACH_M
from seamark.sim.recording.telemetry import INDEX, ROUTE_INDEX, Rows

EXACT = {
    "fix_period_s": 0.5,
    "fix_delay_s": 0.0,
    "fix_dropout": 0.0,
    "fix_range_sigma_m": 0.0,
    "fix_angle_sigma_rad": 0.0,
}


class Watcher:
    """Keeps what it is told, and steers for the point ahead."""

    def __init__(self) -> None:
        self.told: list[Observation] = []

    def reset(self, level: Mapping[str, float | int]) -> None:
        pass

    def step(self, values: NDArray[np.float64]) -> Command:
        seen = Observation(values, route=True)
        self.told.append(seen)
        ahead, side, down = (0.4 * seen.error).tolist()
        return ahead, side, down, 0.0


def watched(seconds: float = 40.0, **settings: Any) -> tuple[list[Observation], Rows]:
    config = TrackConfiguration.read(
        {"levels": [0.1], "level_duration_s": seconds, "vehicle": "bluerov2-heavy-v2"} | settings
    ).for_trial(0)
    watcher, rows = Watcher(), []
    EXPERIMENT.level(config, watcher, seed=8, trial=0, level=0).run(rows.append)
    return watcher.told, np.concatenate(rows)


def column(rows: Rows, name: str) -> NDArray[np.float64]:
    values: NDArray[np.float64] = rows[:, (INDEX | ROUTE_INDEX)[name]]
    return values


def test_the_route_is_told_from_where_the_vehicle_is_said_to_start() -> None:
    config = TrackConfiguration.read({"levels": [0.1]}).for_trial(0)
    told, rows = watched(2.0)
    course = EXPERIMENT.course(config, seed=8, trial=0, level=0)

    first = told[0].route.reshape(ROUTE_POINTS, 3)[0]
    start = rows[0, INDEX["x"] : INDEX["z"] + 1]
    said = course.route_m[0, :2] - start[:2] - first[:2]

    assert np.allclose(said, course.start_error_m, atol=1e-9)
    assert np.hypot(*said) > 0.1  # else this test tells nothing
    assert first[2] == pytest.approx(course.route_m[0, 2])


def test_before_the_first_fix_its_age_is_negative_and_then_it_grows() -> None:
    told, rows = watched(10.0, fix_dropout=0.0)
    ages = [seen.fix_age for seen in told]

    assert ages[0] == -1.0
    assert np.isnan(column(rows, "fix_age")[0])
    known = [age for age in ages if age >= 0.0]
    assert known[0] == pytest.approx(1.05, abs=0.06)  # its delay, and the way of the sound
    assert known == pytest.approx(column(rows, "fix_age")[-len(known) :].tolist())
    assert max(known) < 4.0 + 1.2


def test_with_exact_fixes_the_position_error_ends_at_the_true_point_of_the_route() -> None:
    told, rows = watched(60.0, dvl_bias_spread_m_s=0.0, ahrs_yaw_bias_rad=0.0, **EXACT)

    near = column(rows, "cross_track")[400:]

    assert near.max() < 0.35  # it steers for a point a metre ahead, so it cuts corners
    assert [seen.target_visible for seen in told] == [True] * len(told)


def test_no_number_of_the_observation_tells_the_true_position() -> None:
    """Two levels that differ in where they are said to start tell apart by route and fix alone."""
    exact, _ = watched(2.0, start_error_m=0.0, fix_dropout=1.0)
    wrong, _ = watched(2.0, start_error_m=1.5, fix_dropout=1.0)

    differ = {
        name
        for name in exact[0]
        if not np.array_equal(np.asarray(exact[0][name]), np.asarray(wrong[0][name]))
    }

    assert differ == {"route", "error"}


def test_a_vehicle_that_leaves_the_route_joins_it_again_farther_on() -> None:
    class Leaver(Watcher):
        def step(self, values: NDArray[np.float64]) -> Command:
            ahead, side, down, rate = super().step(values)
            away = 100 < len(self.told) < 500
            return (ahead, side, -1.0 if away else down, rate)

    config = TrackConfiguration.read(
        {"levels": [0.1], "level_duration_s": 90.0, "vehicle": "bluerov2-heavy-v2", **EXACT}
    ).for_trial(0)
    rows_: list[Rows] = []
    EXPERIMENT.level(config, Leaver(), seed=8, trial=0, level=0).run(rows_.append)
    rows = np.concatenate(rows_)

    assert column(rows, "cross_track")[100:600].max() > REACH_M
    assert column(rows, "cross_track")[-200:].max() < REACH_M
    assert np.diff(column(rows, "route_along")).min() >= 0.0


def piped(seconds: float = 30.0, **settings: Any) -> tuple[list[Observation], Rows]:
    return watched(seconds, route="pipe", **settings)


def test_of_a_pipe_only_its_beginning_and_its_length_are_told() -> None:
    config = TrackConfiguration.read(
        {"levels": [0.1], "vehicle": "bluerov2-heavy-v2", "route": "pipe"}
    ).for_trial(0)
    course = EXPERIMENT.course(config, seed=8, trial=0, level=0)

    route = piped(2.0)[0][0].route.reshape(ROUTE_POINTS, 3)

    steps = np.diff(route, axis=0)
    first = course.route_m[1] - course.route_m[0]
    assert np.allclose(steps, steps[0])
    assert steps[0] / np.linalg.norm(steps[0]) == pytest.approx(first / np.linalg.norm(first))
    assert np.linalg.norm(route[-1] - route[0]) == pytest.approx(config.route_length_m)
    assert np.ptp(np.arctan2(*np.diff(course.route_m[:, :2], axis=0).T)) > 0.3  # yet it bends


def test_steering_for_the_point_ahead_keeps_the_vehicle_above_the_pipe() -> None:
    told, rows = piped(40.0)

    assert column(rows, "cross_track")[200:].max() < 0.4
    assert column(rows, "route_along")[-1] > 8.0
    assert np.mean([seen.target_visible for seen in told]) > 0.8


def test_offset_and_angle_of_the_pipe_are_true_within_centimetres_and_degrees() -> None:
    told, rows = piped(20.0, pipe_covered=0)
    offsets = np.array([seen.pipe_offset for seen in told])[40:]
    angles = np.array([seen.pipe_angle for seen in told])[40:]
    true = np.arctan2(column(rows, "route_dy"), column(rows, "route_dx")) - column(rows, "yaw")
    off = np.angle(np.exp(1j * (angles - true[40:])))

    assert np.median(np.abs(offsets + column(rows, "cross_track_y")[40:])) < 0.04
    assert np.median(np.abs(off)) < 0.05


def test_a_pipe_that_is_not_seen_goes_on_straight() -> None:
    told, rows = piped(4.0, pipe_turbidity_1_m=3.0)

    assert not any(seen.target_visible for seen in told)
    headings = [seen.pipe_angle + seen.attitude.item(2) for seen in told]
    assert np.ptp(np.unwrap(headings)) < 1e-9
    assert not column(rows, "tracker_ok").any()


def test_on_another_route_there_is_no_pipe() -> None:
    told, _ = watched(2.0)

    assert {(seen.pipe_offset, seen.pipe_angle) for seen in told} == {(0.0, 0.0)}
