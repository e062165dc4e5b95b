"""Geometry of quadrilaterals in the image."""

import numpy as np

from seamark.sim.camera.geometry import diagonal_intersection


def test_the_diagonals_of_a_square_meet_at_its_centre() -> None:
    assert diagonal_intersection(np.array([0.0, 0.0, 2.0, 0.0, 2.0, 2.0, 0.0, 2.0])) == (1.0, 1.0)


def test_corners_in_one_point_have_that_point_as_the_intersection() -> None:
    assert diagonal_intersection(np.array([3.0, 4.0] * 4)) == (3.0, 4.0)
