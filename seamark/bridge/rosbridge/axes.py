"""The axes in which a program speaks: those of Seamark, or those that ROS uses (REP 103).

The turn between them swaps axes and signs alone, so a controller that is written in either gives
the same result, bit for bit.
"""

from enum import StrEnum
from math import sqrt

from seamark.sim.engine.program import Command

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]  # x, y, z, w as in ROS


class Axes(StrEnum):
    """By the name of the world's."""

    NED = "ned"  # north, east, down; forward, starboard, down
    ENU = "enu"  # east, north, up; forward, port, up

    @property
    def body(self) -> str:
        """The frame of the vehicle."""
        return "base_link_frd" if self is Axes.NED else "base_link"

    @property
    def world(self) -> str:
        """The frame of dead reckoning, which drifts: in ROS that is `odom` (REP 105)."""
        return "map_ned" if self is Axes.NED else "odom"

    @property
    def meaning(self) -> str:
        """What x, y and z of the vehicle are."""
        down = self is Axes.NED
        return f"{self.body}: forward, {'starboard, down' if down else 'port, up'}"

    @property
    def other(self) -> "Axes":
        """The other axes."""
        return Axes.ENU if self is Axes.NED else Axes.NED

    def of_body(self, vector: list[float]) -> Vector:
        """Return a vector of forward, starboard, down in these axes, or the other way round."""
        x, y, z = vector
        # Not -y: the answer to an error of 0 must not become -0, which is another digest.
        return (x, y, z) if self is Axes.NED else (x, 0.0 - y, 0.0 - z)

    def of_world(self, vector: Vector) -> Vector:
        """Return a vector of north, east, down in these axes."""
        north, east, down = vector
        return vector if self is Axes.NED else (east, north, 0.0 - down)

    def of_orientation(self, quaternion: Quaternion) -> Quaternion:
        """Return an attitude of forward, starboard, down in north, east, down in these axes."""
        if self is Axes.NED:
            return quaternion
        x, y, z, w = quaternion
        half = sqrt(0.5)
        return half * (x + y), half * (x - y), half * (w - z), half * (w + z)

    def command(self, reference: Command) -> Command:
        """Return surge, sway, heave and yaw rate of a reference in these axes."""
        *linear, turn = reference
        return (*self.of_body(linear), turn if self is Axes.NED else 0.0 - turn)
