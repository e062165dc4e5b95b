"""Images of the imaging sonar beside one of the camera; at least 100 a second a core are wanted."""

from functools import partial

import numpy as np

from performance.perception.sonar_scene import everything, weight_alone
from performance.tables import Row, cpu_us
from seamark.sim.camera import CURRENTS, Camera, Target, Water, start_pose


def rows() -> list[Row]:
    """Measure and return the rows."""
    target = Target()
    camera = Camera(CURRENTS, Water(), target, noise_seed=1)
    camera_us = cpu_us(partial(camera.grey, np.asarray(start_pose(CURRENTS, target, 2.27)), 3))
    found = []
    for what, scene in (("a weight", weight_alone()), ("a quay and a pipe", everything())):
        sonar = scene.sonar
        size = f"{sonar.device.bins} x {sonar.device.beams}, {what}"
        ours_us = cpu_us(partial(sonar.image, scene.placed, 3), inner=20)
        found += [
            Row(
                what=f"sonar image {size}",
                value=ours_us,
                unit="us CPU",
                baseline="camera's grey image 640x480",
                baseline_value=camera_us,
            ),
            Row(
                what=f"the same, images a second of a core, {what}", value=1e6 / ours_us, unit="1/s"
            ),
        ]
    return found
