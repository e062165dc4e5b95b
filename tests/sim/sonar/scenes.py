"""Scenes for a sonar at the origin that looks north."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from seamark.sim.camera.bodies import Bodies, Placed
from seamark.sim.multibody.assembly import Frame, Look
from seamark.sim.sonar.device import RAYS, Device
from seamark.sim.sonar.sonar import Sonar, mounted
from seamark.sim.vehicles.solids import Paint, Shape, Solid

Point = tuple[float, float, float]
HERE = Placed(np.eye(3)[None], np.array([[-0.3, 0.0, 0.0]]), np.zeros((1, 6)))  # the sonar: at 0
DEEP_M = 1000.0
MU = 0.1


def solid(shape: Shape, size: Point, at: Point, turn: NDArray[np.float64] | None = None) -> Look:
    """A thing that does not move."""
    on = Frame(None, np.array(at), np.eye(3) if turn is None else turn)
    return Look(on, Solid(shape, size, (0.0, 0.0, 0.0), Paint("#808080")))


def sonar(
    looks: Sequence[Look] = (),
    *,
    seabed_m: float = DEEP_M,
    tilt_rad: float = 0.0,
    range_m: float = 20.0,
    beams: int = 256,
    bins: int = 400,
    noise_seed: int = 3,
    rays: int = RAYS,
) -> Sonar:
    """A sonar before these things."""
    device = Device(range_m=range_m, tilt_rad=tilt_rad, beams=beams, bins=bins)
    return Sonar(
        *(device, Bodies(looks, ("vehicle",)), np.full(len(looks), MU)),
        mount=mounted(device, "vehicle"),
        seabed_m=seabed_m,
        noise_seed=noise_seed,
        rays=rays,
    )


def ranges(of: Sonar, beam: int) -> tuple[float, float]:
    """Return from where on and up to where a beam has echoes [m]."""
    found = np.flatnonzero(of.echoes(HERE)[beam])
    return float(found[0]) * of.device.bin_m, float(found[-1] + 1) * of.device.bin_m


def ahead(of: Sonar) -> int:
    """Return a beam that looks ahead, by half of the angle to the next one."""
    middle = of.device.beams // 2
    assert abs(of.device.azimuth_rad(middle)) < math.radians(0.3)
    return middle
