"""The target: a box with letters or a picture on a flat seabed, in world NED coordinates."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from seamark.sim.camera import lettering, pictures
from seamark.sim.camera.optics import Optics
from seamark.sim.camera.pictures import Cutout
from seamark.sim.camera.seabed import packed, quantise
from seamark.sim.numerics.libm import cos, sin

Vector = NDArray[np.float64]

TEXEL_M = 0.0021  # on the box: half a pixel, prefiltered to a pixel
FACES = 5  # top, aft side, forward side, left end, right end as one reads the letters
# E: the light comes from the upper left, so the sides differ; the top counts as 1.
SHADES = (1.0, 0.55, 0.80, 0.75, 0.50)


@dataclass(frozen=True, slots=True, kw_only=True)
class Target:
    """Position and size of the box.

    With `heading_rad` equal to the vehicle's heading, the letters are upright in the image: the
    box's length lies along the image's u axis, its width along v.
    """

    length_m: float = 0.42  # S: template of 85x27 px in the paper's visibility scene
    width_m: float = 0.13
    height_m: float = 0.13  # E
    north_m: float = 0.0
    east_m: float = 0.0
    seabed_m: float = 5.0  # [m] depth of the seabed, E: the CIRS pool
    heading_rad: float = 0.0
    lettered: bool = True  # otherwise one dark tone
    picture: Cutout | None = None  # covers all faces, instead of letters or the dark tone

    def __post_init__(self) -> None:
        """Refuse a box without volume."""
        if min(self.length_m, self.width_m, self.height_m) <= 0:
            raise ValueError("the target's length, width and height must be positive")

    @property
    def size_m(self) -> tuple[float, float, float]:
        """Length, width and height."""
        return self.length_m, self.width_m, self.height_m

    def axes(self) -> tuple[Vector, Vector]:
        """Return two unit vectors (3,): to the right and downwards as one reads the letters."""
        c, s = cos(self.heading_rad), sin(self.heading_rad)
        return np.array([-s, c, 0.0]), np.array([-c, -s, 0.0])

    def top_centre(self) -> Vector:
        """Return the centre (3,) [m] of the top face."""
        return np.array([self.north_m, self.east_m, self.seabed_m - self.height_m])

    def origin(self) -> Vector:
        """Return the box's centre (3,) [m], which is the object's position in UWSim."""
        return np.array([self.north_m, self.east_m, self.seabed_m - 0.5 * self.height_m])

    def top_corners(self) -> Vector:
        """Return the top face's corners (4, 3) [m]: upper left, upper right, lower right, left."""
        right, down = self.axes()
        a, b = 0.5 * self.length_m * right, 0.5 * self.width_m * down
        centre = self.top_centre()
        return np.array([centre - a - b, centre + a - b, centre + a + b, centre - a + b])

    def faces(self) -> Vector:
        """Return (FACES, 12) [m]: first corner, first edge, second edge, outward normal."""
        right, down = self.axes()
        drop = np.array([0.0, 0.0, self.height_m])
        long, short = self.length_m * right, self.width_m * down
        upper_left, upper_right, lower_right, lower_left = self.top_corners()
        return np.array(
            [
                np.concatenate([upper_left, long, short, [0.0, 0.0, -1.0]]),
                np.concatenate([lower_left, long, drop, down]),
                np.concatenate([upper_right, -long, drop, -down]),
                np.concatenate([upper_left, short, drop, -right]),
                np.concatenate([lower_right, -short, drop, right]),
            ]
        )


@dataclass(frozen=True, slots=True)
class BoxTexture:
    """Packed textures of all faces for one channel."""

    texels: NDArray[np.uint16]  # all faces, one after the other
    layout: NDArray[np.int32]  # (FACES, 3): offset, columns, rows


@lru_cache(maxsize=12)
def box_texture(target: Target, channel: int) -> BoxTexture:
    """Return the textures of a target's faces; its sides are darker."""
    sizes = box_sizes(target)
    parts, layout, offset = [], [], 0
    for number, ((length, width), shade) in enumerate(zip(sizes, SHADES, strict=True)):
        texels = quantise(box_face(target, number, length, width, channel) * shade)
        parts.append(packed(texels, wrap=False))
        layout.append((offset, texels.shape[1], texels.shape[0]))
        offset += texels.size
    return BoxTexture(np.concatenate(parts), np.array(layout, dtype=np.int32))


def box_sizes(target: Target) -> list[tuple[float, float]]:
    """Return length and width of each face (FACES) as one reads the letters [m]."""
    length_m, width_m, height_m = target.size_m
    return [(length_m, width_m)] + [(length_m, height_m)] * 2 + [(width_m, height_m)] * 2


def box_face(target: Target, number: int, length_m: float, width_m: float, channel: int) -> Vector:
    """Return the albedo (rows, columns) of a face, before its shade."""
    if target.picture is None:
        return lettering.face(length_m, width_m, TEXEL_M, channel, lettered=target.lettered)
    columns, rows = round(length_m / TEXEL_M), round(width_m / TEXEL_M)
    return pictures.face(target.picture, columns, rows, number=number)


def start_pose(optics: Optics, target: Target, height: float) -> Vector:
    """Return the level body pose (6,) from which the camera looks at the target's centre.

    Parameters
    ----------
    height : float [m]
        Distance of the camera from the target's top face, e.g. 2.27 (currents), 1.27 (visibility).
    """
    c, s = cos(target.heading_rad), sin(target.heading_rad)
    x, y, z = optics.mount_m
    centre = target.top_centre()
    position = centre - np.array([c * x - s * y, s * x + c * y, z + height])
    return np.array([*position, 0.0, 0.0, target.heading_rad])
