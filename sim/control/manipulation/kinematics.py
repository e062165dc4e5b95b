"""Kinematics of an arm on its vehicle: forward, its Jacobian, and inverse.

Plain arithmetic on tuples, so that every processor gives the same numbers. Frames are those of the
field: p = R q + t takes a point of the inner axes to the outer ones; body axes are forward,
starboard, down. The authors of programs get this text too: seamark/programs/arm_helpers writes it
into a file of theirs, with another `sincos`.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

from seamark.sim.control.manipulation.arm_data import ArmData, Place, Vector
from seamark.sim.numerics.libm import sincos

Matrix = tuple[Vector, Vector, Vector]  # rows
NEAR_M = 1e-7  # of the point that an inverse is asked for
_STEPS = 100  # of an inverse from one start
_LEAST_DAMPING = 1e-4  # [m/rad] so that joints that do not move the tool stay
_LEAST_GAIN = 0.01  # share of the way that is left: with less, it is as close as it gets


class Frame(NamedTuple):
    """Axes in outer ones."""

    turn: Matrix
    point: Vector  # [m]


class ArmKinematics:
    """The chain of links from a vehicle's body to the tool of its arm."""

    def __init__(self, data: ArmData, mount: Place) -> None:
        self._chain = [(frame_of(link.place), link.axis, link.motor) for link in data.chain]
        self._mount, self._tool = frame_of(mount), frame_of(data.tool)
        self.motors = len(data.motors)
        self.ranges = [(motor.low, motor.high) for motor in data.motors]
        self.fastest = [motor.fastest for motor in data.motors]
        self.home = [motor.home for motor in data.motors]
        self.reaching = [link.motor for link in data.chain if link.motor >= 0]  # up to the tool

    def tool(self, joints: Sequence[float]) -> Frame:
        """Return the axes of the tool in the body: forward kinematics; it points along x."""
        return self._walk(joints)[0]

    def jacobian(self, joints: Sequence[float]) -> tuple[Frame, dict[int, tuple[Vector, Vector]]]:
        """Return the tool's axes, and what each joint does to it, in body axes.

        Returns
        -------
        Frame
            As `tool`.
        motor -> (velocity [m/rad], axis [rad/rad])
            Column of the geometric Jacobian: of the tool centre point and of the tool's attitude,
            per speed of the joint.
        """
        tool, axes = self._walk(joints)
        return tool, {
            motor: (cross(axis, minus(tool.point, origin)), axis)
            for motor, (axis, origin) in axes.items()
        }

    def inverse(self, point: Vector, start: Sequence[float]) -> list[float] | None:
        """Return joints that bring the tool centre point to a point in the body [m].

        They are within their ranges, and near `start` where a way leads on from there. None: no way
        does, from `start`, from home, or from eight and more postures all over the ranges. The
        tool's direction is what it is then, and a wrist that only rolls the tool stays.
        """
        for first in (start, self.home, *self._postures(start)):
            joints, off = self._descended(point, first)
            if off <= NEAR_M:
                return joints
        return None

    def _postures(self, start: Sequence[float]) -> list[list[float]]:
        """Return postures with each joint a quarter into its range from either end."""
        postures = [[*start]]
        for motor in self.reaching:
            low, high = self.ranges[motor]
            ends = (0.75 * low + 0.25 * high, 0.25 * low + 0.75 * high)
            postures = [
                [end if number == motor else joint for number, joint in enumerate(posture)]
                for posture in postures
                for end in ends
            ]
        return postures

    def _descended(self, point: Vector, start: Sequence[float]) -> tuple[list[float], float]:
        """Return joints from which no step comes closer, and how far the tool is from the point.

        Levenberg and Marquardt: the damping falls with each step that comes closer, and grows with
        each that does not.
        """
        joints = [
            min(max(joint, low), high)
            for joint, (low, high) in zip(start, self.ranges, strict=True)
        ]
        damping, off = 0.1, length(minus(point, self.tool(joints).point))
        for _ in range(_STEPS):
            if off <= NEAR_M:
                break
            tried = self._stepped(point, joints, damping)
            left = length(minus(point, self.tool(tried).point))
            if left < (1.0 - _LEAST_GAIN) * off:
                joints, off, damping = tried, left, max(0.2 * damping, _LEAST_DAMPING)
            elif damping > 10.0:
                break
            else:
                damping = 5.0 * damping
        return joints, off

    def _stepped(self, point: Vector, joints: list[float], damping: float) -> list[float]:
        """Return joints after one step towards a point; those at their ends go no further."""
        tool, columns = self.jacobian(joints)
        error, free = minus(point, tool.point), [*self.reaching]
        while True:
            moves = damped([columns[motor][0] for motor in free], error, damping)
            moved = {motor: joints[motor] + move for motor, move in zip(free, moves, strict=True)}
            stuck = [motor for motor in free if self._is_stuck(motor, joints[motor], moved[motor])]
            if not stuck:
                break
            free = [motor for motor in free if motor not in stuck]
        return [
            min(max(moved.get(motor, joint), self.ranges[motor][0]), self.ranges[motor][1])
            for motor, joint in enumerate(joints)
        ]

    def _is_stuck(self, motor: int, now: float, after: float) -> bool:
        low, high = self.ranges[motor]
        return (now <= low and after < low) or (now >= high and after > high)

    def _walk(self, joints: Sequence[float]) -> tuple[Frame, dict[int, tuple[Vector, Vector]]]:
        frame, axes = self._mount, {}
        for place, axis, motor in self._chain:
            frame = inner(frame, place)
            if motor >= 0:
                axes[motor] = applied(frame.turn, axis), frame.point
                frame = Frame(product(frame.turn, about(axis, joints[motor])), frame.point)
        return inner(frame, self._tool), axes


