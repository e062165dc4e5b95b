"""Where points are in the image of a camera that looks down."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from seamark.sim.control.manipulation.kinematics import rotation
from seamark.sim.control.manipulation.sight import Pinhole


def projected(
    camera: Pinhole, attitude: Sequence[float], points: NDArray[np.float64]
) -> list[float]:
    """Return points (n, 3) [m], from the body's origin in NED axes, in the image: x0 y0 and on.

    `attitude` is roll, pitch and yaw [rad] of the body.
    """
    roll, pitch, yaw = attitude
    ahead, side, below = (points @ np.array(rotation(roll, pitch, yaw)) - camera.mount_m).T
    unit = np.stack([side / below, -ahead / below], axis=1)
    pixels: list[float] = (unit * camera.focal_px + camera.centre_px).ravel().tolist()
    return pixels
