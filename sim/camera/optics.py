"""The vehicle's downward camera: resolution, focal length and mount on the body.

Camera frame: x to the image's right (u), y to the image's bottom (v), z along the optical axis.
Mounted straight down, image right is the body's starboard side and image down is aft. Pixel centres
are at integer coordinates, so the principal point is ((W - 1) / 2, (H - 1) / 2).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

# [m] Body frame. S: UWSim dynamicsTrackingScene.xml and g500ARM5.urdf: 0.95 m below the base link,
# 0.2 m aft and 0.1 m to port of it, looking down.
MOUNT_M = (-0.2, -0.1, 0.95)


@dataclass(frozen=True, slots=True, kw_only=True)
class Optics:
    """An ideal pinhole camera that looks along the body's z axis."""

    width: int = 640
    height: int = 480
    focal_px: float = 514.7
    mount_m: tuple[float, float, float] = MOUNT_M

    def __post_init__(self) -> None:
        """Refuse an impossible camera."""
        if not (16 <= self.width <= 4096 and 16 <= self.height <= 4096):
            raise ValueError(f"an image of {self.width}x{self.height} px is not within 16..4096 px")
        if not self.focal_px > 0:
            raise ValueError(f"focal_px must be positive, not {self.focal_px}")

    @property
    def principal_px(self) -> tuple[float, float]:
        """Image point of the optical axis."""
        return (self.width - 1) / 2, (self.height - 1) / 2

    def intrinsics(self) -> NDArray[np.float64]:
        """Return (3,) focal length, principal column, principal row [px] for the kernels."""
        return np.array([self.focal_px, *self.principal_px])


# S: UWSim dynamicsTrackingScene.xml, 640x480 with a vertical field of view of 50 degrees.
CURRENTS = Optics(width=640, height=480, focal_px=514.7)
# S: UWSim visionBenchmarkScene.xml, the same field of view at half the resolution.
VISIBILITY = Optics(width=320, height=240, focal_px=257.3)
