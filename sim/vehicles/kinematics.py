"""Where the links of an arm are, for figures and drawings: nothing here feeds a run."""

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from seamark.sim.numerics.arrays import Array
from seamark.sim.vehicles.linkage import Joint, Linkage, Touchable
from seamark.sim.vehicles.model import Place

_SWEEPS, _SAMPLES = 3, 49  # of the search for the pose that reaches farthest


class Axes(NamedTuple):
    """Axes in those of what carries the arm: p = turn q + point."""

    turn: Array  # (3, 3)
    point: Array  # (3,) [m]

    def at(self, point: Array) -> Array:
        """Return a point of these axes in the outer ones."""
        moved: Array = self.turn @ point + self.point
        return moved


def links_at(linkage: Linkage, coordinates: Mapping[str, float]) -> dict[str, Axes]:
    """Return the axes of each link; joints that are not named are at coordinate zero."""
    axes: dict[str, Axes] = {}
    for link in linkage.links:
        outer = Axes(np.eye(3), np.zeros(3)) if link.parent is None else axes[link.parent]
        joint, value = link.joint, coordinates.get(link.name, 0.0)
        if joint.follows:
            other, ratio = joint.follows
            value = ratio * coordinates.get(other, 0.0)
        axes[link.name] = _moved(placed(outer, joint.place), joint, value)
    return axes


def home(linkage: Linkage) -> dict[str, float]:
    """Return where the joints of an arm start: at home, or within the range near zero."""
    return {
        link.name: link.joint.home.scalar if link.joint.home else _within(link.joint, 0.0)
        for link in linkage.links
        if link.joint.kind in ("revolute", "prismatic")
    }


def stretched(linkage: Linkage) -> dict[str, float]:
    """Return coordinates at which the tip is farthest from the first joint that moves, level.

    The carrier's axes are level: z is down.
    """
    found = home(linkage)
    moving = [link for link in linkage.links if link.name in found and not link.joint.follows]
    for _ in range(_SWEEPS):
        for link in moving:
            low, high = link.joint.range.value if link.joint.range else (-math.pi, math.pi)
            tried = [found | {link.name: value} for value in np.linspace(low, high, _SAMPLES)]
            found = max([found, *tried], key=lambda one: reach(linkage, one))
    return found


def reach(linkage: Linkage, coordinates: Mapping[str, float]) -> float:
    """Return how far the tip is from the first joint that moves, level [m]."""
    axes = links_at(linkage, coordinates)
    return float(np.linalg.norm((tip(linkage, axes) - axes[first_joint(linkage)].point)[:2]))


def first_joint(linkage: Linkage) -> str:
    """Return the first link that moves."""
    return next(link.name for link in linkage.links if link.joint.kind != "fixed")


def tip(linkage: Linkage, axes: Mapping[str, Axes]) -> Array:
    """Return the outermost point of the shapes that may touch things, or of all, (3,) [m]."""
    start = axes[first_joint(linkage)].point
    shapes = [(link.name, shape) for link in linkage.links for shape in link.shapes]
    outer = [(name, shape) for name, shape in shapes if shape.name in linkage.outer] or shapes
    points = [axes[name].at(end) for name, shape in outer for end in _ends(shape)]
    points += [] if points else [one.point for one in axes.values()]
    return max(points, key=lambda point: float(np.linalg.norm(point - start)))


def placed(outer: Axes, place: Place) -> Axes:
    """Return the axes of a place in others."""
    return Axes(outer.turn @ _turn(place), outer.at(np.array(place.point.value)))


def _ends(shape: Touchable) -> list[Array]:
    own = placed(Axes(np.eye(3), np.zeros(3)), shape.place)
    sizes = shape.size.value
    if shape.kind == "box":
        return [own.at(np.array([x, 0.0, 0.0])) for x in (-sizes[0], sizes[0])]
    half = sizes[1] + (sizes[0] if shape.kind == "capsule" else 0.0)
    return [own.at(np.array([x, 0.0, 0.0])) for x in (-half, half)]


def _moved(axes: Axes, joint: Joint, value: float) -> Axes:
    axis = np.array(joint.axis)
    if joint.kind == "prismatic":
        return Axes(axes.turn, axes.at(value * axis))
    if joint.kind != "revolute":
        return axes
    x, y, z = axis
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    own = np.eye(3) + math.sin(value) * skew + (1.0 - math.cos(value)) * skew @ skew
    return Axes(axes.turn @ own, axes.point)


def _turn(place: Place) -> Array:
    (sr, sp, sy), (cr, cp, cy) = np.sin(place.turn.value), np.cos(place.turn.value)
    made: Array = (
        np.array([[cy, -sy, 0.0], [sy, cy, 0.0], [0.0, 0.0, 1.0]])
        @ np.array([[cp, 0.0, sp], [0.0, 1.0, 0.0], [-sp, 0.0, cp]])
        @ np.array([[1.0, 0.0, 0.0], [0.0, cr, -sr], [0.0, sr, cr]])
    )
    return made


def _within(joint: Joint, value: float) -> float:
    low, high = joint.range.value if joint.range else (-math.pi, math.pi)
    return min(max(value, low), high)
