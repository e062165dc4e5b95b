"""What a vehicle is: every number with its unit, its source and how reliable it is.

Body frame: x forward, y starboard, z down (Fossen 2021); the origin is the point that the lever
arms of the thrusters refer to.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from seamark.sim.numerics.arrays import Array
from seamark.sim.vehicles.solids import YELLOW, Solid

Tag = Literal["S", "M", "D", "E"]

TAGS: Mapping[Tag, str] = {
    "S": "sourced: published elsewhere",
    "M": "measured by who describes it",
    "D": "derived from sourced numbers",
    "E": "our estimate",
}
AXES = ("x", "y", "z", "roll", "pitch", "yaw")
STANDARD_GRAVITY = 9.80665  # [m/s²] BIPM


@dataclass(frozen=True, slots=True, kw_only=True)
class Quantity:
    """One or several numbers that belong together, and their source.

    `spread` has the least and the greatest value of each number that sources give, where they
    differ much.
    """

    meaning: str
    value: tuple[float, ...]
    unit: str
    tag: Tag
    source: str
    spread: tuple[tuple[float, ...], tuple[float, ...]] | None = None

    @property
    def scalar(self) -> float:
        """The value of a quantity with one number."""
        (value,) = self.value
        return value


@dataclass(frozen=True, slots=True, kw_only=True)
class Place:
    """Where axes are in others: at a point, turned by roll, then pitch, then yaw."""

    point: Quantity  # (3,) [m]
    turn: Quantity  # (3,) [rad]


@dataclass(frozen=True, slots=True, kw_only=True)
class Thruster:
    """A thruster: positive thrust pushes the vehicle along `direction`."""

    name: str
    position: Quantity  # (3,) [m] body frame
    direction: tuple[float, float, float]  # unit vector, body frame


@dataclass(frozen=True, slots=True, kw_only=True)
class ThrustCurve:
    """Steady thrust as a function of the command in [-1, 1].

    `kind` says what the coefficients mean:

    quadratic
        Thrust [N] is c0 * command², per direction.
    polynomial
        Command is c0 + c1 f + c2 f² + ... of the thrust f [N]; the curve is its inverse.

    Commands within the dead band give no thrust; thrust is limited to `limits` (forward, reverse,
    both positive).
    """

    kind: Literal["quadratic", "polynomial"]
    forward: Quantity
    reverse: Quantity
    dead_band: Quantity
    limits: Quantity


@dataclass(frozen=True, slots=True, kw_only=True)
class HullBox:
    """One convex piece of the hull for contacts: a box along the body axes."""

    name: str
    centre: Quantity  # (3,) [m]
    size: Quantity  # (3,) [m] whole lengths


@dataclass(frozen=True, slots=True, kw_only=True)
class Vehicle:
    """The parameters of a vehicle.

    `added_mass`, `drag_linear` and `drag_quadratic` are groups that together have six numbers:
    x, y, z, roll, pitch, yaw. They are positive; Fossen's derivatives are their negatives.
    `defaults` are configuration values that are set when this vehicle is chosen. `solids` and
    `nozzle_radius_m` are what it looks like, without effect on a run. `mounts` say where an arm of
    that name is put, in the body frame.
    """

    name: str
    title: str
    summary: str
    mass: Quantity
    inertia: Quantity  # (3,) [kg m²] diagonal
    inertia_point: Literal["gravity", "origin"]
    added_mass: tuple[Quantity, ...]
    drag_linear: tuple[Quantity, ...]
    drag_quadratic: tuple[Quantity, ...]
    weight: Quantity
    buoyancy: Quantity
    centre_of_gravity: Quantity
    centre_of_buoyancy: Quantity
    thrusters: tuple[Thruster, ...]
    curve: ThrustCurve
    lag: Quantity
    hull: tuple[HullBox, ...]
    defaults: Mapping[str, object] = field(default_factory=dict)
    solids: tuple[Solid, ...] = ()  # none: its hull boxes
    nozzle_radius_m: float = 0.05  # of its thrusters
    mounts: Mapping[str, Place] = field(default_factory=dict)

    def quantities(self) -> Iterator[tuple[str, Quantity]]:
        """Yield every number of the vehicle with a readable name, for tables and manifests."""
        for key in ("mass", "inertia", "added_mass", "drag_linear", "drag_quadratic"):
            entry = getattr(self, key)
            yield from ((key, q) for q in (entry if isinstance(entry, tuple) else (entry,)))
        for key in ("weight", "buoyancy", "centre_of_gravity", "centre_of_buoyancy", "lag"):
            yield key, getattr(self, key)
        for key in ("forward", "reverse", "dead_band", "limits"):
            yield f"curve {key}", getattr(self.curve, key)
        for thruster in self.thrusters:
            yield f"thruster {thruster.name}", thruster.position
        for piece in self.hull:
            yield f"hull {piece.name} centre", piece.centre
            yield f"hull {piece.name} size", piece.size
        for arm, place in self.mounts.items():
            yield f"mount {arm}", place.point
            yield f"mount {arm} turn", place.turn

    def mass_rigid(self) -> Array:
        """Return the rigid body's mass matrix about the origin, (6, 6) [kg, kg m, kg m²]."""
        mass = self.mass.scalar
        x, y, z = self.centre_of_gravity.value
        offset = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        matrix = np.zeros((6, 6))
        matrix[0, 0] = matrix[1, 1] = matrix[2, 2] = mass
        matrix[:3, 3:] = -mass * offset
        matrix[3:, :3] = mass * offset
        squares = np.array([[y * y + z * z, -x * y, -x * z],
                            [-x * y, x * x + z * z, -y * z],
                            [-x * z, -y * z, x * x + y * y]])  # fmt: skip
        for i, inertia in enumerate(self.inertia.value):
            matrix[3 + i, 3 + i] = inertia
        if self.inertia_point == "gravity":
            matrix[3:, 3:] += mass * squares
        return matrix

    def inertia_about_gravity(self) -> tuple[float, ...]:
        """Return the rigid body's moments of inertia about its centre of gravity, (3,) [kg m²]."""
        if self.inertia_point == "gravity":
            return self.inertia.value
        squares = [value * value for value in self.centre_of_gravity.value]
        return tuple(
            value - self.mass.scalar * (sum(squares) - own)
            for value, own in zip(self.inertia.value, squares, strict=True)
        )

    def mass_added(self) -> Array:
        """Return the added mass about the origin, (6, 6) diagonal [kg, kg m²]."""
        matrix = np.zeros((6, 6))
        for i, value in enumerate(_joined(self.added_mass)):
            matrix[i, i] = value
        return matrix

    def linear_drag(self) -> Array:
        """Return the linear drag, (6,) positive [N s/m, N m s]."""
        return _joined(self.drag_linear)

    def quadratic_drag(self) -> Array:
        """Return the quadratic drag, (6,) positive [N s²/m², N m s²]."""
        return _joined(self.drag_quadratic)

    def allocation(self) -> Array:
        """Return the thruster matrix, (6, n): the wrench of each unit thrust about the origin."""
        matrix = np.zeros((6, len(self.thrusters)))
        for i, thruster in enumerate(self.thrusters):
            (x, y, z), (a, b, c) = thruster.position.value, thruster.direction
            matrix[:, i] = a, b, c, y * c - z * b, z * a - x * c, x * b - y * a
        return matrix

    def drawn(self) -> tuple[Solid, ...]:
        """Return what it looks like: its solids, or its hull boxes."""
        boxes = ((box.size.value, box.centre.value) for box in self.hull)
        hull = (Solid("box", (a, b, c), (x, y, z), YELLOW) for (a, b, c), (x, y, z) in boxes)
        return self.solids or tuple(hull)

    def hull_radius(self) -> float:
        """Return the radius [m] of the sphere about the origin that contains the whole hull."""
        corners = [
            sum((abs(c) + 0.5 * s) ** 2 for c, s in zip(p.centre.value, p.size.value, strict=True))
            for p in self.hull
        ]
        return float(np.sqrt(max(corners)))


def _joined(groups: tuple[Quantity, ...]) -> Array:
    values = [value for group in groups for value in group.value]
    if len(values) != 6:
        raise ValueError(f"six numbers are needed, not {len(values)}: {groups[0].meaning}")
    return np.array(values)
