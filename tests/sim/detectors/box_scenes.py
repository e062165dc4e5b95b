"""Views of a lettered box from a Girona 500 with an arm, at any distance and in any water."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from seamark.sim.benchmarks.intervention.things import placed
from seamark.sim.benchmarks.intervention.tilt import tilt_of
from seamark.sim.camera import Optics, Target, Water
from seamark.sim.camera.arm_camera import ArmCamera
from seamark.sim.camera.lettering import other_text
from seamark.sim.detectors import Corners, Image
from seamark.sim.multibody.assembly import Frame, Mounting
from seamark.sim.multibody.workpiece import MOTION, Workpiece
from seamark.sim.vehicles import load
from seamark.sim.vehicles.linkage import Linkage
from seamark.sim.vehicles.linkage_reading import load_linkage

OPTICS = Optics(width=320, height=240, focal_px=190.0)
SEABED_M, RAISED_M, HALF_M = 5.0, 0.06, 0.1  # the box lies on a stone
TILT_RAD, SWAY_RAD = 0.14, 0.05  # most, of box and vehicle
BORDER_PX = 8
JOINTS = 5


@dataclass
class BoxView:
    """An image, and where the box is in it."""

    image: Image
    corners: Corners
    right: bool


def lettered_box(text: str) -> Linkage:
    box = load_linkage("black-box")
    (link,) = box.links
    solids = tuple(replace(one, text=text) if one.lettered else one for one in link.solids)
    return replace(box, links=(replace(link, solids=solids),))


def camera(
    water: Water, text: str, random: np.random.Generator
) -> tuple[ArmCamera, NDArray[np.float64]]:
    """Return a camera, and the pose (6,) of the box that it sees somewhere."""
    heading = np.pi * random.uniform(-1.0, 1.0)
    tilt = tilt_of(TILT_RAD, (random.random(), random.random()))
    at = np.array([0.0, 0.0, SEABED_M - RAISED_M]) - HALF_M * tilt.matrix()[:, 2]
    attitude = tilt.attitude(heading)
    box = Mounting(linkage=lettered_box(text), place=placed(at, attitude), prefix="work: ")
    work = Workpiece(
        things=(box,),
        link="work: box",
        shapes=(),
        grip=(0.0, 0.0, 0.0),
        face=Frame("work: box", np.array([0.0, 0.0, -HALF_M]), np.eye(3)),
        size_m=(0.3, 0.2),
    )
    vehicle, arm = load("girona500"), load_linkage("arm-5e-like")
    carried = vehicle, Mounting(linkage=arm, place=vehicle.mounts[arm.name], on_vehicle=True)
    seed = int(random.integers(2**40))
    target = Target(seabed_m=SEABED_M)
    eye = ArmCamera(OPTICS, water, target, carried, workpiece=work, noise_seed=seed)
    return eye, np.concatenate([at, attitude])


def look(
    random: np.random.Generator, distance_m: float, optical_depth: float, *, right: bool
) -> BoxView:
    """Return a view of a box whose whole face is in the image; the depth is that of the seabed."""
    water = Water.grey(optical_depth / (distance_m + 2.0 * HALF_M + RAISED_M))
    eye, box = camera(water, "" if right else other_text(random), random)
    motion = np.zeros(12 + 2 * JOINTS + MOTION)
    motion[-MOTION : -MOTION + 6] = box
    corners = np.zeros((4, 2))
    while (np.abs(corners - (159.5, 119.5)) > (159.5 - BORDER_PX, 119.5 - BORDER_PX)).any():
        north, east = distance_m * random.uniform(-1.0, 1.0, 2) * (0.6, 0.8)
        down = box[2] - HALF_M - distance_m - OPTICS.mount_m[2]
        motion[:3] = north - OPTICS.mount_m[0], east - OPTICS.mount_m[1], down
        motion[3:5] = random.uniform(-SWAY_RAD, SWAY_RAD, 2)
        corners = eye.corners(motion)
    return BoxView(eye.grey(motion, 0), corners.copy(), right)
