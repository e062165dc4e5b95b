"""A vehicle's file from a URDF: the rigid part of its tree of links, and estimates for the rest.

Read are masses, inertias, boxes, cylinders, spheres and colours of the base link and of all links
that are fixed to it. URDF knows no water and no thrusters, so everything about these is an estimate
to replace, and says so.
"""

import math
import re
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from seamark.sim.numerics.arrays import Array
from seamark.sim.registry import VEHICLES
from seamark.sim.vehicles.fields import NAME_MAX
from seamark.sim.vehicles.model import STANDARD_GRAVITY
from seamark.sim.vehicles.plausibility import FLAT_PLATE, WATER
from seamark.sim.vehicles.reading import HULL_MAX, SOLIDS_MAX
from seamark.sim.vehicles.xml_reading import Element, XmlRefused, read_xml

LINKS_MAX = 500
LARGEST = 1e6  # of any number
TOP_SPEED = 1.0  # [m/s] E: by which the placeholders of thrusters are sized
_TURNED = np.diag([1.0, -1.0, -1.0])  # from x forward, y left, z up to y starboard, z down
_GREY = "#9fb0ba"
_LIKE_AXES = 1e-6
_PLACEHOLDER = 'tag = "E", reason = "placeholder: URDF has no {}"'


class Imported(NamedTuple):
    """The text of a vehicle's file, and what of the URDF it does not have, in sentences."""

    text: str
    left_out: Sequence[str]


class UrdfRefused(Exception):
    """The URDF has no rigid body that could be a vehicle. The text is for the user."""


class _Frame(NamedTuple):
    """Where a frame is in the base link's: p = rotation q + origin."""

    rotation: Array
    origin: Array

    def then(self, inner: "_Frame") -> "_Frame":
        return _Frame(self.rotation @ inner.rotation, self.rotation @ inner.origin + self.origin)


class _Body(NamedTuple):
    """Mass, centre of gravity, and inertia about the centre of gravity in the base link's axes."""

    mass: float
    centre: Array
    inertia: Array


class _Piece(NamedTuple):
    """A primitive: `size` along the axes of its frame."""

    name: str
    shape: str  # box, cylinder along z, sphere
    size: Array
    frame: _Frame
    colour: str

    def extent(self) -> Array:
        """Return the lengths of the box around it along the body's axes."""
        if self.shape == "sphere":
            return self.size
        return np.asarray(np.abs(self.frame.rotation) @ self.size)


def import_urdf(content: bytes, *, z_down: bool = False) -> Imported:
    """Return the file of a vehicle from that of its URDF.

    Parameters
    ----------
    z_down
        Whether its frames have y to starboard and z down, as those of the URDF that Seamark writes.
        If not, y is to port and z up, as ROS has it.

    Raises
    ------
    UrdfRefused
        It is no URDF, or nothing in it can be a hull.
    """
    try:
        robot = read_xml(content)
    except XmlRefused as reason:
        raise UrdfRefused(str(reason)) from None
    if robot.name != "robot":
        raise UrdfRefused(f"The file has no <robot> but <{robot.name[:NAME_MAX]}>: it is no URDF.")
    tree = _Tree(robot)
    turned = np.eye(3) if z_down else _TURNED
    links = list(tree.rigid(_Frame(turned, np.zeros(3))))
    bodies = [body for link, frame in links for body in tree.bodies(link, frame)]
    if not bodies:
        raise UrdfRefused(
            "Neither the base link nor a link that is fixed to it has an <inertial> with a mass."
        )
    whole = _joined(bodies)
    if np.diag(whole.inertia).min() <= 0.0:
        raise UrdfRefused("No <inertia> is given: the vehicle would turn without any resistance.")
    hull = [one for link, frame in links for one in tree.pieces(link, frame, "collision")]
    looks = [one for link, frame in links for one in tree.pieces(link, frame, "visual")]
    if not hull and not looks:
        raise UrdfRefused(
            "The base link has no box, cylinder or sphere, and meshes are not read: add a "
            "<collision> with a <box> around the hull."
        )
    if not hull:
        tree.left_out.append("No collision primitives: those that are visual are the hull.")
    off = [abs(whole.inertia[a, b]) for a, b in ((0, 1), (0, 2), (1, 2))]
    if max(off) > 1e-9:
        tree.left_out.append(
            f"Products of inertia up to {max(off):.3g} kg m²: a vehicle has moments about its own "
            "axes alone."
        )
    name = _name(robot.attributes.get("name", ""))
    text = _written(name, whole, (hull or looks)[:HULL_MAX], looks[:SOLIDS_MAX])
    return Imported(text, tree.left_out)


