"""An imaging sonar as its data sheet has it. Light: no compiled code.

Tags of the numbers: S sourced, D derived from sourced, E our estimate. The device is like a Tritech
Gemini 720is (product manual 0703-SOM-00002, section 2.1).
"""

import math
from dataclasses import dataclass

SECTOR_RAD = math.radians(120.0)  # S: the manual's scanning sector
APERTURE_RAD = math.radians(20.0)  # S: its vertical beamwidth, to half the intensity (-3 dB)
BEAM_RAD = math.radians(1.0)  # S: its acoustic angular resolution, taken as the -3 dB width
FREQUENCY_KHZ = 720.0  # S
BEAMS = 256  # E: half of a beam's width apart
BINS = 400  # E: of range
SOURCE_DB = 195.0  # [dB re 1 µPa at 1 m] E: makers do not state it
# [dB] D: 4 pi over the solid angle of a beam of 1 by 20 degrees (Urick 1983, ch. 3).
DIRECTIVITY_DB = 33.2
RAYS = 63  # from a beam's upper to its lower edge, 0.3 degrees apart: 64 of them
# E: [m] ahead of the body's origin, at its height.
MOUNT_M = (0.3, 0.0, 0.0)
FARTHEST_M = 60.0  # [m] of the settings; half of the maker's range


@dataclass(frozen=True, slots=True, kw_only=True)
class Device:
    """A sonar on a vehicle, which looks ahead and down by `tilt_rad`.

    Its image is (height, width) = (bins, beams): the first row is the nearest range, the first
    column the beam farthest to port.
    """

    range_m: float
    tilt_rad: float
    bins: int = BINS
    beams: int = BEAMS

    def __post_init__(self) -> None:
        """Refuse an impossible device."""
        if not 0.0 < self.range_m <= FARTHEST_M:
            raise ValueError(f"a range of {self.range_m} m is not within 0..{FARTHEST_M:g} m")
        if not (16 <= self.bins <= 1024 and self.bins % 16 == 0):
            raise ValueError(f"{self.bins} bins are not a multiple of 16 within 16..1024")
        if not 2 <= self.beams <= 1024:
            raise ValueError(f"{self.beams} beams are not within 2..1024")

    @property
    def height(self) -> int:
        """Rows of the image."""
        return self.bins

    @property
    def width(self) -> int:
        """Columns of the image."""
        return self.beams

    @property
    def bin_m(self) -> float:
        """Range of one row."""
        return self.range_m / self.bins

    @property
    def spacing_rad(self) -> float:
        """Angle from one beam to the next."""
        return SECTOR_RAD / self.beams

    def azimuth_rad(self, column: float) -> float:
        """Return the direction of a beam from ahead, to starboard; columns count from 0."""
        return (column + 0.5) * self.spacing_rad - 0.5 * SECTOR_RAD
