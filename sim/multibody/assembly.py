"""Mechanisms from data: a vehicle, its arm, and things that it may touch."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from seamark.sim.multibody.mechanism import (
    Coupling,
    Friction,
    Limits,
    Link,
    Mechanism,
    Motor,
    Point,
    Shape,
    state_for,
)
from seamark.sim.multibody.step import Model, State
from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.libm import sincos
from seamark.sim.physics import constants
from seamark.sim.physics.contact import TargetBox
from seamark.sim.vehicles import STANDARD_GRAVITY, Quantity, Vehicle
from seamark.sim.vehicles.linkage import (
    TOUCHING,
    Body,
    Joint,
    Linkage,
    LinkData,
    Spot,
    Touchable,
)
from seamark.sim.vehicles.matrices import applied, multiplied, quaternion_of, shifted, turned
from seamark.sim.vehicles.model import Place
from seamark.sim.vehicles.solids import Solid

VEHICLE = "vehicle"
BOTTOM = "bottom"
_HULL = "vehicle: hull "  # names in files have no colon


@dataclass(frozen=True, slots=True, kw_only=True)
class Mounting:
    """A linkage and where it is: on the vehicle, or in the world.

    `prefix` is put before the names of its links and shapes, where two linkages share names.
    """

    linkage: Linkage
    place: Place
    on_vehicle: bool = False
    prefix: str = ""


@dataclass(frozen=True, slots=True)
class Frame:
    """Axes in those of a link of the mechanism, or of the world."""

    link: str | None
    point: Array  # (3,) [m]
    turn: Array  # (3, 3) into the axes of the link

    def inner(self, place: Place) -> "Frame":
        """Return axes that are placed in these."""
        point = self.at(place.point.value)
        return Frame(self.link, point, multiplied(self.turn, _rotation(place)))

    def at(self, point: Sequence[float]) -> Array:
        """Return a point of these axes in those of the link, (3,) [m]."""
        return self.point + applied(self.turn, point)


@dataclass(frozen=True, slots=True)
class Look:
    """A solid that is drawn, and the axes that it lies in."""

    on: Frame
    solid: Solid


@dataclass(slots=True, kw_only=True)
class Assembly:
    """A mechanism with the names and limits that commands and sensors need.

    An arm is a linkage on the vehicle.
    """

    mechanism: Mechanism
    motors: tuple[str, ...]  # links, in the order of commands
    fastest: tuple[float, ...]  # of each motor [rad/s or m/s]
    starts: Mapping[str, tuple[Array, Array]]  # of free links: point and rotation
    homes: Mapping[str, float]  # of joints: coordinate at the start [rad or m]
    hull: tuple[str, ...] = ()  # shapes of the vehicle
    arm: tuple[str, ...] = ()  # shapes of its arm, and of these
    feelers: tuple[str, ...] = ()  # those that may touch something
    force_sensor: Frame | None = None  # on the arm
    camera: Frame | None = None  # on the arm; it looks along x
    tool: Frame | None = None  # tool centre point of the arm
    looks: tuple[Look, ...] = ()

    def state(self, model: Model) -> State:
        """Return a state at rest, free things where they were put."""
        state = state_for(model)
        for name, (point, turn) in self.starts.items():
            at = self.coordinate(model, name)
            state.q[at : at + 3] = point
            state.q[at + 3 : at + 7] = quaternion_of(turn)
        for name, home in self.homes.items():
            state.q[self.coordinate(model, name)] = home
        return state

    def coordinate(self, model: Model, link: str) -> int:
        """Return where the coordinates of a link begin."""
        return int(model.structure.coordinate[self.mechanism.number(link)])


def assemble(
    vehicle: Vehicle | None, mountings: Sequence[Mounting], *, bottom: bool = True
) -> Assembly:
    """Return the mechanism of a vehicle, linkages on it, and linkages in the world."""
    mechanism = Mechanism(links=[])
    starts: dict[str, tuple[Array, Array]] = {}
    frames: dict[str, Frame] = {}
    if vehicle is not None:
        _add_vehicle(vehicle, mechanism)
    hull = tuple(shape.name for shape in mechanism.shapes)
    if bottom:
        friction = constants.FRICTION.scalar
        mechanism.shapes.append(Shape(name=BOTTOM, kind="ground", friction=friction))
    for mounting in mountings:
        placed, free = _add_linkage(mounting, mechanism)
        frames |= placed
        starts |= free
    mechanism.pairs = list(_pairs(mechanism, mountings))
    moved = [
        (f"{mounting.prefix}{link.name}", link.joint)
        for mounting in mountings
        for link in mounting.linkage.links
    ]
    arm = next((mounting for mounting in mountings if mounting.on_vehicle), None)
    return Assembly(
        mechanism=mechanism,
        motors=tuple(name for name, joint in moved if joint.speed),
        fastest=tuple(joint.speed.scalar for _, joint in moved if joint.speed),
        starts=starts,
        homes={name: joint.home.scalar for name, joint in moved if joint.home},
        hull=hull,
        arm=() if arm is None else _own(arm, arm.linkage.shapes()),
        feelers=() if arm is None else _own(arm, arm.linkage.outer),
        force_sensor=None if arm is None else _spot(arm, arm.linkage.force_sensor, frames),
        camera=None if arm is None else _spot(arm, arm.linkage.camera, frames),
        tool=None if arm is None else _spot(arm, arm.linkage.tool, frames),
        looks=tuple(_looks(vehicle, mountings, frames)),
    )


def _looks(
    vehicle: Vehicle | None, mountings: Sequence[Mounting], frames: Mapping[str, Frame]
) -> Iterator[Look]:
    """Yield the solids of a vehicle, then those of linkages."""
    for solid in vehicle.drawn() if vehicle else ():
        yield Look(Frame(VEHICLE, np.zeros(3), np.eye(3)), solid)
    for mounting in mountings:
        for link in mounting.linkage.links:
            for solid in link.solids:
                yield Look(frames[f"{mounting.prefix}{link.name}"], solid)


def _own(mounting: Mounting, names: Sequence[str]) -> tuple[str, ...]:
    return tuple(f"{mounting.prefix}{name}" for name in names)


def _spot(mounting: Mounting, spot: Spot | None, frames: Mapping[str, Frame]) -> Frame | None:
    return None if spot is None else frames[f"{mounting.prefix}{spot.link}"].inner(spot.place)


def fixed_box(box: TargetBox) -> Mounting:
    """Return a box in the world that nothing can move."""

    def estimate(meaning: str, *value: float) -> Quantity:
        return Quantity(meaning=meaning, value=value, unit="SI", tag="E", source="the scene")

    place, here = (
        Place(point=estimate("place", *point), turn=estimate("turn", 0.0, 0.0, yaw))
        for point, yaw in ((box.centre, box.yaw), ((0.0, 0.0, 0.0), 0.0))
    )
    shape = Touchable(
        name="target",
        kind="box",
        place=here,
        size=estimate("half lengths", *(0.5 * side for side in box.size)),
        friction=estimate("friction", constants.FRICTION.scalar),
    )
    link = LinkData(
        name="target",
        parent=None,
        joint=Joint(kind="fixed", place=here),
        body=None,
        shapes=(shape,),
    )
    linkage = Linkage(
        kind="thing", name="target", title="Target", summary="", links=(link,), outer=("target",)
    )
    return Mounting(linkage=linkage, place=place)


def standing_shapes(mounting: Mounting) -> list[Shape]:
    """Return the shapes of a thing in the world, none of whose links moves.

    Raises
    ------
    ValueError
        One of them does.
    """
    mechanism = Mechanism(links=[])
    _add_linkage(mounting, mechanism)
    if mechanism.links:
        raise ValueError(f"{mounting.linkage.name} has a link that moves")
    return mechanism.shapes


def vehicle_link(vehicle: Vehicle) -> Link:
    """Return the link of a vehicle."""
    weight, buoyancy = vehicle.weight.scalar, vehicle.buoyancy.scalar
    centres = vehicle.centre_of_gravity.value, vehicle.centre_of_buoyancy.value
    moment = weight * np.array(centres[0]) - buoyancy * np.array(centres[1])
    return Link(
        name=VEHICLE,
        rigid=vehicle.mass_rigid(),
        added=vehicle.mass_added(),
        net_weight=weight - buoyancy,
        moment=_point(moment),
        linear=vehicle.linear_drag().tolist(),
        quadratic=vehicle.quadratic_drag().tolist(),
    )


def hull_shapes(vehicle: Vehicle) -> list[Shape]:
    """Return the boxes of a vehicle's hull, on the link of the vehicle."""
    return [
        Shape(
            name=f"{_HULL}{i}",
            kind="box",
            link=VEHICLE,
            place=_point(np.array(piece.centre.value)),
            size=_point(0.5 * np.array(piece.size.value)),
            friction=constants.FRICTION.scalar,
        )
        for i, piece in enumerate(vehicle.hull)
    ]


