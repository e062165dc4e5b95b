"""The detector of pipes finds them whatever the heading, and nothing on bare sand."""

import math

import numpy as np
import pytest

from seamark.sim.camera.optics import VISIBILITY
from seamark.sim.camera.pipe_camera import PipeCamera
from seamark.sim.camera.target import Target
from seamark.sim.camera.water import Water
from seamark.sim.detectors.pipe_edges import PipeEdges
from seamark.sim.physics.pipe import pipe_along

SEABED_M, RADIUS_M, HEIGHT_M = 20.0, 0.2, 2.6
TARGET = Target(length_m=0.1, width_m=0.1, height_m=0.1, seabed_m=SEABED_M, lettered=False)
WIDTH_PX = 2.0 * RADIUS_M * VISIBILITY.focal_px / HEIGHT_M
CENTRE = np.array(VISIBILITY.principal_px)


def camera(attenuation: float) -> PipeCamera:
    axis = np.array([[-40.0, 0.0], [40.0, 0.0]])
    pipe = pipe_along(axis, SEABED_M, RADIUS_M, seed=2)
    return PipeCamera(VISIBILITY, Water.grey(attenuation), TARGET, pipe, noise_seed=3)


def pose(north: float, east: float, heading: float) -> np.ndarray:
    x, y, z = VISIBILITY.mount_m  # the camera is to be at this place
    c, s = math.cos(heading), math.sin(heading)
    down = SEABED_M - HEIGHT_M - z
    return np.array([north - c * x + s * y, east - s * x - c * y, down, 0.0, 0.0, heading])


@pytest.mark.parametrize("attenuation", [0.2, 0.5, 0.8])
@pytest.mark.parametrize("heading", np.linspace(-3.0, 3.0, 9).tolist())
def test_a_pipe_is_found_within_a_few_pixels_and_degrees(
    attenuation: float, heading: float
) -> None:
    for off in (-0.4, 0.0, 0.7):
        seen = PipeEdges(WIDTH_PX).find(camera(attenuation).grey(pose(1.0, off, heading), 4))

        assert seen.found
        # The pipe runs north, `off` to port of the camera: image right is starboard, up is ahead.
        along = np.array([-math.sin(heading), -math.cos(heading)])
        across = np.array([math.cos(heading), -math.sin(heading)])
        foot = CENTRE - off * VISIBILITY.focal_px / (HEIGHT_M - 0.5 * RADIUS_M) * across
        assert abs((np.array([seen.u, seen.v]) - foot) @ across) < 7.0
        assert abs(seen.direction @ across) < 0.07
        assert abs(seen.direction @ along) > 0.99


@pytest.mark.parametrize("attenuation", [0.0, 0.2, 0.5, 0.8])
def test_no_pipe_is_found_on_bare_sand(attenuation: float) -> None:
    bare, random = camera(attenuation), np.random.default_rng(6)
    found = [
        PipeEdges(WIDTH_PX).find(
            bare.grey(pose(random.uniform(-20, 20), 20.0, random.uniform(-3, 3)), k)
        )
        for k in range(30)
    ]

    assert not any(seen.found for seen in found)


def test_an_even_image_has_no_pipe() -> None:
    assert not PipeEdges(WIDTH_PX).find(np.full((240, 320), 90, np.uint8)).found
