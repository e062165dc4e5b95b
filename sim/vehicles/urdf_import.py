"""A vehicle's file from a URDF: the rigid part of its tree of links, and estimates for the rest.

Read are masses, inertias, boxes, cylinders, spheres and colours of the base link and of all links
that are fixed to it. URDF knows no water and no thrusters, so everything about these is an estimate
to replace, and says so.
"""

import re
from collections.abc import Sequence

import numpy as np

from seamark.sim.numerics.arrays import Array
from seamark.sim.registry import VEHICLES
from seamark.sim.vehicles.fields import NAME_MAX
from seamark.sim.vehicles.model import STANDARD_GRAVITY
from seamark.sim.vehicles.plausibility import FLAT_PLATE, WATER
from seamark.sim.vehicles.reading import HULL_MAX, SOLIDS_MAX
from seamark.sim.vehicles.urdf_tree import (
    TURNED,
    Body,
    Frame,
    Imported,
    Piece,
    Tree,
    UrdfRefused,
    toml_list,
    toml_text,
)
from seamark.sim.vehicles.xml_reading import XmlRefused, read_xml

TOP_SPEED = 1.0  # [m/s] E: by which the placeholders of thrusters are sized
_LIKE_AXES = 1e-6
_PLACEHOLDER = 'tag = "E", reason = "placeholder: URDF has no {}"'


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
    tree = Tree(robot)
    turned = np.eye(3) if z_down else TURNED
    links = list(tree.rigid(Frame(turned, np.zeros(3))))
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


def _joined(bodies: Sequence[Body]) -> Body:
    """Return several bodies as one."""
    mass = sum(body.mass for body in bodies)
    centre = np.asarray(sum(body.mass * body.centre for body in bodies) / mass)
    inertia = np.zeros((3, 3))
    for body in bodies:
        d = body.centre - centre
        inertia += body.inertia + body.mass * (d @ d * np.eye(3) - np.outer(d, d))
    return Body(mass, centre, inertia)


def _name(given: str) -> str:
    name = re.sub(r"[^a-z0-9]+", "-", given.lower()).strip("-")[:NAME_MAX].strip("-") or "vehicle"
    return f"my-{name}"[:NAME_MAX] if name in {*VEHICLES, "vehicle"} else name


# The file ---------------------------------------------------------------------------------------


def _written(name: str, whole: Body, hull: Sequence[Piece], looks: Sequence[Piece]) -> str:
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


def _body(whole: Body, size: Array, middle: Array) -> str:
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
        f'inertia = {{ value = {toml_list(inertia)}, unit = "kg m²", {sourced} }}',
        f'weight = {{ value = {weight!r}, unit = "N", tag = "D", source = "urdf" }}',
        f'buoyancy = {{ value = {weight!r}, unit = "N", {what("water: neutral")} }}',
        f'centre_of_gravity = {{ value = {toml_list(whole.centre)}, unit = "m", {sourced} }}',
        f'centre_of_buoyancy = {{ value = {toml_list(above)}, unit = "m", '
        f"{what('water: a tenth of the height above the centre of gravity')} }}",
    ]
    for key, unit, along, turn_unit, turn, reason in groups:
        lines += [
            f"{key} = [",
            f'  {{ axes = ["x", "y", "z"], value = {toml_list(along)}, unit = "{unit}", '
            f"{what(reason)} }},",
            f'  {{ axes = ["roll", "pitch", "yaw"], value = {toml_list(turn)}, '
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
            f'position = {{ value = {toml_list(place)}, unit = "m", {what} }}',
            f"direction = {list(direction)}",
            "",
        ]
    return "\n".join(lines)


def _hull_box(piece: Piece, at: int) -> str:
    sourced = 'unit = "m", tag = "S", source = "urdf"'
    return "\n".join(
        [
            "[[hull]]",
            f'name = "{toml_text(piece.name)} {at}"',
            f"centre = {{ value = {toml_list(piece.frame.origin)}, {sourced} }}",
            f"size = {{ value = {toml_list(piece.extent())}, {sourced} }}",
            "",
        ]
    )


def _solid(piece: Piece) -> str:
    """Return a solid: a cylinder along x stays one, in other directions it becomes a box."""
    along = np.abs(piece.frame.rotation[:, 2])
    is_cylinder = piece.shape == "cylinder" and along[0] > 1.0 - _LIKE_AXES
    shape = "cylinder" if is_cylinder else "sphere" if piece.shape == "sphere" else "box"
    return (
        f'{{ shape = "{shape}", size = {toml_list(piece.extent())}, '
        f'centre = {toml_list(piece.frame.origin)}, colour = "{piece.colour}" }}'
    )
