"""Linkages as data: arms, and things that they take hold of.

A linkage is a tree of links. A link's axes are those of its joint's place at coordinate zero; its
numbers are in these axes, whose origin is on the joint. The first links hang on what carries the
linkage: a vehicle, or the world.
"""

from collections.abc import Iterator
from dataclasses import dataclass, fields
from typing import Literal

import numpy as np

from seamark.sim.numerics.arrays import Array
from seamark.sim.vehicles.matrices import shifted
from seamark.sim.vehicles.model import Place, Quantity
from seamark.sim.vehicles.solids import Solid

Point = tuple[float, float, float]
Kind = Literal["arm", "thing"]
JointKind = Literal["fixed", "free", "revolute", "prismatic"]
ShapeKind = Literal["capsule", "box", "cylinder", "socket"]
# Pairs of kinds whose contact is known, in any order.
TOUCHING = frozenset(
    {
        frozenset({"capsule"}),
        frozenset({"capsule", "box"}),
        frozenset({"capsule", "cylinder"}),
        frozenset({"box"}),
        frozenset({"cylinder", "socket"}),
    }
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Joint:
    """How a link moves against its parent.

    `effort` is the most that its motor gives [N m or N], `speed` the fastest it turns [rad/s or
    m/s]; a joint without them is passive. `friction` is to break away, and in motion. One that
    `follows` another has that one's coordinate times a ratio. `home` is where it starts.
    """

    kind: JointKind
    place: Place
    axis: Point = (0.0, 0.0, 1.0)
    range: Quantity | None = None
    home: Quantity | None = None
    effort: Quantity | None = None
    speed: Quantity | None = None
    friction: Quantity | None = None
    rotor: Quantity | None = None
    follows: tuple[str, float] | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Body:
    """Mass, buoyancy and water of a link; added mass and drag are about `centre`."""

    mass: Quantity
    volume: Quantity
    centre_of_mass: Quantity  # (3,) [m]
    centre_of_buoyancy: Quantity  # (3,) [m]
    inertia: Quantity  # (6,) about the centre of mass: xx, yy, zz, xy, xz, yz [kg m²]
    added_mass: Quantity  # (3,) [kg]
    added_inertia: Quantity  # (3,) [kg m²]
    linear_drag: Quantity  # (3,) [N s/m]
    quadratic_drag: Quantity  # (3,) [N s²/m²]
    turning_drag: Quantity  # (3,) [N m s²]
    centre: Quantity  # (3,) [m]

    def rigid(self) -> Array:
        """Return the rigid mass matrix about the link's origin, (6, 6)."""
        xx, yy, zz, xy, xz, yz = self.inertia.value
        matrix = np.zeros((6, 6))
        matrix[:3, :3] = self.mass.scalar * np.eye(3)
        matrix[3:, 3:] = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
        return shifted(matrix, self.centre_of_mass.value)

    def added(self) -> Array:
        """Return the added mass about the link's origin, (6, 6)."""
        diagonal = np.diag([*self.added_mass.value, *self.added_inertia.value])
        return shifted(diagonal, self.centre.value)

    def weights(self, density: float, gravity: float) -> tuple[float, Array]:
        """Return the weight in water [N], and the moment of weight and buoyancy, (3,) [N m]."""
        weight = self.mass.scalar * gravity
        buoyancy = self.volume.scalar * density * gravity
        moment = weight * np.array(self.centre_of_mass.value)
        return weight - buoyancy, moment - buoyancy * np.array(self.centre_of_buoyancy.value)


@dataclass(frozen=True, slots=True, kw_only=True)
class Touchable:
    """A primitive for contacts; capsules, cylinders and sockets lie along their x axis.

    `size` is radius and half length; half lengths; or radius, depth and chamfer of a hole [m].
    """

    name: str
    kind: ShapeKind
    place: Place
    size: Quantity  # (2,) or (3,) [m]
    friction: Quantity


@dataclass(frozen=True, slots=True, kw_only=True)
class LinkData:
    """A link: its joint, its body if it has mass, what it touches with, and its looks."""

    name: str
    parent: str | None
    joint: Joint
    body: Body | None
    shapes: tuple[Touchable, ...] = ()
    solids: tuple[Solid, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Spot:
    """A place on a link: of a camera, of the tool centre point, or where a force is measured."""

    link: str
    place: Place


@dataclass(frozen=True, slots=True, kw_only=True)
class Linkage:
    """An arm or a thing. Links are sorted: a parent comes before its children.

    `touches` are pairs of its own shapes that may touch. Shapes in `outer` may touch those of other
    linkages and the bottom, those in `hull` the vehicle that carries it.
    """

    kind: Kind
    name: str
    title: str
    summary: str
    links: tuple[LinkData, ...]
    touches: tuple[tuple[str, str], ...] = ()
    outer: tuple[str, ...] = ()
    hull: tuple[str, ...] = ()
    camera: Spot | None = None
    force_sensor: Spot | None = None
    tool: Spot | None = None  # tool centre point; the tool points along x

    def link(self, name: str) -> LinkData:
        """Return a link by its name."""
        return next(link for link in self.links if link.name == name)

    def motors(self) -> tuple[str, ...]:
        """Return the links whose joints have a motor, in the order of commands."""
        return tuple(link.name for link in self.links if link.joint.effort is not None)

    def shapes(self) -> tuple[str, ...]:
        """Return the names of all shapes."""
        return tuple(shape.name for link in self.links for shape in link.shapes)

    def mass(self) -> float:
        """Return the mass of all links [kg]."""
        return sum(link.body.mass.scalar for link in self.links if link.body)

    def quantities(self) -> Iterator[tuple[str, Quantity]]:
        """Yield every number with a readable name, for tables and manifests."""
        for link in self.links:
            parts: list[object] = [link.joint.place, link.joint, *link.shapes]
            parts += [shape.place for shape in link.shapes] + ([link.body] if link.body else [])
            for part in parts:
                values = (getattr(part, each.name) for each in fields(part))  # type: ignore[arg-type]
                for value in values:
                    if isinstance(value, Quantity):
                        yield f"{link.name}: {value.meaning}", value
        for spot in (self.camera, self.force_sensor, self.tool):
            if spot:
                yield f"{spot.link}: place", spot.place.point
                yield f"{spot.link}: turn", spot.place.turn
