"""What follows from the numbers of an arm, and what is wrong or unlikely about it."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from seamark.sim.numerics.arrays import Array
from seamark.sim.vehicles.kinematics import Axes, links_at, reach, stretched, tip
from seamark.sim.vehicles.linkage import Linkage, LinkData
from seamark.sim.vehicles.matrices import shifted, turned
from seamark.sim.vehicles.model import STANDARD_GRAVITY
from seamark.sim.vehicles.plausibility import WATER, Finding

STEP_S = 0.002  # [s] of the mechanism's integrator
FASTEST_START = 2e4  # [rad/s² or m/s²] E: jaws that start faster need more rounds of the solver
FLOW = 2.0  # [m/s] at which drag must leave a link some of its speed in a step
_STOPPED = 0.5  # share of a link's speed
_NO_LEVER = 1e-3  # [m]
_DOWN = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, slots=True)
class JointFigures:
    """A joint with a motor, the arm stretched out level; what carries it is level."""

    name: str
    turns: bool
    effort: float  # [N m or N]
    speed: float  # [rad/s or m/s]
    own_weight: float  # [N m or N] to hold the arm in water
    payload_n: float  # [N] at the tip that it holds besides
    inertia: float  # [kg m² or kg] that it feels, in water and with its motor


@dataclass(frozen=True, slots=True)
class ArmFigures:
    """What an arm can do."""

    reach_m: float
    mass_kg: float
    weight_in_water_n: float
    payload_n: float
    joints: tuple[JointFigures, ...]


def figures(arm: Linkage) -> ArmFigures:
    """Return what follows from an arm's numbers."""
    pose = stretched(arm)
    axes = links_at(arm, pose)
    joints = tuple(_joint(arm, link, axes) for link in arm.links if link.joint.effort is not None)
    volume = sum(link.body.volume.scalar for link in arm.links if link.body)
    return ArmFigures(
        reach_m=reach(arm, pose),
        mass_kg=arm.mass(),
        weight_in_water_n=STANDARD_GRAVITY * (arm.mass() - WATER * volume),
        payload_n=min((one.payload_n for one in joints), default=0.0),
        joints=joints,
    )


def findings(arm: Linkage, found: ArmFigures) -> list[Finding]:
    """Return everything that is found, errors first."""
    errors = [Finding("error", text) for text in _errors(arm, found)]
    return errors + [Finding("warning", text) for text in _warnings(arm, found)]


def _joint(arm: Linkage, link: LinkData, axes: dict[str, Axes]) -> JointFigures:
    joint, own = link.joint, axes[link.name]
    turns = joint.kind == "revolute"
    along = own.turn @ np.array(joint.axis)
    beyond = _beyond(arm, link.name)
    effort = joint.effort.scalar if joint.effort else 0.0
    if turns:
        first_moment = sum((_first_moment(one, axes, own.point) for one in beyond), np.zeros(3))
        needed = float(along @ np.cross(first_moment, _DOWN))
        lever = abs(float(along @ np.cross(tip(arm, axes) - own.point, _DOWN)))
    else:
        lever = abs(float(along @ _DOWN))
        needed = lever * sum(_net_weight(one) for one in beyond)
    mass = sum((_mass(one, axes, own) for one in beyond), np.zeros((6, 6)))
    axis, part = np.array(joint.axis), slice(3, 6) if turns else slice(0, 3)
    return JointFigures(
        name=link.name,
        turns=turns,
        effort=effort,
        speed=joint.speed.scalar if joint.speed else 0.0,
        own_weight=abs(needed),
        payload_n=max(0.0, effort - abs(needed)) / lever if lever > _NO_LEVER else float("inf"),
        inertia=float(axis @ mass[part, part] @ axis)
        + (joint.rotor.scalar if joint.rotor else 0.0),
    )


def _beyond(arm: Linkage, name: str) -> list[LinkData]:
    """Return a link and all that hang on it."""
    names = {name}
    for link in arm.links:
        if link.parent in names:
            names.add(link.name)
    return [link for link in arm.links if link.name in names]


