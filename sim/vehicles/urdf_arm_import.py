"""An arm's file from a URDF: its tree of links, and estimates for the water.

Read are joints with their limits, efforts, speeds and friction, masses, inertias, boxes, cylinders,
spheres and colours. URDF knows no water, so volumes, added mass and drag are estimates to replace,
and say so.
"""

import math
import re
from collections.abc import Iterator

import numpy as np

from seamark.sim.numerics.arrays import Array
from seamark.sim.registry import ARMS
from seamark.sim.vehicles.fields import NAME_MAX
from seamark.sim.vehicles.linkage_reading import LINKS_MAX, OUTER_MAX, SHAPES_MAX, SOLIDS_MAX
from seamark.sim.vehicles.plausibility import FLAT_PLATE, WATER
from seamark.sim.vehicles.urdf_tree import (
    TURNED,
    Body,
    Frame,
    Imported,
    Piece,
    Tree,
    UrdfRefused,
    attribute,
    number,
    numbers,
    origin_of,
    toml_list,
    toml_text,
)
from seamark.sim.vehicles.xml_reading import Element, XmlRefused, read_xml

_KINDS = {
    "fixed": "fixed",
    "revolute": "revolute",
    "continuous": "revolute",
    "prismatic": "prismatic",
}
_DISPLACED = 0.5  # E: of a link's mass, as water
_LEAST_M = 1e-6
_X_TO_Z = np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])
_SOURCED = 'tag = "S", source = "urdf"'
_PLACEHOLDER = 'tag = "E", reason = "placeholder: URDF has no water"'


def import_arm(content: bytes, *, z_down: bool = False) -> Imported:
    """Return the file of an arm from that of its URDF; see `urdf_import.import_urdf`.

    Raises
    ------
    UrdfRefused
        It is no URDF, or no joint in it moves.
    """
    try:
        robot = read_xml(content)
    except XmlRefused as reason:
        raise UrdfRefused(str(reason)) from None
    if robot.name != "robot":
        raise UrdfRefused(f"The file has no <robot> but <{robot.name[:NAME_MAX]}>: it is no URDF.")
    return _Writer(Tree(robot), np.eye(3) if z_down else TURNED).written(robot)


