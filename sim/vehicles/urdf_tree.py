"""The links, joints and primitives of a URDF, checked."""

import math
import re
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from seamark.sim.numerics.arrays import Array
from seamark.sim.vehicles.fields import NAME_MAX
from seamark.sim.vehicles.xml_reading import Element

LINKS_MAX = 500
LARGEST = 1e6  # of any number
TURNED = np.diag([1.0, -1.0, -1.0])  # from x forward, y left, z up to y starboard, z down
_GREY = "#9fb0ba"


class UrdfRefused(Exception):
    """The URDF has nothing that could be a vehicle or an arm. The text is for the user."""


class Imported(NamedTuple):
    """The text of a file in TOML, and what of the URDF it does not have, in sentences."""

    text: str
    left_out: Sequence[str]


class Frame(NamedTuple):
    """Where a frame is in the base link's: p = rotation q + origin."""

    rotation: Array
    origin: Array

    def then(self, inner: "Frame") -> "Frame":
        """Return a frame that is given in this one, in the base link's."""
        return Frame(self.rotation @ inner.rotation, self.rotation @ inner.origin + self.origin)


class Body(NamedTuple):
    """Mass, centre of gravity, and inertia about the centre of gravity in the base link's axes."""

    mass: float
    centre: Array
    inertia: Array


class Piece(NamedTuple):
    """A primitive: `size` along the axes of its frame."""

    name: str
    shape: str  # box, cylinder along z, sphere
    size: Array
    frame: Frame
    colour: str

    def extent(self) -> Array:
        """Return the lengths of the box around it along the body's axes."""
        if self.shape == "sphere":
            return self.size
        return np.asarray(np.abs(self.frame.rotation) @ self.size)


class Tree:
    """The links and joints of a robot."""

    def __init__(self, robot: Element) -> None:
        self.left_out: list[str] = []
        links = list(robot.all("link"))
        if len(links) > LINKS_MAX:
            raise UrdfRefused(f"There are {len(links)} links; at most {LINKS_MAX} are read.")
        self._links = {attribute(link, "name"): link for link in links}
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
        self.root = roots[0]
        apart = len(self._links) - self._behind(self.root)
        if apart:
            raise UrdfRefused(f"{apart} links are not joined to the base link but in a circle.")
        for kind in sorted({one.name for one in robot.children} - {"link", "joint", "material"}):
            self.left_out.append(f"<{kind[:NAME_MAX]}> elements.")

    def _connect(self, robot: Element) -> set[str]:
        """Take the joints; return the links that are children."""
        children: set[str] = set()
        for joint in robot.all("joint"):
            parent, child = (target(joint, end) for end in ("parent", "child"))
            for link in (parent, child):
                if link not in self._links:
                    raise UrdfRefused(f"A joint names the link {link[:NAME_MAX]!r}, which is none.")
            if child in children:
                raise UrdfRefused(f"The link {child[:NAME_MAX]!r} is the child of two joints.")
            children.add(child)
            self._joints.setdefault(parent, []).append(joint)
        return children

    def rigid(self, base: Frame) -> Iterator[tuple[str, Frame]]:
        """Yield the base link and all that are fixed to it, with their frames."""
        waiting = [(self.root, base)]
        while waiting:
            link, frame = waiting.pop()
            yield link, frame
            for joint in self._joints.get(link, []):
                kind, child = joint.attributes.get("type", ""), target(joint, "child")
                if kind == "fixed":
                    waiting.append((child, frame.then(origin_of(joint))))
                else:
                    below = self._behind(child)
                    at = ", ".join(f"{v:.4g}" for v in frame.then(origin_of(joint)).origin)
                    self.left_out.append(
                        f"Joint {joint.attributes.get('name', '')[:NAME_MAX]!r} "
                        f"({kind[:NAME_MAX]}) at {at} m, with {below} "
                        f"link{'' if below == 1 else 's'} behind it."
                    )

    def joints(self) -> Iterator[tuple[str, str, Element]]:
        """Yield parent link, child link and joint of each, from the base link on."""
        waiting = [self.root]
        while waiting:
            parent = waiting.pop(0)
            for joint in self._joints.get(parent, []):
                child = target(joint, "child")
                yield parent, child, joint
                waiting.append(child)

    def _behind(self, link: str) -> int:
        """Return the number of links from this one on."""
        waiting, seen = [link], 0
        while waiting:
            seen += 1
            waiting += [target(one, "child") for one in self._joints.get(waiting.pop(), [])]
        return seen

    def bodies(self, link: str, frame: Frame) -> Iterator[Body]:
        """Yield the body of a link, if it has a mass."""
        inertial = self._links[link].first("inertial")
        mass = inertial and inertial.first("mass")
        if inertial is None or mass is None:
            return
        kilograms = number(attribute(mass, "value"))
        if kilograms == 0.0:
            return
        if kilograms < 0.0:
            raise UrdfRefused(f"The mass of link {link[:NAME_MAX]!r} is negative.")
        tensor, given = np.zeros((3, 3)), inertial.first("inertia")
        for a, b, key in ((0, 0, "ixx"), (1, 1, "iyy"), (2, 2, "izz"), (0, 1, "ixy"),
                          (0, 2, "ixz"), (1, 2, "iyz")):  # fmt: skip
            value = 0.0 if given is None else number(given.attributes.get(key, "0"))
            tensor[a, b] = tensor[b, a] = value
        place = frame.then(origin_of(inertial))
        yield Body(kilograms, place.origin, place.rotation @ tensor @ place.rotation.T)

    def pieces(self, link: str, frame: Frame, kind: str) -> Iterator[Piece]:
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
            place = frame.then(origin_of(part))
            yield Piece(name, shape.name, size, place, self._colour(part))

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
            rgba = numbers(attribute(colour, "rgba"), 4)
            levels = (round(255.0 * min(max(value, 0.0), 1.0)) for value in rgba[:3])
            yield material.attributes.get("name", ""), "#" + "".join(f"{v:02x}" for v in levels)