def damped(ways: list[Vector], wanted: Vector, damping: float) -> list[float]:
    """Return speeds of joints that give about a velocity: damped least squares (Nakamura 1986).

    Parameters
    ----------
    ways
        Of each joint, its column of the Jacobian [m/rad].
    damping
        [m/rad] The larger, the slower the joints where their ways are nearly parallel.
    """
    count = len(ways)
    gram = [
        [dot(ways[i], ways[j]) + (damping * damping if i == j else 0.0) for j in range(count)]
        for i in range(count)
    ]
    return solved(gram, [dot(way, wanted) for way in ways])


def solved(matrix: list[list[float]], right: list[float]) -> list[float]:
    """Return the solution of a symmetric positive definite system (Cholesky)."""
    n = len(right)
    lower = [[0.0] * n for _ in range(n)]
    for i in range(n):
        for j in range(i + 1):
            rest = matrix[i][j] - sum(lower[i][k] * lower[j][k] for k in range(j))
            lower[i][j] = math.sqrt(rest) if i == j else rest / lower[j][j]
    forward: list[float] = []
    for i in range(n):
        forward.append((right[i] - sum(lower[i][k] * forward[k] for k in range(i))) / lower[i][i])
    back = [0.0] * n
    for i in range(n - 1, -1, -1):
        above = sum(lower[k][i] * back[k] for k in range(i + 1, n))
        back[i] = (forward[i] - above) / lower[i][i]
    return back


def frame_of(place: Place) -> Frame:
    """Return the axes of a place."""
    return Frame(rotation(*place[1]), place[0])


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
    # Written out: a controller takes hundreds of products in each step.
    (a0, a1, a2), (a3, a4, a5), (a6, a7, a8) = a
    (b0, b1, b2), (b3, b4, b5), (b6, b7, b8) = b
    return (
        (a0 * b0 + a1 * b3 + a2 * b6, a0 * b1 + a1 * b4 + a2 * b7, a0 * b2 + a1 * b5 + a2 * b8),
        (a3 * b0 + a4 * b3 + a5 * b6, a3 * b1 + a4 * b4 + a5 * b7, a3 * b2 + a4 * b5 + a5 * b8),
        (a6 * b0 + a7 * b3 + a8 * b6, a6 * b1 + a7 * b4 + a8 * b7, a6 * b2 + a7 * b5 + a8 * b8),
    )


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


def length(a: Vector) -> float:
    """Return the length of a vector."""
    return math.sqrt(dot(a, a))


def plus(a: Vector, b: Vector) -> Vector:
    """Return the sum."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def minus(a: Vector, b: Vector) -> Vector:
    """Return the difference."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def times(a: Vector, factor: float) -> Vector:
    """Return a vector times a number."""
    return a[0] * factor, a[1] * factor, a[2] * factor