class _Writer:
    """Writes the links of a tree, their frames turned by `turn`."""

    def __init__(self, tree: Tree, turn: Array) -> None:
        self._tree, self._turn = tree, turn
        self._joints = list(tree.joints())
        self._child_of = {attribute(joint, "name"): child for _parent, child, joint in self._joints}
        self._parents = {parent for parent, _child, _joint in self._joints}
        self._names: dict[str, str] = {}
        self._outer: list[str] = []

    def written(self, robot: Element) -> Imported:
        moving = [joint for *_, joint in self._joints if _kind(joint) != "fixed"]
        if not moving:
            raise UrdfRefused("No joint turns or slides: it is no arm.")
        if len(self._joints) + 1 > LINKS_MAX:
            raise UrdfRefused(
                f"There are {len(self._joints) + 1} links; an arm has at most {LINKS_MAX}."
            )
        links = [self._link(self._tree.root, None, None)]
        links += [self._link(child, parent, joint) for parent, child, joint in self._joints]
        given = re.sub(r"[^a-z0-9]+", "-", robot.attributes.get("name", "").lower()).strip("-")
        name = given[: NAME_MAX - 3].strip("-") or "arm"
        head = _HEAD.format(
            name=f"my-{name}" if name in {*ARMS, "arm"} else name,
            outer=", ".join(f'"{one}"' for one in self._outer[:OUTER_MAX]),
        )
        if self._outer:
            self._tree.left_out.append(
                "Which shapes may touch each other: write pairs of the gripper's to touches."
            )
        return Imported("\n".join([head, *links]), self._tree.left_out)

    def _link(self, link: str, parent: str | None, joint: Element | None) -> str:
        name = self._name(link)
        lines = ["[[links]]", f'name = "{name}"']
        if parent is not None:
            lines.append(f'parent = "{self._name(parent)}"')
        lines += ["[links.joint]", *self._joint(joint)]
        still = Frame(self._turn, np.zeros(3))
        bodies = list(self._tree.bodies(link, still))
        shapes = list(self._tree.pieces(link, still, "collision"))
        if bodies:
            lines += ["[links.body]", *_body(bodies[0], _extent(shapes, bodies[0].mass))]
        elif joint is not None and _kind(joint) != "fixed":
            raise UrdfRefused(
                f"The link {link[:NAME_MAX]!r} moves but has no <inertial> with a mass: add one, "
                "or fix it to the next."
            )
        for at, piece in enumerate(shapes[:SHAPES_MAX], start=1):
            own = f"{name} {at}"
            if link not in self._parents:
                self._outer.append(own)
            lines += _shape(piece, own)
        for piece in list(self._tree.pieces(link, still, "visual"))[:SOLIDS_MAX]:
            lines += _solid(piece)
        return "\n".join([*lines, ""])

    def _name(self, link: str) -> str:
        """Return a link's name as files may have it, unlike any other's."""
        if link not in self._names:
            plain = re.sub(r"[^A-Za-z0-9]+", " ", link).strip()[: NAME_MAX - 4].strip() or "link"
            taken = {*self._names.values(), "vehicle", "bottom"}
            found = plain if plain not in taken else f"{plain} {len(taken)}"
            self._names[link] = found
        return self._names[link]

    def _joint(self, joint: Element | None) -> Iterator[str]:
        if joint is None:
            yield 'kind = "fixed"'
            return
        kind, origin = _kind(joint), origin_of(joint)
        yield f'kind = "{kind}"'
        turn = self._turn @ origin.rotation @ self._turn.T
        point = toml_list(self._turn @ origin.origin)
        yield f'place = {{ value = {point}, unit = "m", {_SOURCED} }}'
        yield f'turn = {{ value = {toml_list(_angles(turn))}, unit = "rad", {_SOURCED} }}'
        if kind == "fixed":
            return
        axis = joint.first("axis")
        along = np.array(numbers("1 0 0" if axis is None else attribute(axis, "xyz"), 3))
        length = float(np.linalg.norm(along))
        if length == 0.0:
            raise UrdfRefused("An <axis> is zero.")
        yield f"axis = {toml_list(self._turn @ along / length)}"
        yield from self._limits(joint, turning=kind == "revolute")

    def _limits(self, joint: Element, *, turning: bool) -> Iterator[str]:
        angle, effort, speed = ("rad", "N m", "rad/s") if turning else ("m", "N", "m/s")
        name = joint.attributes.get("name", "")[:NAME_MAX]
        limit, mimic = joint.first("limit"), joint.first("mimic")
        given = {} if limit is None else {key: number(v) for key, v in limit.attributes.items()}
        if given.get("lower", 0.0) < given.get("upper", 0.0):
            ends = toml_list([given.get("lower", 0.0), given.get("upper", 0.0)])
            yield f'range = {{ value = {ends}, unit = "{angle}", {_SOURCED} }}'
        if mimic is not None:
            other = self._child_of.get(attribute(mimic, "joint"))
            if other is None:
                raise UrdfRefused(f"The joint {name!r} mimics one that there is not.")
            ratio = number(mimic.attributes.get("multiplier", "1"))
            yield f'follows = {{ link = "{self._name(other)}", ratio = {ratio!r} }}'
        elif given.get("effort", 0.0) > 0.0 and given.get("velocity", 0.0) > 0.0:
            yield f'effort = {{ value = {given["effort"]!r}, unit = "{effort}", {_SOURCED} }}'
            yield f'speed = {{ value = {given["velocity"]!r}, unit = "{speed}", {_SOURCED} }}'
        else:
            self._tree.left_out.append(f"A motor of joint {name!r}: it has no effort and velocity.")
        dynamics = joint.first("dynamics")
        friction = 0.0 if dynamics is None else number(dynamics.attributes.get("friction", "0"))
        if friction > 0.0:
            both = toml_list([friction, friction])
            yield f'friction = {{ value = {both}, unit = "{effort}", {_SOURCED} }}'


def _extent(pieces: list[Piece], mass: float) -> Array:
    """Return the lengths of the box around a link's primitives; a cube of its water if none."""
    if not pieces:
        return np.full(3, (_DISPLACED * mass / WATER) ** (1.0 / 3.0))
    low = np.min([one.frame.origin - 0.5 * one.extent() for one in pieces], axis=0)
    high = np.max([one.frame.origin + 0.5 * one.extent() for one in pieces], axis=0)
    return np.asarray(high - low)