def _net_weight(link: LinkData) -> float:
    return link.body.weights(WATER, STANDARD_GRAVITY)[0] if link.body else 0.0


def _first_moment(link: LinkData, axes: dict[str, Axes], about: Array) -> Array:
    """Return weight times its place minus buoyancy times its place, (3,) [N m]."""
    if link.body is None:
        return np.zeros(3)
    net, moment = link.body.weights(WATER, STANDARD_GRAVITY)
    own = axes[link.name]
    made: Array = own.turn @ moment + net * (own.point - about)
    return made


def _mass(link: LinkData, axes: dict[str, Axes], joint: Axes) -> Array:
    """Return the mass matrix of a link, rigid and added, about a joint in its axes, (6, 6)."""
    if link.body is None:
        return np.zeros((6, 6))
    own = axes[link.name]
    matrix = turned(link.body.rigid() + link.body.added(), joint.turn.T @ own.turn)
    return shifted(matrix, joint.turn.T @ (own.point - joint.point))


def _errors(arm: Linkage, found: ArmFigures) -> Iterator[str]:
    if not found.joints:
        yield "No joint has a motor: give joints effort and speed."
    for one, link in zip(found.joints, _driven(arm), strict=True):
        if link.joint.friction and link.joint.friction.value[0] >= one.effort:
            yield (
                f"{one.name}: its friction to break away, {link.joint.friction.value[0]:g} "
                f"{_effort_unit(one)}, is not less than its motor's effort, {one.effort:g}."
            )


def _warnings(arm: Linkage, found: ArmFigures) -> Iterator[str]:
    for one in found.joints:
        if one.own_weight > one.effort:
            yield (
                f"{one.name}: to hold the arm stretched out in water takes {one.own_weight:.3g} "
                f"{_effort_unit(one)}; its motor gives {one.effort:g}."
            )
        if one.effort > FASTEST_START * one.inertia:
            yield (
                f"{one.name}: its motor would bring it to {STEP_S * one.effort / one.inertia:.3g} "
                f"{'rad/s' if one.turns else 'm/s'} within a step of {1e3 * STEP_S:g} ms. Give the "
                "joint the rotor's inertia behind its gear (rotor), or contacts are inaccurate."
            )
    yield from _tool(arm)
    for link in arm.links:
        yield from _drag(link)
        if link.joint.kind in ("revolute", "prismatic") and link.joint.range is None:
            yield f"{link.name}: its joint has no range, so nothing stops it."


def _tool(arm: Linkage) -> Iterator[str]:
    owners = {shape.name: link.name for link in arm.links for shape in link.shapes}
    if not arm.outer:
        yield "No shape is in outer: the arm can touch nothing."
    elif not any(
        owners[a] != owners[b] for a, b in combinations(arm.outer, 2) if [a, b] in _pairs(arm)
    ):
        yield (
            "No two shapes of outer may touch each other (touches): it has no gripper that "
            "closes, so it can push and hook, but not hold."
        )
    for what in ("camera", "force_sensor"):
        if getattr(arm, what) is None:
            yield f"There is no {what}: programs will not have its readings."
    if arm.tool is None:
        yield "There is no tool: how far the hand is from what it should take is not recorded."


def _pairs(arm: Linkage) -> Sequence[list[str]]:
    return [list(order) for pair in arm.touches for order in (pair, pair[::-1])]


def _drag(link: LinkData) -> Iterator[str]:
    if link.body is None:
        return
    mass = link.body.mass.scalar
    for axis, linear, quadratic, added in zip(
        "xyz",
        link.body.linear_drag.value,
        link.body.quadratic_drag.value,
        link.body.added_mass.value,
        strict=True,
    ):
        share = STEP_S * (linear + quadratic * FLOW) / (mass + added)
        if share > _STOPPED:
            yield (
                f"{link.name}: at {FLOW:g} m/s along {axis} drag takes {share:.0%} of its speed in "
                "a step, more than the integrator follows: check its drag and its mass."
            )


def _driven(arm: Linkage) -> list[LinkData]:
    return [link for link in arm.links if link.joint.effort is not None]


def _effort_unit(one: JointFigures) -> str:
    return "N m" if one.turns else "N"
