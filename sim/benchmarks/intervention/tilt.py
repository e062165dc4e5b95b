"""The tilt of what is worked on: about a level axis in any direction."""

from dataclasses import dataclass

import numpy as np

from seamark.sim.camera.target import Target
from seamark.sim.multibody.assembly import Frame
from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.libm import PI, asin, atan2, sincos
from seamark.sim.vehicles.matrices import multiplied

Attitude = tuple[float, float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Tilt:
    """How far something is tilted, and about which level axis."""

    angle_rad: float = 0.0
    axis_rad: float = 0.0  # direction of the axis, clockwise from north

    def matrix(self) -> Array:
        """Return the rotation (3, 3) that tilts level axes, NED."""
        (sine, cosine), (east, north) = sincos(self.angle_rad), sincos(self.axis_rad)
        rest = 1.0 - cosine
        return np.array(
            [
                [cosine + rest * north * north, rest * north * east, sine * east],
                [rest * north * east, cosine + rest * east * east, -sine * north],
                [-sine * east, sine * north, cosine],
            ]
        )

    def attitude(self, heading_rad: float) -> Attitude:
        """Return roll, pitch and yaw [rad] of axes with this heading after they were tilted."""
        if self.angle_rad == 0.0:  # the heading as it is, to the last bit
            return 0.0, 0.0, heading_rad
        sine, cosine = sincos(heading_rad)
        level = [[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]]
        turn = multiplied(self.matrix(), level)
        pitch = asin(min(max(-turn[2, 0], -1.0), 1.0))
        return atan2(turn[2, 1], turn[2, 2]), pitch, atan2(turn[1, 0], turn[0, 0])

    def face_of(self, panel: Target) -> Frame:
        """Return the axes of a panel's upper face, which is tilted about its middle.

        Right and down as one reads its letters, and into it.
        """
        level = np.column_stack([*panel.axes(), [0.0, 0.0, 1.0]])
        return Frame(None, panel.top_centre(), multiplied(self.matrix(), level))


def tilt_of(most_rad: float, shares: tuple[float, float]) -> Tilt:
    """Return a tilt of at most this, from two shares of 1: of the angle and of the full circle."""
    angle, axis = shares
    return Tilt(angle_rad=most_rad * angle, axis_rad=PI * (2.0 * axis - 1.0))