def _solid(piece: Piece) -> Iterator[str]:
    """Yield a solid: a sphere, or the box around what is turned in any way."""
    yield "[[links.solids]]"
    yield f'shape = "{"sphere" if piece.shape == "sphere" else "box"}"'
    yield f"size = {toml_list(piece.extent())}"
    yield f"centre = {toml_list(piece.frame.origin)}"
    yield f'colour = "{piece.colour}"'


def _kind(joint: Element) -> str:
    kind = joint.attributes.get("type", "")
    if kind not in _KINDS:
        raise UrdfRefused(
            f"The joint {joint.attributes.get('name', '')[:NAME_MAX]!r} is {kind[:NAME_MAX]!r}; "
            f"those of an arm are {', '.join(_KINDS)}."
        )
    return _KINDS[kind]


def _angles(rotation: Array) -> list[float]:
    """Return roll, pitch and yaw of a rotation."""
    pitch = -math.asin(min(max(float(rotation[2, 0]), -1.0), 1.0))
    if abs(rotation[2, 0]) > 1.0 - 1e-12:  # roll and yaw turn about the same axis
        return [0.0, pitch, math.atan2(-rotation[0, 1], rotation[1, 1])]
    return [
        math.atan2(rotation[2, 1], rotation[2, 2]),
        pitch,
        math.atan2(rotation[1, 0], rotation[0, 0]),
    ]


def _body(body: Body, size: Array) -> Iterator[str]:
    moved = _DISPLACED * body.mass
    areas = np.array([size[1] * size[2], size[0] * size[2], size[0] * size[1]])
    drag = 0.5 * WATER * FLAT_PLATE * areas
    turning = 0.5 * drag[[1, 0, 1]] * (0.5 * size[[2, 2, 0]]) ** 3
    tensor = body.inertia
    six = [tensor[a, b] for a, b in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
    added = moved / 12.0 * np.array([size[1] ** 2 + size[2] ** 2, size[0] ** 2 + size[2] ** 2,
                                     size[0] ** 2 + size[1] ** 2])  # fmt: skip
    for key, value, unit, tag in (
        ("mass", repr(body.mass), "kg", _SOURCED),
        ("inertia", toml_list(six), "kg m²", _SOURCED),
        ("centre_of_mass", toml_list(body.centre), "m", _SOURCED),
        ("volume", repr(moved / WATER), "m³", _PLACEHOLDER),
        ("centre_of_buoyancy", toml_list(body.centre), "m", _PLACEHOLDER),
        ("added_mass", toml_list([moved] * 3), "kg", _PLACEHOLDER),
        ("added_inertia", toml_list(added), "kg m²", _PLACEHOLDER),
        ("linear_drag", toml_list([0.0] * 3), "N s/m", _PLACEHOLDER),
        ("quadratic_drag", toml_list(drag), "N s²/m²", _PLACEHOLDER),
        ("turning_drag", toml_list(turning), "N m s²", _PLACEHOLDER),
        ("centre", toml_list(body.centre), "m", _PLACEHOLDER),
    ):
        yield f'{key} = {{ value = {value}, unit = "{unit}", {tag} }}'


def _shape(piece: Piece, name: str) -> Iterator[str]:
    """Yield a shape: a box, or the capsule inside a cylinder, which lies along x here."""
    size, rotation = 0.5 * piece.size, piece.frame.rotation
    kind, sizes = "box", size.tolist()
    radius, half = float(size[0]), float(size[2])
    if piece.shape == "sphere" or (piece.shape == "cylinder" and half > radius):
        kind, sizes = "capsule", [radius, max(half - radius, _LEAST_M)]
        if piece.shape == "cylinder":
            rotation = rotation @ _X_TO_Z
    yield from (
        "[[links.shapes]]",
        f'name = "{toml_text(name)}"',
        f'kind = "{kind}"',
        f'place = {{ value = {toml_list(piece.frame.origin)}, unit = "m", {_SOURCED} }}',
        f'turn = {{ value = {toml_list(_angles(rotation))}, unit = "rad", {_SOURCED} }}',
        f'size = {{ value = {toml_list(sizes)}, unit = "m", {_SOURCED} }}',
    )


_HEAD = """\
# Made by `seamark vehicle import --arm`. Replace what is tagged E, a placeholder, with a source.
format = 1
kind = "arm"
name = "{name}"
title = "{name}"
summary = "Imported from a URDF; its water is a placeholder."
outer = [{outer}]

[sources]
urdf = "the URDF of {name}"
"""