def _add_vehicle(vehicle: Vehicle, mechanism: Mechanism) -> None:
    mechanism.links.append(vehicle_link(vehicle))
    mechanism.allocation, mechanism.lag_s = vehicle.allocation(), vehicle.lag.scalar
    mechanism.shapes += hull_shapes(vehicle)


def _add_linkage(
    mounting: Mounting, mechanism: Mechanism
) -> tuple[dict[str, Frame], dict[str, tuple[Array, Array]]]:
    """Add a linkage; return the frames of its links, and where its free links start."""
    carrier = Frame(VEHICLE if mounting.on_vehicle else None, np.zeros(3), np.eye(3))
    root = carrier.inner(mounting.place)
    frames: dict[str, Frame] = {}
    starts = {}
    for link in mounting.linkage.links:
        outer = root if link.parent is None else frames[link.parent]
        frame = outer.inner(link.joint.place)
        name = f"{mounting.prefix}{link.name}"
        if link.joint.kind == "fixed":
            frames[link.name] = frame
            _merge_body(link, frame, mechanism)
        else:
            frames[link.name] = Frame(name, np.zeros(3), np.eye(3))
            mechanism.links.append(_link(link, name, frame))
            _add_rows(link, name, mounting.prefix, mechanism)
        if link.joint.kind == "free":
            starts[name] = frame.point, frame.turn
        mechanism.shapes += [
            _shape(shape, f"{mounting.prefix}{shape.name}", frames[link.name])
            for shape in link.shapes
        ]
    return {f"{mounting.prefix}{name}": frame for name, frame in frames.items()}, starts


