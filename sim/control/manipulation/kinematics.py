"""Kinematics of an arm on its vehicle: forward, and its Jacobian.

Plain arithmetic on tuples, so that every processor gives the same numbers. Frames are those of the
field: p = R q + t takes a point of the inner axes to the outer ones; body axes are forward,
starboard, down.
"""

from collections.abc import Sequence
from typing import NamedTuple

from seamark.sim.numerics.libm import sincos
from seamark.sim.vehicles import Vehicle
from seamark.sim.vehicles.linkage import Linkage
from seamark.sim.vehicles.model import Place

Vector = tuple[float, float, float]
Matrix = tuple[Vector, Vector, Vector]  # rows


class Frame(NamedTuple):
    """Axes in outer ones."""

    turn: Matrix
    point: Vector  # [m]


class _Link(NamedTuple):
    """A link on the way from the mount to the tool."""

    place: Frame
    axis: Vector
    motor: int  # number of its joint among the motors, or -1 if it is fixed


class ArmKinematics:
    """The chain of links from a vehicle's body to the tool of its arm."""

    def __init__(self, vehicle: Vehicle, arm: Linkage) -> None:
        """Take an arm whose joints up to its tool turn or are fixed.

        Raises
        ------
        ValueError
            The arm has no tool, or a joint slides.
        """
        if arm.tool is None:
            raise ValueError(f"{arm.name} has no tool")
        motors = arm.motors()
        chain: list[_Link] = []
        name: str | None = arm.tool.link
        while name is not None:
            link = arm.link(name)
            if link.joint.kind not in ("fixed", "revolute"):
                raise ValueError(f"the joint of {name} does not turn")
            motor = motors.index(name) if name in motors else -1
            chain.insert(0, _Link(frame_of(link.joint.place), link.joint.axis, motor))
            name = link.parent
        self._chain = chain
        self._mount, self._tool = frame_of(vehicle.mounts[arm.name]), frame_of(arm.tool.place)
        self.motors = len(motors)
        joints = [arm.link(motor).joint for motor in motors]
        self.ranges = [joint.range.value if joint.range else (-10.0, 10.0) for joint in joints]
        self.fastest = [joint.speed.scalar if joint.speed else 0.0 for joint in joints]
        self.home = [joint.home.scalar if joint.home else 0.0 for joint in joints]
        self.reaching = [link.motor for link in chain if link.motor >= 0]  # joints up to the tool

    def tool(self, joints: Sequence[float]) -> Frame:
        """Return the axes of the tool in the body; it points along its x axis."""
        return self._walk(joints)[0]

    def jacobian(self, joints: Sequence[float]) -> tuple[Frame, dict[int, tuple[Vector, Vector]]]:
        """Return the tool's axes, and what each joint does to it, in body axes.

        Returns
        -------
        Frame
            As `tool`.
        motor -> (velocity [m/rad], axis [rad/rad])
            Of the tool centre point and of its attitude, per speed of the joint.
        """
        tool, axes = self._walk(joints)
        return tool, {
            motor: (cross(axis, minus(tool.point, origin)), axis)
            for motor, (axis, origin) in axes.items()
        }

    def _walk(self, joints: Sequence[float]) -> tuple[Frame, dict[int, tuple[Vector, Vector]]]:
        frame, axes = self._mount, {}
        for link in self._chain:
            frame = inner(frame, link.place)
            if link.motor >= 0:
                axes[link.motor] = applied(frame.turn, link.axis), frame.point
                own = about(link.axis, joints[link.motor])
                frame = Frame(product(frame.turn, own), frame.point)
        return inner(frame, self._tool), axes


def frame_of(place: Place) -> Frame:
    """Return the axes of a place in a file: point [m], and roll, pitch, yaw [rad]."""
    x, y, z = place.point.value
    roll, pitch, yaw = place.turn.value
    return Frame(rotation(roll, pitch, yaw), (x, y, z))


def rotation(roll: float, pitch: float, yaw: float) -> Matrix:
    """Return the matrix that takes vectors of axes with this attitude [rad] to the outer ones."""
    (sr, cr), (sp, cp), (sy, cy) = sincos(roll), sincos(pitch), sincos(yaw)
    return (
        (cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
        (sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
        (-sp, cp * sr, cp * cr),
    )


def about(axis: Vector, angle: float) -> Matrix:
    """Return the rotation about a unit vector (Rodrigues)."""
    x, y, z = axis
    s, c = sincos(angle)
    d = 1.0 - c
    return (
        (c + d * x * x, d * x * y - s * z, d * x * z + s * y),
        (d * x * y + s * z, c + d * y * y, d * y * z - s * x),
        (d * x * z - s * y, d * y * z + s * x, c + d * z * z),
    )


def inner(outer: Frame, place: Frame) -> Frame:
    """Return axes that are placed in others, in those that the others are in."""
    return Frame(
        product(outer.turn, place.turn), plus(outer.point, applied(outer.turn, place.point))
    )


def product(a: Matrix, b: Matrix) -> Matrix:
    """Return the product of two matrices."""
    columns = transposed(b)
    rows = [tuple(dot(row, column) for column in columns) for row in a]
    return rows[0], rows[1], rows[2]  # type: ignore[return-value]


def transposed(a: Matrix) -> Matrix:
    """Return the transpose: the inverse of a rotation."""
    return column(a, 0), column(a, 1), column(a, 2)


def column(a: Matrix, number: int) -> Vector:
    """Return a column of a matrix: of a rotation, an inner axis in outer axes."""
    return a[0][number], a[1][number], a[2][number]


def applied(a: Matrix, v: Vector) -> Vector:
    """Return a matrix times a vector."""
    return dot(a[0], v), dot(a[1], v), dot(a[2], v)


def dot(a: Vector, b: Vector) -> float:
    """Return the scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector, b: Vector) -> Vector:
    """Return the vector product."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def plus(a: Vector, b: Vector) -> Vector:
    """Return the sum."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def minus(a: Vector, b: Vector) -> Vector:
    """Return the difference."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def times(a: Vector, factor: float) -> Vector:
    """Return a vector times a number."""
    return a[0] * factor, a[1] * factor, a[2] * factor
