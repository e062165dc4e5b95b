"""What can disturb the pictures beside the water; everything is off unless asked for.

All of it is a pure function of pose, velocity, frame number and seed, so that any picture can be
made again from the telemetry.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

LAMP_FORWARD_M = 0.4  # E: the lamp sits this far ahead of the camera and looks down as it does
MOST_CAUSTICS = 1.5


@dataclass(frozen=True, slots=True, kw_only=True)
class Effects:
    """Disturbances of the pictures."""

    exposure_s: float = 0.0  # motion blur: how long the shutter is open, about the frame's instant
    light_level: float = 1.0  # daylight, as a share of the usual
    caustics: float = 0.0  # coefficient of variation of the daylight on what lies below
    lamp: float = 0.0  # light of the lamp 1 m below it, in units of daylight
    lamp_cone_rad: float = 0.6  # angle from its axis at which its intensity is half
    snow_per_m3: float = 0.0  # flakes of marine snow
    scatter_rad: float = 0.0  # forward scatter: sigma of the blur per unit of optical depth
    fish_per_min: float = 0.0  # fish that swim between camera and target
    fish_length_m: float = 0.3
    frame_s: float = 0.05  # time between two frames

    def __post_init__(self) -> None:
        """Refuse what cannot be."""
        if not 0 <= self.exposure_s <= self.frame_s:
            raise ValueError(
                f"exposure_s {self.exposure_s} is not within 0 and the {self.frame_s} s of a frame"
            )
        if not 0 < self.light_level <= 10:
            raise ValueError(f"light_level {self.light_level} is not within 0..10")
        if not 0 <= self.caustics <= MOST_CAUSTICS:
            raise ValueError(f"caustics {self.caustics} is not within 0..{MOST_CAUSTICS}")
        if not 0.05 <= self.lamp_cone_rad <= 1.4:
            raise ValueError(f"lamp_cone_rad {self.lamp_cone_rad} is not within 0.05..1.4")
        if min(self.lamp, self.snow_per_m3, self.scatter_rad, self.fish_per_min) < 0:
            raise ValueError("lamp, snow_per_m3, scatter_rad and fish_per_min are not negative")

    @property
    def lit(self) -> bool:
        """Whether light is not the usual daylight."""
        return self.light_level != 1.0 or self.lamp > 0 or self.caustics > 0

    @property
    def any(self) -> bool:
        """Whether anything is on, so that pictures take the longer way."""
        on = (self.exposure_s, self.snow_per_m3, self.scatter_rad, self.fish_per_min)
        return self.lit or any(value > 0 for value in on)


class Disturbance(NamedTuple):
    """The same for the kernels."""

    exposure_s: float
    level: float
    waves: NDArray[np.float64]  # (n, 4) of the caustics; none: (0, 4)
    wave: tuple[float, float]  # each wave's amplitude, and the mean that all of them make
    lamp: float
    cone: float  # 1 / tan^2 of the cone's angle
    lit: bool
    snow: float  # [1/m^3]
    scatter: float  # [rad]
    fish: float  # [1/s]
    fish_m: float
    frame_s: float
    seed: int  # 31 bits
