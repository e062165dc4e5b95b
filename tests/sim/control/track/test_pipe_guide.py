"""Guidance along a pipe: from pixels to the seabed, what is believed, and the point ahead."""

import math

import numpy as np
import pytest

from seamark.sim.camera.geometry import camera_pose, project
from seamark.sim.camera.optics import VISIBILITY
from seamark.sim.control.track.navigation import Measured
from seamark.sim.control.track.pipe_guide import Lens, PipeGuide, PipeLine

NOW = Measured(
    t=0.0,
    dt=0.1,
    speeds=(0.0, 0.0),
    depth=16.0,
    yaw=(0.0, 1.0),
    fix=(0.0, 0.0),
    fix_age=-1.0,
    fix_sigma=0.0,
    pipe=(0.0, 0.0),
)
ROUTE = np.array([[0.0, 0.0, 16.5], [15.0, 0.0, 16.5], [30.0, 0.0, 16.5]])


@pytest.mark.parametrize("tilt", [(0.0, 0.0), (0.1, 0.0), (0.0, -0.1), (-0.15, 0.2)])
def test_a_pixel_is_put_where_the_camera_saw_it_on_the_seabed(tilt: tuple[float, float]) -> None:
    pose = np.array([0.0, 0.0, 17.0, *tilt, 0.0])
    rotation, centre, pixel = np.empty((3, 3)), np.empty(3), np.empty((1, 2))
    camera_pose(pose, np.array(VISIBILITY.mount_m), rotation, centre)
    project(np.array([[0.6, -0.3, 20.0]]), rotation, centre, VISIBILITY.intrinsics(), pixel)
    u, v = (pixel[0] - VISIBILITY.principal_px).tolist()

    place = Lens(VISIBILITY.focal_px, VISIBILITY.mount_m).on_seabed((u, v), tilt, 3.0)

    assert place == pytest.approx((0.6, -0.3))


def test_a_line_that_was_seen_is_carried_on_by_dead_reckoning() -> None:
    line = PipeLine((0.0, 0.0), 0.0)
    line.look(0.0, (2.0, 0.3), math.pi + 0.1)  # either way round

    offset, angle = line.beside((2.0, 0.0), 0.4)
    farther, _ = line.beside((12.0, 0.0), 0.4)

    assert angle == pytest.approx(0.1 - 0.4)
    assert offset == pytest.approx(0.3 * math.cos(0.1))
    assert farther - offset == pytest.approx(10.0 * math.sin(0.1))


def test_what_cannot_be_the_same_pipe_is_not_believed_until_nothing_was_seen_for_long() -> None:
    line = PipeLine((0.0, 0.0), 0.0)
    line.look(0.0, (0.0, 0.0), 0.0)

    line.look(0.2, (1.0, 1.0), 0.0)
    line.look(0.2, (1.0, 0.0), 1.0)
    at_once = line.beside((0.0, 0.0), 0.0)
    line.look(4.0, (1.0, 1.0), 0.0)
    late = line.beside((0.0, 0.0), 0.0)

    assert at_once == (0.0, 0.0)
    assert late[0] > 0.3


def test_the_point_ahead_is_on_the_pipe_at_the_depth_of_the_route() -> None:
    guide = PipeGuide(ROUTE, 0.6)
    guide.update(NOW._replace(pipe=(0.5, math.pi / 2)))

    north, east, down, length = guide.to_aim()

    # The pipe runs east, 0.5 m to starboard of that way: to the south.
    assert (north, east, down) == pytest.approx((-0.5, 0.6, 0.5))
    assert length == pytest.approx(math.sqrt(0.25 + 0.36 + 0.25))


def test_the_guide_has_got_on_as_far_as_the_vehicle_moved_along_the_pipe() -> None:
    guide = PipeGuide(ROUTE, 0.6)
    for _ in range(20):
        guide.update(NOW._replace(speeds=(1.0, 1.0), pipe=(0.0, 0.0)))

    assert guide.along_m == pytest.approx(2.0)
    assert guide.left_m == pytest.approx(28.0)
    assert guide.ahead(0.5, 4)[:, 0].tolist() == pytest.approx([2.5, 3.0, 3.5, 4.0])