def _size(shape: Element) -> Array | None:
    """Return the lengths of a primitive along its axes; None for other shapes."""
    if shape.name == "box":
        return np.array(numbers(attribute(shape, "size"), 3))
    if shape.name in ("cylinder", "sphere"):
        across = 2.0 * number(attribute(shape, "radius"))
        along = across if shape.name == "sphere" else number(attribute(shape, "length"))
        return np.array([across, across, along])
    return None


def origin_of(element: Element) -> Frame:
    """Return the frame that <origin> describes: roll, then pitch, then yaw about fixed axes."""
    origin = element.first("origin")
    given = {} if origin is None else origin.attributes
    x, y, z = numbers(given.get("xyz", "0 0 0"), 3)
    roll, pitch, yaw = numbers(given.get("rpy", "0 0 0"), 3)
    (cr, sr), (cp, sp), (cy, sy) = ((math.cos(a), math.sin(a)) for a in (roll, pitch, yaw))
    rotation = np.array([[cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
                         [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
                         [-sp, cp * sr, cp * cr]])  # fmt: skip
    return Frame(rotation, np.array([x, y, z]))


def attribute(element: Element, name: str) -> str:
    """Return an attribute that must be there."""
    if name not in element.attributes:
        raise UrdfRefused(f"<{element.name[:NAME_MAX]}> has no attribute {name}.")
    return element.attributes[name]


def target(joint: Element, end: str) -> str:
    """Return the link at an end of a joint: its parent or child."""
    element = joint.first(end)
    if element is None:
        raise UrdfRefused(f"A joint has no <{end}>.")
    return attribute(element, "link")


def number(text: str) -> float:
    """Return a number of at most `LARGEST` in size."""
    try:
        value = float(text)
    except ValueError:
        raise UrdfRefused(f"{text[:NAME_MAX]!r} is not a number.") from None
    if not -LARGEST <= value <= LARGEST:
        raise UrdfRefused(f"{text[:NAME_MAX]!r} is not a finite number of at most {LARGEST:g}.")
    return value


def numbers(text: str, count: int) -> list[float]:
    """Return so many numbers."""
    parts = text.split()
    if len(parts) != count:
        raise UrdfRefused(f"{text[:NAME_MAX]!r} must be {count} numbers.")
    return [number(part) for part in parts]


def toml_text(given: str) -> str:
    """Return a text that may stand between quotes in TOML."""
    return re.sub(r"[^A-Za-z0-9 ._/-]", "_", given)[:NAME_MAX]


def toml_list(values: Sequence[float] | Array) -> str:
    """Return numbers as TOML has them."""
    return "[" + ", ".join(repr(round(float(value), 12) + 0.0) for value in values) + "]"