def _link(link: LinkData, name: str, frame: Frame) -> Link:
    body, joint = link.body, link.joint
    if body is None or joint.kind == "fixed":
        raise ValueError(f"{link.name} does not move by itself, or has no mass")
    net_weight, moment = body.weights(constants.WATER_DENSITY.scalar, STANDARD_GRAVITY)
    free = joint.kind == "free"
    return Link(
        name=name,
        parent=frame.link,
        joint=joint.kind,
        offset=(0.0, 0.0, 0.0) if free else _point(frame.point),
        turn=np.eye(3).tolist() if free else frame.turn.tolist(),
        axis=joint.axis,
        rigid=body.rigid(),
        added=body.added(),
        rotor=joint.rotor.scalar if joint.rotor else 0.0,
        net_weight=net_weight,
        moment=_point(moment),
        linear=(*body.linear_drag.value, 0.0, 0.0, 0.0),
        quadratic=(*body.quadratic_drag.value, *body.turning_drag.value),
        centre=_point(np.array(body.centre.value)),
    )


def _merge_body(link: LinkData, frame: Frame, mechanism: Mechanism) -> None:
    """Add the body of a fixed link to that of the link which carries it.

    Its drag is added along the carrier's axes: exact for motion along one of them.
    """
    body = link.body
    if body is None or frame.link is None:
        return
    carrier = mechanism.links[mechanism.number(frame.link)]
    carrier.rigid = carrier.rigid + shifted(turned(body.rigid(), frame.turn), frame.point)
    carrier.added = carrier.added + shifted(turned(body.added(), frame.turn), frame.point)
    net_weight, moment = body.weights(constants.WATER_DENSITY.scalar, STANDARD_GRAVITY)
    carrier.net_weight += net_weight
    there = applied(frame.turn, moment) + net_weight * frame.point
    carrier.moment = _point(np.array(carrier.moment) + there)
    _merge_drag(body, frame, carrier)


