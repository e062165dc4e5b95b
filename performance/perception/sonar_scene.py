"""What the sonar is shown for its table and its figure."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from seamark.sim.camera.bodies import Bodies, Placed
from seamark.sim.multibody.assembly import Frame, Look
from seamark.sim.sonar.acoustics import HARD_DB
from seamark.sim.sonar.device import Device
from seamark.sim.sonar.sonar import Sonar, mounted
from seamark.sim.vehicles.solids import Paint, Shape, Solid

SEABED_M, HEIGHT_M = 20.0, 5.4  # depth, and height of the sonar: that of a start of track-v1
DEVICE = Device(range_m=30.0, tilt_rad=0.35)


class Scene(NamedTuple):
    """A sonar and where it is."""

    sonar: Sonar
    placed: Placed


def weight_alone() -> Scene:
    """Return the weight of track-v1 on the seabed, 16 m ahead."""
    return _scene([_thing("box", (1.0, 0.6, 0.4), (16.0, 3.0), -0.2, 0.4)])


def everything() -> Scene:
    """Return the weight, a pipe on the seabed, a quay's wall, and balls on their lines."""
    things = [
        _thing("box", (1.0, 0.6, 0.4), (14.0, 1.0), -0.2, 0.4),
        _thing("cylinder", (60.0, 0.4, 0.4), (16.0, -9.0), -0.2, 0.6),
        _thing("box", (60.0, 2.0, 20.0), (12.0, 17.0), -10.0, 0.25),
        _thing("box", (2.4, 2.4, 1.2), (20.0, 7.0), -0.6, 0.2),
    ]
    things += [
        _thing("sphere", (0.5, 0.5, 0.5), (17.0 + 2.0 * k, 3.0), -1.2, 0.0) for k in range(3)
    ]
    return _scene(things)


def _thing(
    shape: Shape,
    size: tuple[float, float, float],
    at: tuple[float, float],
    above: float,
    yaw_rad: float,
) -> Look:
    """Return a thing north and east of the sonar, so far above the seabed, which is negative."""
    sine, cosine = math.sin(yaw_rad), math.cos(yaw_rad)
    turn = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    on = Frame(None, np.array([*at, SEABED_M + above]), turn)
    return Look(on, Solid(shape, size, (0.0, 0.0, 0.0), Paint("#808080")))


def _scene(things: Sequence[Look]) -> Scene:
    strengths = np.full(len(things), 10.0 ** (0.1 * HARD_DB))
    sonar = Sonar(
        *(DEVICE, Bodies(things, ("vehicle",)), strengths),
        mount=mounted(DEVICE, "vehicle"),
        seabed_m=SEABED_M,
        noise_seed=5,
    )
    position = np.array([[0.0, 0.0, SEABED_M - HEIGHT_M]])
    return Scene(sonar, Placed(np.eye(3)[None], position, np.zeros((1, 6))))
