"""An arm drawn from three sides where it starts, as SVG: its solids, joints and tip."""

import math
from collections.abc import Iterator
from html import escape

import numpy as np

from seamark.sim.numerics.arrays import Array
from seamark.sim.vehicles.drawing import STYLE, VIEWS, Page, View
from seamark.sim.vehicles.kinematics import Axes, home, links_at, tip
from seamark.sim.vehicles.linkage import Linkage
from seamark.sim.vehicles.solids import Solid

_VIEW_PX, _MARGIN_PX = 420.0, 60.0
_ROUND = 16  # points of a circle


def arm_drawing(arm: Linkage) -> str:
    """Return an SVG document with the arm from starboard, ahead and above."""
    axes = links_at(arm, home(arm))
    outlines = [
        (solid, np.array([axes[link.name].at(point) for point in _surface(solid)]))
        for link in arm.links
        for solid in link.solids
    ]
    points = np.concatenate([each for _, each in outlines] + [[one.point] for one in axes.values()])
    low, high = points.min(axis=0), points.max(axis=0)
    scale = _VIEW_PX / max(float((high - low).max()), 1e-3)
    length, width, height = ((high - low) * scale).tolist()
    top = _MARGIN_PX + 20.0
    places = (
        (_MARGIN_PX, top),
        (2.0 * _MARGIN_PX + length, top),
        (_MARGIN_PX, top + height + _MARGIN_PX),
    )
    across = 3.0 * _MARGIN_PX + length + max(width, 300.0)
    down = top + height + max(width, 120.0) + 2.5 * _MARGIN_PX
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {across:.0f} {down:.0f}" '
        f'width="{across:.0f}" height="{down:.0f}" role="img">',
        f"<title>{escape(arm.title)}</title>",
        STYLE,
        '<rect width="100%" height="100%" fill="white"/>',
        f'<text class="title" x="{_MARGIN_PX:.0f}" y="32">{escape(arm.title)}</text>',
    ]
    for view, (left, above) in zip(VIEWS, places, strict=True):
        corners = [view.flat((x, y, z)) for x, y, z in points.tolist()]
        origin = min(a for a, _ in corners), min(b for _, b in corners)
        parts += _drawn(arm, axes, outlines, Page(view, left, above, scale, origin))
    parts += _legend(2.0 * _MARGIN_PX + length, top + height + _MARGIN_PX, scale)
    return "\n".join([*parts, "</svg>"]) + "\n"


def _surface(solid: Solid) -> Iterator[Array]:
    """Yield points in the link's axes whose hull is the solid's outline from any side."""
    size, centre = 0.5 * np.array(solid.size), np.array(solid.centre)
    circle = [2.0 * math.pi * k / _ROUND for k in range(_ROUND)]
    if solid.shape == "box":
        for corner in range(8):
            yield centre + size * [1.0 if corner & 1 << axis else -1.0 for axis in range(3)]
        return
    for end in (-1.0, 1.0):
        for angle in circle:
            rim = np.array([end * size[0], size[1] * math.cos(angle), size[2] * math.sin(angle)])
            if solid.shape == "cylinder":
                yield centre + rim
                continue
            # Spheres at the ends of a capsule, or one: circles of latitude.
            middle = np.array([end * max(size[0] - size[1], 0.0), 0.0, 0.0])
            for latitude in np.linspace(0.0, 0.5 * math.pi, 5):
                along = [end * size[1] * math.sin(latitude), 0.0, 0.0]
                yield centre + middle + along + math.cos(latitude) * rim * [0.0, 1.0, 1.0]


def _drawn(
    arm: Linkage, axes: dict[str, Axes], outlines: list[tuple[Solid, Array]], page: Page
) -> Iterator[str]:
    view: View = page.view
    yield f'<text x="{page.left:.1f}" y="{page.top - 10.0:.1f}">{view.title}</text>'
    towards, sign = view.towards
    for solid, points in sorted(outlines, key=lambda one: float(sign * one[1][:, towards].mean())):
        flat = _around([page.at((x, y, z)) for x, y, z in points.tolist()])
        corners = " ".join(f"{x:.1f},{y:.1f}" for x, y in flat)
        colour = escape(solid.paint.colour)
        yield f'<polygon class="solid" fill="{colour}" points="{corners}"/>'
    for link in arm.links:
        if link.joint.kind in ("revolute", "prismatic"):
            x, y = page.at(_point(axes[link.name].point))
            name = f"{link.name}: {link.joint.kind}"
            yield f'<circle class="towards" cx="{x:.1f}" cy="{y:.1f}" r="5">'
            yield f"<title>{escape(name)}</title></circle>"
    x, y = page.at(_point(tip(arm, axes)))
    yield f'<path class="towards" d="M{x - 5:.1f} {y:.1f}h10m-5 -5v10"/>'


def _around(points: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Return the corners of the convex hull of points in a plane (Andrew's monotone chain)."""
    ordered = sorted(set(points))
    hull: list[tuple[float, float]] = []
    for one in (ordered, ordered[::-1]):
        start = len(hull)
        for x, y in one:
            while len(hull) >= start + 2:
                (a, b), (c, d) = hull[-2], hull[-1]
                if (c - a) * (y - b) - (d - b) * (x - a) > 0.0:
                    break
                hull.pop()
            hull.append((x, y))
        hull.pop()
    return hull


def _point(values: Array) -> tuple[float, float, float]:
    x, y, z = values.tolist()
    return x, y, z


def _legend(left: float, top: float, scale: float) -> Iterator[str]:
    nice = next(size for size in (1.0, 0.5, 0.2, 0.1, 0.05, 0.01, 1e-3) if size * scale < 200.0)
    lines = ("where it starts; what carries it is level", "circles: joints; cross: its tip")
    for at, line in enumerate(lines):
        yield f'<text x="{left:.1f}" y="{top + 20.0 * at:.1f}">{line}</text>'
    y = top + 20.0 * len(lines)
    yield (
        f'<path class="scale" d="M{left:.1f} {y + 4:.1f}v8m0 -4h{nice * scale:.1f}m0 -4v8" '
        'fill="none"/>'
    )
    yield f'<text x="{left + nice * scale + 8:.1f}" y="{y + 12:.1f}">{nice:g} m</text>'
