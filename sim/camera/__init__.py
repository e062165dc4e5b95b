"""The vehicle's camera above a seabed with a box: rendering, water, true image positions."""

import numpy as np

from seamark.sim.camera.camera import Camera
from seamark.sim.camera.effects import Effects
from seamark.sim.camera.optics import CURRENTS, VISIBILITY, Optics
from seamark.sim.camera.target import Target, start_pose
from seamark.sim.camera.water import JERLOV, LAWS, Water

__all__ = [
    "CURRENTS",
    "JERLOV",
    "LAWS",
    "VISIBILITY",
    "Camera",
    "Effects",
    "Optics",
    "Target",
    "Water",
    "start_pose",
    "warm_up",
]


def warm_up() -> None:
    """Load all compiled code and the grey textures, so that forked processes start at once."""
    camera = Camera(VISIBILITY, Water(), Target(), noise_seed=0)
    pose = start_pose(VISIBILITY, Target(), 1.27)
    camera.region(pose, 0, (0, 0, 32, 32))
    camera.grey(pose, 0)
    camera.corners(np.asarray(pose))
    disturbed = Camera(
        VISIBILITY, Water(), Target(), noise_seed=0, effects=Effects(light_level=0.5)
    )
    disturbed.region(pose, 0, (0, 0, 32, 32))
