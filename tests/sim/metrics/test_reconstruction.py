"""The measure of a 3-D reconstruction on clouds that a person can count."""

import math

import numpy as np
import pytest

from seamark.sim.metrics.reconstruction import reconstruction

PLANE = np.array([[x + 0.5, y + 0.5, 0.5] for x in range(4) for y in range(4)])


def test_a_perfect_reconstruction_has_no_error_and_full_coverage() -> None:
    assert reconstruction(PLANE, PLANE, level_of_detail=1.0) == {
        "meanError": 0.0,
        "variance": 0.0,
        "coverage": 100.0,
        "outliers": 0.0,
    }


def test_half_of_a_plane_covers_half_of_it() -> None:
    result = reconstruction(PLANE[:8] + np.array([0.0, 0.0, 0.25]), PLANE, level_of_detail=1.0)

    assert (result["coverage"], result["meanError"], result["variance"]) == (50.0, 0.25, 0.0)


def test_points_far_away_are_outliers_and_do_not_count_in_the_error() -> None:
    points = np.concatenate([PLANE[:3], [[0.5, 0.5, 50.0]]])

    result = reconstruction(points, PLANE, level_of_detail=1.0)

    assert (result["outliers"], result["meanError"]) == (25.0, 0.0)


def test_outliers_alone_have_no_error() -> None:
    result = reconstruction(PLANE + 100.0, PLANE, level_of_detail=1.0)

    assert (result["outliers"], result["coverage"]) == (100.0, 0.0)
    assert math.isnan(result["meanError"])


@pytest.mark.parametrize("points", [np.zeros((0, 3)), np.zeros((3, 2)), np.zeros(3)])
def test_an_invalid_cloud_is_rejected(points: np.ndarray) -> None:
    with pytest.raises(ValueError, match="shape"):
        reconstruction(points, PLANE, level_of_detail=1.0)


def test_the_level_of_detail_must_be_positive() -> None:
    with pytest.raises(ValueError, match="positive"):
        reconstruction(PLANE, PLANE, level_of_detail=0.0)
