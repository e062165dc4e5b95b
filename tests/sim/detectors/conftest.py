"""Images of painted bottoms, from seeds with which no detector was made, and what is in them."""

from dataclasses import dataclass

import numpy as np
import pytest

from seamark.sim.camera import VISIBILITY, Water
from seamark.sim.camera.bottom.bottom import draw_bottom
from seamark.sim.camera.bottom.camera import BottomCamera
from seamark.sim.detectors import Corners, Image
from seamark.sim.vehicles.patterns import CLASSES

SEABED_M, MOUNTED_M = 5.0, 0.95
BORDER_PX = 4


@dataclass
class View:
    """A colour image, and the corners of the objects that are wholly in it and uncovered."""

    image: Image
    objects: dict[str, Corners]


def look(seed: int, optical_depth: float) -> list[View]:
    """Return four images of one bottom."""
    random = np.random.Generator(np.random.PCG64(seed))
    bottom = draw_bottom(random, burial=0.5)
    altitude = 1.2 + 0.5 * random.random()
    water = Water(attenuation=(optical_depth / altitude,) * 3, veil=(0.3,) * 3)
    camera = BottomCamera(VISIBILITY, water, bottom, noise_seed=seed)
    views = []
    for frame, north in enumerate((0.8, 2.0, 3.2, 4.4)):
        down = SEABED_M - MOUNTED_M - altitude
        pose = np.array([north, bottom.east_m + 0.1, down, 0.02, -0.03, 0.1])
        end = np.array([VISIBILITY.width, VISIBILITY.height]) - BORDER_PX
        objects = {
            seen.name: seen.corners
            for seen in camera.seen(pose)
            if seen.name in CLASSES
            and seen.uncovered > 0.8
            and (seen.corners > BORDER_PX).all()
            and (seen.corners < end).all()
        }
        views.append(View(camera.colour(pose, frame), objects))
    return views


@pytest.fixture(scope="session")
def clear_views() -> list[View]:
    return [view for seed in range(700_000, 700_010) for view in look(seed, 0.0)]


@pytest.fixture(scope="session")
def veiled_views() -> list[View]:
    return [view for seed in range(700_100, 700_103) for view in look(seed, 20.0)]
