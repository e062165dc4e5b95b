"""An arm as plain data: what its kinematics are computed from."""

from typing import NamedTuple

Vector = tuple[float, float, float]
Place = tuple[Vector, Vector]  # point [m]; roll, then pitch, then yaw [rad]


class Link(NamedTuple):
    """A link on the way from the mount to the tool; its joint turns it about a unit vector."""

    name: str
    place: Place  # of its joint, in the link before
    axis: Vector
    motor: int  # number of its joint among the motors, or -1 if it is fixed


class Motor(NamedTuple):
    """A joint with a motor, in the order of commands and observations."""

    name: str
    low: float  # [rad]
    high: float  # [rad]
    fastest: float  # [rad/s]
    home: float  # [rad]


class ArmData(NamedTuple):
    """What is known of an arm."""

    motors: tuple[Motor, ...]
    chain: tuple[Link, ...]
    tool: Place  # the tool centre point, in the last link; the tool points along its x axis