class _Tree:
    """The links and joints of a robot."""

    def __init__(self, robot: Element) -> None:
        self.left_out: list[str] = []
        links = list(robot.all("link"))
        if len(links) > LINKS_MAX:
            raise UrdfRefused(f"There are {len(links)} links; at most {LINKS_MAX} are read.")
        self._links = {_attribute(link, "name"): link for link in links}
        if len(self._links) < len(links):
            raise UrdfRefused("Two links have the same name.")
        self._colours = dict(_colours(robot))
        self._joints: dict[str, list[Element]] = {}
        children = self._connect(robot)
        roots = [name for name in self._links if name not in children]
        if len(roots) != 1:
            raise UrdfRefused(
                f"There must be one base link, which is no joint's child, not {len(roots)}: the "
                "joints must make a tree."
            )
        self._root = roots[0]
        apart = len(self._links) - self._behind(self._root)
        if apart:
            raise UrdfRefused(f"{apart} links are not joined to the base link but in a circle.")
        for kind in sorted({one.name for one in robot.children} - {"link", "joint", "material"}):
            self.left_out.append(f"<{kind[:NAME_MAX]}> elements.")

    def _connect(self, robot: Element) -> set[str]:
        """Take the joints; return the links that are children."""
        children: set[str] = set()
        for joint in robot.all("joint"):
            parent, child = (_target(joint, end) for end in ("parent", "child"))
            for link in (parent, child):
                if link not in self._links:
                    raise UrdfRefused(f"A joint names the link {link[:NAME_MAX]!r}, which is none.")
            if child in children:
                raise UrdfRefused(f"The link {child[:NAME_MAX]!r} is the child of two joints.")
            children.add(child)
            self._joints.setdefault(parent, []).append(joint)
        return children

    def rigid(self, base: _Frame) -> Iterator[tuple[str, _Frame]]:
        """Yield the base link and all that are fixed to it, with their frames."""
        waiting = [(self._root, base)]
        while waiting:
            link, frame = waiting.pop()
            yield link, frame
            for joint in self._joints.get(link, []):
                kind, child = joint.attributes.get("type", ""), _target(joint, "child")
                if kind == "fixed":
                    waiting.append((child, frame.then(_origin(joint))))
                else:
                    below = self._behind(child)
                    at = ", ".join(f"{v:.4g}" for v in frame.then(_origin(joint)).origin)
                    self.left_out.append(
                        f"Joint {joint.attributes.get('name', '')[:NAME_MAX]!r} "
                        f"({kind[:NAME_MAX]}) at {at} m, with {below} "
                        f"link{'' if below == 1 else 's'} behind it."
                    )

    def _behind(self, link: str) -> int:
        """Return the number of links from this one on."""
        waiting, seen = [link], 0
        while waiting:
            seen += 1
            waiting += [_target(one, "child") for one in self._joints.get(waiting.pop(), [])]
        return seen

    def bodies(self, link: str, frame: _Frame) -> Iterator[_Body]:
        """Yield the body of a link, if it has a mass."""
        inertial = self._links[link].first("inertial")
        mass = inertial and inertial.first("mass")
        if inertial is None or mass is None:
            return
        kilograms = _number(_attribute(mass, "value"))
        if kilograms == 0.0:
            return
        if kilograms < 0.0:
            raise UrdfRefused(f"The mass of link {link[:NAME_MAX]!r} is negative.")
        tensor, given = np.zeros((3, 3)), inertial.first("inertia")
        for a, b, key in ((0, 0, "ixx"), (1, 1, "iyy"), (2, 2, "izz"), (0, 1, "ixy"),
                          (0, 2, "ixz"), (1, 2, "iyz")):  # fmt: skip
            value = 0.0 if given is None else _number(given.attributes.get(key, "0"))
            tensor[a, b] = tensor[b, a] = value
        place = frame.then(_origin(inertial))
        yield _Body(kilograms, place.origin, place.rotation @ tensor @ place.rotation.T)

    def pieces(self, link: str, frame: _Frame, kind: str) -> Iterator[_Piece]:
        """Yield the primitives of a link."""
        for at, part in enumerate(self._links[link].all(kind), start=1):
            name = part.attributes.get("name") or f"{link} {at}"
            geometry = part.first("geometry")
            shape = geometry.children[0] if geometry and geometry.children else None
            size = None if shape is None else _size(shape)
            if shape is None or size is None:
                what = "nothing" if shape is None else f"a {shape.name[:NAME_MAX]}"
                self.left_out.append(f"{kind.capitalize()} {name[:NAME_MAX]!r}: {what}.")
                continue
            if size.min() <= 0.0:
                raise UrdfRefused(f"{kind.capitalize()} {name[:NAME_MAX]!r} has no size.")
            place = frame.then(_origin(part))
            yield _Piece(name, shape.name, size, place, self._colour(part))

    def _colour(self, part: Element) -> str:
        material = part.first("material")
        if material is None:
            return _GREY
        own = dict(_colours(part))
        name = material.attributes.get("name", "")
        return own.get(name, self._colours.get(name, _GREY))


