"""Effects that disturb the images in addition to the water; all are off by default.

All of them are pure functions of pose, velocity, frame number and seed, so that any image can be
re-rendered from the telemetry.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

LAMP_FORWARD_M = 0.4  # E: the lamp sits this far ahead of the camera and looks down as it does
MAX_CAUSTICS = 1.5


@dataclass(frozen=True, slots=True, kw_only=True)
class Effects:
    """Settings of the effects."""

    exposure_s: float = 0.0  # motion blur: exposure time, centred on the time of the frame
    light_level: float = 1.0  # daylight relative to normal
    caustics: float = 0.0  # coefficient of variation of the daylight on the bottom
    lamp: float = 0.0  # illuminance 1 m below the lamp, in units of daylight
    lamp_cone_rad: float = 0.6  # half-intensity angle from its axis
    snow_per_m3: float = 0.0  # density of marine snow
    scatter_rad: float = 0.0  # forward scatter: sigma of the blur per unit of optical depth
    fish_per_min: float = 0.0  # rate of fish between camera and target
    fish_length_m: float = 0.3
    frame_s: float = 0.05  # time between two frames

    def __post_init__(self) -> None:
        """Refuse impossible values."""
        if not 0 <= self.exposure_s <= self.frame_s:
            raise ValueError(
                f"exposure_s {self.exposure_s} is not within the frame period of {self.frame_s} s"
            )
        if not 0 < self.light_level <= 10:
            raise ValueError(f"light_level {self.light_level} is not within 0..10")
        if not 0 <= self.caustics <= MAX_CAUSTICS:
            raise ValueError(f"caustics {self.caustics} is not within 0..{MAX_CAUSTICS}")
        if not 0.05 <= self.lamp_cone_rad <= 1.4:
            raise ValueError(f"lamp_cone_rad {self.lamp_cone_rad} is not within 0.05..1.4")
        if min(self.lamp, self.snow_per_m3, self.scatter_rad, self.fish_per_min) < 0:
            raise ValueError("lamp, snow_per_m3, scatter_rad and fish_per_min must not be negative")

    @property
    def alters_light(self) -> bool:
        """Whether the light differs from normal daylight."""
        return self.light_level != 1.0 or self.lamp > 0 or self.caustics > 0

    @property
    def any(self) -> bool:
        """Whether any effect is on, so that rendering needs `raycast_effects`."""
        on = (self.exposure_s, self.snow_per_m3, self.scatter_rad, self.fish_per_min)
        return self.alters_light or any(value > 0 for value in on)


class EffectParameters(NamedTuple):
    """The effects as the kernels read them."""

    exposure_s: float
    level: float
    waves: NDArray[np.float64]  # (n, 4) of the caustics; (0, 4) without
    wave: tuple[float, float]  # amplitude of each wave, mean of the light
    lamp: float
    cone: float  # 1 / tan^2 of the cone's angle
    alters_light: bool
    snow: float  # [1/m^3]
    scatter: float  # [rad]
    fish: float  # [1/s]
    fish_m: float
    frame_s: float
    seed: int  # 31 bits
    # (5,) of a target that moves by itself, here and now: north and east of the point that it
    # turns about [m], velocity north and east [m/s], yaw rate [rad/s]; 0 where it stands
    drift: NDArray[np.float64]
