"""A vehicle with an arm beside a valve, above the bottom, for tests: no real arm."""

from math import pi

import numpy as np

from seamark.sim.multibody.assembly import vehicle_link
from seamark.sim.multibody.mechanism import (
    Coupling,
    Friction,
    Limits,
    Link,
    Mechanism,
    Motor,
    Point,
    Shape,
)
from seamark.sim.numerics.arrays import Array
from seamark.sim.physics.terrain import Bottom
from seamark.sim.vehicles import STANDARD_GRAVITY, load

STEP_S = 0.002
DENSITY = 1000.0
JAW_ROTOR = 1e-3  # [kg m²] a small motor behind its gear: more than the jaws' own inertia
GROUND = Bottom(10.0).ground()
LENGTHS = {
    "base": 0.05,
    "shoulder": 0.15,
    "elbow": 0.13,
    "wrist": 0.06,
    "left": 0.06,
    "right": 0.06,
}
ALONG_Y = ((0.0, -1.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0))


def about(mass: float, inertia: Array, centre: Point) -> Array:
    """Mass matrix (6, 6) about the origin of a body with this inertia about its centre."""
    x, y, z = centre
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    matrix = np.zeros((6, 6))
    matrix[:3, :3] = mass * np.eye(3)
    matrix[:3, 3:], matrix[3:, :3] = -mass * skew, mass * skew
    matrix[3:, 3:] = inertia + mass * skew.T @ skew
    return matrix


def rod(
    name: str,
    parent: str,
    *,
    offset: Point,
    axis: Point,
    length: float,
    radius: float,
    mass: float,
) -> Link:
    """A cylinder along x, from its joint on, that moves water aside."""
    centre = (0.5 * length, 0.0, 0.0)
    across = mass * (3.0 * radius**2 + length**2) / 12.0
    rigid = about(mass, np.diag([0.5 * mass * radius**2, across, across]), centre)
    moved = DENSITY * pi * radius**2 * length
    added = about(moved, np.diag([0.0, *[moved * length**2 / 12.0] * 2]), centre)
    added[0, 0] = 0.0
    net = (mass - moved) * STANDARD_GRAVITY
    drag = 0.5 * DENSITY * 1.1 * 2.0 * radius * length
    return Link(
        name=name,
        parent=parent,
        joint="revolute",
        offset=offset,
        axis=axis,
        rigid=rigid,
        added=added,
        net_weight=net,
        moment=(net * centre[0], 0.0, 0.0),
        quadratic=(0.0, drag, drag, 0.0, 0.0, 0.0),
        centre=centre,
    )


def arm() -> list[Link]:
    """Four joints, and two jaws that close on each other."""
    pitch, roll, yaw = (0.0, 1.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)
    joints: list[tuple[str, str, Point, Point, float, float]] = [
        ("base", "vehicle", (0.2, 0.0, 0.12), yaw, 0.03, 0.4),
        ("shoulder", "base", (0.05, 0.0, 0.0), pitch, 0.025, 0.4),
        ("elbow", "shoulder", (0.15, 0.0, 0.0), pitch, 0.02, 0.3),
        ("wrist", "elbow", (0.13, 0.0, 0.0), roll, 0.02, 0.2),
        ("left", "wrist", (0.06, -0.02, 0.0), yaw, 0.006, 0.03),
        ("right", "wrist", (0.06, 0.02, 0.0), yaw, 0.006, 0.03),
    ]
    return [
        rod(
            name,
            parent,
            offset=offset,
            axis=axis,
            length=LENGTHS[name],
            radius=radius,
            mass=mass,
        )
        for name, parent, offset, axis, radius, mass in joints
    ]


def vehicle_with_arm(*, valve_torque: float | None = None) -> Mechanism:
    """A BlueROV2 Heavy with the arm; and a valve that breaks away at a torque [N m]."""
    vehicle = load("bluerov2-heavy")
    parts = arm()
    mechanism = Mechanism(
        links=[vehicle_link(vehicle), *parts],
        motors=[Motor(link=part.name, effort=9.0) for part in parts if part.name != "right"],
        frictions=[Friction(link=part.name, resting=0.3, sliding=0.25) for part in parts],
        couplings=[Coupling(link="right", other="left", ratio=-1.0)],
        limits=[
            Limits(link="left", low=-0.6, high=0.3),
            Limits(link="shoulder", low=-1.5, high=1.5),
        ],
        allocation=vehicle.allocation(),
    )
    shapes = mechanism.shapes
    shapes += [
        Shape(name="ground", kind="ground"),
        Shape(name="hull", kind="box", link="vehicle", size=(0.23, 0.29, 0.13)),
    ]
    for jaw in parts[-2:]:
        jaw.rotor = JAW_ROTOR
    for part in parts:
        half, radius = 0.5 * LENGTHS[part.name], 0.006 if part.name in ("left", "right") else 0.02
        place, size = (half, 0.0, 0.0), (radius, half, 0.0)
        shapes.append(Shape(name=part.name, kind="capsule", link=part.name, place=place, size=size))
    low = ("hull", "shoulder", "elbow", "wrist", "left", "right")
    mechanism.pairs += [(name, "ground") for name in low]
    mechanism.pairs += [("left", "right"), ("elbow", "hull"), ("wrist", "hull")]
    if valve_torque is not None:
        inertia = np.diag([1.0, 1.0, 1.0, 0.01, 0.01, 0.01])
        mechanism.links.append(
            Link(
                name="valve",
                joint="revolute",
                offset=(0.68, 0.0, 5.12),
                axis=(1.0, 0.0, 0.0),
                rigid=inertia,
            )
        )
        mechanism.frictions.append(
            Friction(link="valve", resting=valve_torque, sliding=valve_torque)
        )
        shapes.append(
            Shape(name="lever", kind="capsule", link="valve", size=(0.01, 0.08, 0.0), turn=ALONG_Y)
        )
        mechanism.pairs += [(name, "lever") for name in ("left", "right", "wrist")]
    return mechanism
