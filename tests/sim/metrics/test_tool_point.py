"""The tool point: an error of heading displaces it, a lost target counts for nothing."""

import numpy as np
import pytest

from seamark.sim.engine.tool_error import tool_errors
from seamark.sim.metrics.metric import compute_all
from seamark.sim.metrics.tool_point import (
    CIRCLES_M,
    METRICS,
    POWER_WEIGHT,
    TOOL_AHEAD_M,
    ToolWindow,
    in_circles,
)
from seamark.sim.metrics.windows import LevelFacts
from seamark.sim.recording.telemetry import INDEX, WIDTH, Rows

STATION = np.array([1.0, 2.0, 3.0, 0.0, 0.0, 0.0])
MOUNT = (0.2, 0.0, 0.5)
FACTS = LevelFacts(level=0, speed=0.1, dt=0.05, settle_s=1.0, limits_n=(100.0, 80.0), thrusters=4)


def rows_at(*poses: list[float]) -> Rows:
    rows = np.zeros((len(poses), WIDTH))
    rows[:, INDEX["x"] : INDEX["yaw"] + 1] = STATION + np.array(poses)
    rows[:, INDEX["tracker_ok"]] = 1.0
    return rows


def metrics(rows: Rows) -> dict[str, float | None]:
    return compute_all(METRICS, ToolWindow(rows, FACTS, tool_errors(rows, STATION, MOUNT)))


def test_the_error_is_that_of_a_rigid_point_ahead_of_the_camera() -> None:
    turn = 0.3
    away = tool_errors(
        rows_at([0, 0, 0, 0, 0, 0], [0.3, 0.4, 0, 0, 0, 0], [0, 0, 0, 0, 0, turn]), STATION, MOUNT
    )

    chord = 2.0 * np.sin(0.5 * turn) * (MOUNT[0] + TOOL_AHEAD_M)
    assert away == pytest.approx([0.0, 0.5, chord], abs=1e-12)


def test_the_quality_is_the_share_of_the_circles_averaged_over_time() -> None:
    between = 0.5 * (CIRCLES_M[3] + CIRCLES_M[4])

    assert in_circles([0.0, 10.0], [False, False]) == 0.5
    assert in_circles([between] * 4, [False] * 4) == 0.5
    assert in_circles([0.0] * 4, [True, False, False, False]) == 0.75


def test_a_level_at_the_point_without_thrust_has_full_quality() -> None:
    values = metrics(rows_at(*[[0.0] * 6] * 5))

    assert (values["quality"], values["tool_rmse_m"], values["transient_s"]) == (1.0, 0.0, 0.0)


def test_power_costs_its_weight_and_is_relative_to_the_limit_of_each_direction() -> None:
    rows = rows_at(*[[0.0] * 6] * 5)
    first = INDEX["thrust_0"]
    rows[:, first : first + 4] = 100.0, -80.0, 25.0, 0.0

    values = metrics(rows)

    assert values["power_share"] == pytest.approx((1.0 + 1.0 + 0.125) / 4)
    assert values["quality"] == pytest.approx(1.0 - POWER_WEIGHT * (2.125 / 4))


def test_near_is_the_tool_or_the_camera_with_the_target_in_view() -> None:
    half_turn = [0.0, 0.0, 0.0, 0.0, 0.0, np.pi]
    rows = rows_at([0.0] * 6, [0.3, 0, 0, 0, 0, 0], half_turn, [0.0] * 6)
    rows[:, INDEX["distance"]] = 0.6, 0.3, 0.4, 0.6
    rows[3, INDEX["tracker_ok"]] = 0.0

    assert metrics(rows)["near_percent"] == 75.0
    assert metrics(rows[3:])["near_percent"] == 0.0


def test_the_transient_ends_when_the_point_is_first_reached() -> None:
    values = metrics(rows_at([0.5, 0, 0, 0, 0, 0], [0.3, 0, 0, 0, 0, 0], [0.05, 0, 0, 0, 0, 0]))

    assert values["transient_s"] == pytest.approx(0.1)
