"""A target that moves is where a target would be that stands there."""

import numpy as np
import pytest

from seamark.sim.camera.moving_target import place
from seamark.sim.camera.target import FACES, Target


@pytest.mark.parametrize("heading", [0.0, -0.0, 0.7, -3.0, 400.0])
def test_a_target_that_has_moved_has_the_bits_of_one_that_stands_there(heading: float) -> None:
    there = Target(length_m=0.5, height_m=0.2, north_m=-1.3, east_m=2.1, heading_rad=heading)
    faces, corners, points = np.empty((FACES, 12)), np.empty((4, 3)), np.empty((6, 3))
    at = np.array([there.north_m, there.east_m, heading])

    place(np.array(there.size_m), at, there.seabed_m, faces, corners, points)

    middles = [there.top_centre(), there.origin()]
    assert faces.tobytes() == there.faces().tobytes()
    assert corners.tobytes() == there.top_corners().tobytes()
    assert points.tobytes() == np.array([*there.top_corners(), *middles]).tobytes()