def _colours(element: Element) -> Iterator[tuple[str, str]]:
    """Yield name and CSS colour of the materials below an element."""
    for material in element.all("material"):
        colour = material.first("color")
        if colour is not None:
            rgba = _numbers(_attribute(colour, "rgba"), 4)
            levels = (round(255.0 * min(max(value, 0.0), 1.0)) for value in rgba[:3])
            yield material.attributes.get("name", ""), "#" + "".join(f"{v:02x}" for v in levels)


def _size(shape: Element) -> Array | None:
    """Return the lengths of a primitive along its axes; None for other shapes."""
    if shape.name == "box":
        return np.array(_numbers(_attribute(shape, "size"), 3))
    if shape.name in ("cylinder", "sphere"):
        across = 2.0 * _number(_attribute(shape, "radius"))
        along = across if shape.name == "sphere" else _number(_attribute(shape, "length"))
        return np.array([across, across, along])
    return None


def _origin(element: Element) -> _Frame:
    """Return the frame that <origin> describes: roll, then pitch, then yaw about fixed axes."""
    origin = element.first("origin")
    given = {} if origin is None else origin.attributes
    x, y, z = _numbers(given.get("xyz", "0 0 0"), 3)
    roll, pitch, yaw = _numbers(given.get("rpy", "0 0 0"), 3)
    (cr, sr), (cp, sp), (cy, sy) = ((math.cos(a), math.sin(a)) for a in (roll, pitch, yaw))
    rotation = np.array([[cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
                         [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
                         [-sp, cp * sr, cp * cr]])  # fmt: skip
    return _Frame(rotation, np.array([x, y, z]))


def _attribute(element: Element, name: str) -> str:
    if name not in element.attributes:
        raise UrdfRefused(f"<{element.name[:NAME_MAX]}> has no attribute {name}.")
    return element.attributes[name]


def _target(joint: Element, end: str) -> str:
    element = joint.first(end)
    if element is None:
        raise UrdfRefused(f"A joint has no <{end}>.")
    return _attribute(element, "link")


def _number(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        raise UrdfRefused(f"{text[:NAME_MAX]!r} is not a number.") from None
    if not -LARGEST <= value <= LARGEST:
        raise UrdfRefused(f"{text[:NAME_MAX]!r} is not a finite number of at most {LARGEST:g}.")
    return value


def _numbers(text: str, count: int) -> list[float]:
    parts = text.split()
    if len(parts) != count:
        raise UrdfRefused(f"{text[:NAME_MAX]!r} must be {count} numbers.")
    return [_number(part) for part in parts]


def _joined(bodies: Sequence[_Body]) -> _Body:
    """Return several bodies as one."""
    mass = sum(body.mass for body in bodies)
    centre = np.asarray(sum(body.mass * body.centre for body in bodies) / mass)
    inertia = np.zeros((3, 3))
    for body in bodies:
        d = body.centre - centre
        inertia += body.inertia + body.mass * (d @ d * np.eye(3) - np.outer(d, d))
    return _Body(mass, centre, inertia)


def _name(given: str) -> str:
    name = re.sub(r"[^a-z0-9]+", "-", given.lower()).strip("-")[:NAME_MAX].strip("-") or "vehicle"
    return f"my-{name}"[:NAME_MAX] if name in {*VEHICLES, "vehicle"} else name


# The file ---------------------------------------------------------------------------------------


def _written(name: str, whole: _Body, hull: Sequence[_Piece], looks: Sequence[_Piece]) -> str:
    low = np.min([one.frame.origin - 0.5 * one.extent() for one in hull], axis=0)
    high = np.max([one.frame.origin + 0.5 * one.extent() for one in hull], axis=0)
    size, middle = high - low, 0.5 * (low + high)
    parts = [
        _HEAD.format(name=name),
        _body(whole, size, middle),
        _thrust(size, middle),
        *(_hull_box(one, at) for at, one in enumerate(hull, start=1)),
    ]
    if looks:
        parts += ["[drawing]\nsolids = [", *(f"  {_solid(one)}," for one in looks), "]\n"]
    return "\n".join(parts)


_HEAD = """\
# Made by `seamark vehicle import`. What is tagged E is a placeholder: replace it, with a source.
format = 1
name = "{name}"
title = "{name}"
summary = "Imported from a URDF; its water and its thrusters are placeholders."

[sources]
urdf = "the URDF of {name}"
"""


def _body(whole: _Body, size: Array, middle: Array) -> str:
    weight = whole.mass * STANDARD_GRAVITY
    sourced = 'tag = "S", source = "urdf"'
    areas = np.array([size[1] * size[2], size[0] * size[2], size[0] * size[1]])
    drag = 0.5 * WATER * FLAT_PLATE * areas
    # Half the force of a plate at the tip of a lever of half the length.
    turning = 0.5 * drag[[1, 0, 1]] * (0.5 * size[[2, 2, 0]]) ** 3
    inertia = np.diag(whole.inertia)
    above = whole.centre - np.array([0.0, 0.0, 0.1 * size[2]])
    what = _PLACEHOLDER.format
    none, own = [0.0] * 3, "water: as much as of the vehicle"
    plate = "water: a plate as large as the hull"
    groups = (
        ("added_mass", "kg", [whole.mass] * 3, "kg m²", inertia, own),
        ("drag_linear", "N s/m", none, "N m s", none, "water"),
        ("drag_quadratic", "N s²/m²", drag, "N m s²", turning, plate),
    )
    lines = [
        "[body]",
        f'mass = {{ value = {whole.mass!r}, unit = "kg", {sourced} }}',
        f'inertia = {{ value = {_list(inertia)}, unit = "kg m²", {sourced} }}',
        f'weight = {{ value = {weight!r}, unit = "N", tag = "D", source = "urdf" }}',
        f'buoyancy = {{ value = {weight!r}, unit = "N", {what("water: neutral")} }}',
        f'centre_of_gravity = {{ value = {_list(whole.centre)}, unit = "m", {sourced} }}',
        f'centre_of_buoyancy = {{ value = {_list(above)}, unit = "m", '
        f"{what('water: a tenth of the height above the centre of gravity')} }}",
    ]
    for key, unit, along, turn_unit, turn, reason in groups:
        lines += [
            f"{key} = [",
            f'  {{ axes = ["x", "y", "z"], value = {_list(along)}, unit = "{unit}", '
            f"{what(reason)} }},",
            f'  {{ axes = ["roll", "pitch", "yaw"], value = {_list(turn)}, '
            f'unit = "{turn_unit}", {what(reason)} }},',
            "]",
        ]
    return "\n".join([*lines, ""])


def _thrust(size: Array, middle: Array) -> str:
    areas = np.array([size[1] * size[2], size[0] * size[2], size[0] * size[1]])
    most = float(f"{0.5 * 0.5 * WATER * FLAT_PLATE * areas.max() * TOP_SPEED**2:.3g}")
    what = _PLACEHOLDER.format("thrusters")
    x, y, z = middle
    side, end = 0.5 * size[1], 0.5 * size[0]
    thrusters = (
        ("surge port", (x, y - side, z), (1, 0, 0)),
        ("surge starboard", (x, y + side, z), (1, 0, 0)),
        ("sway bow", (x + end, y, z), (0, 1, 0)),
        ("sway stern", (x - end, y, z), (0, 1, 0)),
        ("heave bow", (x + end, y, z), (0, 0, 1)),
        ("heave stern", (x - end, y, z), (0, 0, 1)),
    )
    lines = [
        "[thrust]",
        'kind = "quadratic"',
        f'forward = {{ value = {most!r}, unit = "N", {what} }}',
        f'reverse = {{ value = {most!r}, unit = "N", {what} }}',
        f'dead_band = {{ value = 0.0, unit = "1", {what} }}',
        f'limits = {{ value = [{most!r}, {most!r}], unit = "N", {what} }}',
        f'lag = {{ value = 0.1, unit = "s", {what} }}',
        "",
    ]
    for name, place, direction in thrusters:
        lines += [
            "[[thrusters]]",
            f'name = "{name}"',
            f'position = {{ value = {_list(place)}, unit = "m", {what} }}',
            f"direction = {list(direction)}",
            "",
        ]
    return "\n".join(lines)


def _hull_box(piece: _Piece, at: int) -> str:
    sourced = 'unit = "m", tag = "S", source = "urdf"'
    return "\n".join(
        [
            "[[hull]]",
            f'name = "{_text(piece.name)} {at}"',
            f"centre = {{ value = {_list(piece.frame.origin)}, {sourced} }}",
            f"size = {{ value = {_list(piece.extent())}, {sourced} }}",
            "",
        ]
    )


def _solid(piece: _Piece) -> str:
    """Return a solid: a cylinder along x stays one, in other directions it becomes a box."""
    along = np.abs(piece.frame.rotation[:, 2])
    is_cylinder = piece.shape == "cylinder" and along[0] > 1.0 - _LIKE_AXES
    shape = "cylinder" if is_cylinder else "sphere" if piece.shape == "sphere" else "box"
    return (
        f'{{ shape = "{shape}", size = {_list(piece.extent())}, '
        f'centre = {_list(piece.frame.origin)}, colour = "{piece.colour}" }}'
    )


def _text(given: str) -> str:
    """Return a text that may stand between quotes in TOML."""
    return re.sub(r"[^A-Za-z0-9 ._/-]", "_", given)[:NAME_MAX]


def _list(values: Sequence[float] | Array) -> str:
    return "[" + ", ".join(repr(round(float(value), 12) + 0.0) for value in values) + "]"