def _merge_drag(body: Body, frame: Frame, carrier: Link) -> None:
    lever = frame.point + applied(frame.turn, body.centre.value)
    reach = np.sqrt(np.roll(lever, 1) * np.roll(lever, 1) + np.roll(lever, 2) * np.roll(lever, 2))
    size = np.abs(frame.turn)
    linear = applied(size * size, body.linear_drag.value)
    quadratic = applied(size * size * size, body.quadratic_drag.value)
    turning = applied(size * size * size, body.turning_drag.value)
    turning += quadratic.max() * reach * reach * reach
    own = np.concatenate([linear, linear.max() * reach * reach])
    carrier.linear = (np.array(carrier.linear) + own).tolist()
    own = np.concatenate([quadratic, turning])
    carrier.quadratic = (np.array(carrier.quadratic) + own).tolist()


def _add_rows(link: LinkData, name: str, prefix: str, mechanism: Mechanism) -> None:
    joint = link.joint
    if joint.effort:
        mechanism.motors.append(Motor(link=name, effort=joint.effort.scalar))
    if joint.friction:
        resting, sliding = joint.friction.value
        mechanism.frictions.append(Friction(link=name, resting=resting, sliding=sliding))
    if joint.range:
        low, high = joint.range.value
        mechanism.limits.append(Limits(link=name, low=low, high=high))
    if joint.follows:
        other, ratio = joint.follows
        mechanism.couplings.append(Coupling(link=name, other=f"{prefix}{other}", ratio=ratio))


def _shape(shape: Touchable, name: str, carrier: Frame) -> Shape:
    frame = carrier.inner(shape.place)
    return Shape(
        name=name,
        kind=shape.kind,
        link=frame.link,
        place=_point(frame.point),
        turn=frame.turn.tolist(),
        size=_point(np.array((*shape.size.value, 0.0)[:3])),
        friction=shape.friction.scalar,
    )


def _pairs(mechanism: Mechanism, mountings: Sequence[Mounting]) -> Iterator[tuple[str, str]]:
    """Yield the pairs that may touch and whose contact is known."""
    shapes = {shape.name: shape for shape in mechanism.shapes}
    hull = [shape.name for shape in mechanism.shapes if shape.name.startswith(_HULL)]
    ground = [BOTTOM] if BOTTOM in shapes else []
    outer = [[f"{each.prefix}{name}" for name in each.linkage.outer] for each in mountings]
    wanted = list(product(hull, ground))
    for i, (mounting, own) in enumerate(zip(mountings, outer, strict=True)):
        wanted += [
            (f"{mounting.prefix}{a}", f"{mounting.prefix}{b}") for a, b in mounting.linkage.touches
        ]
        near = mounting.linkage.hull if mounting.on_vehicle else mounting.linkage.outer
        wanted += product((f"{mounting.prefix}{name}" for name in near), hull)
        wanted += product(own, ground)
        wanted += [pair for other in outer[i + 1 :] for pair in product(own, other)]
    for a, b in wanted:
        kinds = frozenset({shapes[a].kind, shapes[b].kind})
        moving = shapes[a].link is not None or shapes[b].link is not None
        if moving and ("ground" in kinds or kinds in TOUCHING):
            yield a, b


def _rotation(place: Place) -> Array:
    """Return the matrix that turns vectors into the outer axes, (3, 3)."""
    (sr, cr), (sp, cp), (sy, cy) = map(sincos, place.turn.value)
    about_y_x = np.array([[cp, sp * sr, sp * cr], [0.0, cr, -sr], [-sp, cp * sr, cp * cr]])
    return multiplied([[cy, -sy, 0.0], [sy, cy, 0.0], [0.0, 0.0, 1.0]], about_y_x)


def _point(values: Array | Sequence[float]) -> Point:
    x, y, z = map(float, values)
    return x, y, z
