"""A vehicle drawn from three sides, as SVG: solids, hull, thrusters, centres."""

from collections.abc import Iterator
from html import escape
from typing import NamedTuple

from seamark.sim.vehicles.capabilities import bounding_box
from seamark.sim.vehicles.model import Vehicle
from seamark.sim.vehicles.solids import Point, Solid

_VIEW_PX = 420.0  # longest side of a view
_MARGIN_PX = 60.0
_ARROW = 0.16  # of the longest side of the vehicle
STYLE = """\
<style>
text { font: 13px sans-serif; fill: #14212b; }
.title { font-size: 17px; font-weight: bold; }
.solid { stroke: #14212b; stroke-width: 0.8; fill-opacity: 0.85; }
.hull { fill: none; stroke: #d23; stroke-width: 1; stroke-dasharray: 5 4; }
.thruster { stroke: #d23; stroke-width: 2; fill: #d23; }
.towards { stroke: #d23; stroke-width: 2; fill: none; }
.centre { stroke: #14212b; stroke-width: 1.5; }
.scale { stroke: #14212b; stroke-width: 2; }
</style>"""


class View(NamedTuple):
    """Where one looks at the vehicle from, and what is to the right and down on the page."""

    title: str
    right: tuple[int, float]  # axis of the body and sign
    down: tuple[int, float]
    towards: tuple[int, float]  # to who looks

    def flat(self, point: Point) -> tuple[float, float]:
        """Return a point of the body on the page [m]."""
        (a, sign_a), (b, sign_b) = self.right, self.down
        return sign_a * point[a], sign_b * point[b]

    def nearness(self, point: Point) -> float:
        """Return how near a point is to who looks [m]."""
        axis, sign = self.towards
        return sign * point[axis]


VIEWS = (
    View("from starboard", (0, 1.0), (2, 1.0), (1, 1.0)),
    View("from ahead", (1, -1.0), (2, 1.0), (0, 1.0)),
    View("from above", (0, 1.0), (1, 1.0), (2, -1.0)),
)


class Page(NamedTuple):
    """A place of a view on the page."""

    view: View
    left: float
    top: float
    scale: float  # [px/m]
    origin: tuple[float, float]  # [m] of the view's upper left corner

    def at(self, point: Point) -> tuple[float, float]:
        """Return a point of the body on the page [px]."""
        a, b = self.view.flat(point)
        return (
            self.left + (a - self.origin[0]) * self.scale,
            self.top + (b - self.origin[1]) * self.scale,
        )


def drawing(vehicle: Vehicle) -> str:
    """Return an SVG document with the vehicle from starboard, ahead and above."""
    low, high = _extent(vehicle)
    sizes = [high[axis] - low[axis] for axis in range(3)]
    scale = _VIEW_PX / max(sizes)
    length, width, height = (size * scale for size in sizes)
    top = _MARGIN_PX + 20.0
    places = (
        (_MARGIN_PX, top),
        (2.0 * _MARGIN_PX + length, top),
        (_MARGIN_PX, top + height + _MARGIN_PX),
    )
    across = 3.0 * _MARGIN_PX + length + max(width, 280.0)
    down = top + height + width + 2.5 * _MARGIN_PX
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {across:.0f} {down:.0f}" '
        f'width="{across:.0f}" height="{down:.0f}" role="img">',
        f"<title>{escape(vehicle.title)}</title>",
        STYLE,
        '<rect width="100%" height="100%" fill="white"/>',
        f'<text class="title" x="{_MARGIN_PX:.0f}" y="32">{escape(vehicle.title)}</text>',
    ]
    for view, (left, above) in zip(VIEWS, places, strict=True):
        corners = [view.flat((x, y, z)) for x in (low[0], high[0]) for y in (low[1], high[1])
                   for z in (low[2], high[2])]  # fmt: skip
        origin = min(a for a, _ in corners), min(b for _, b in corners)
        parts += _drawn(vehicle, Page(view, left, above, scale, origin), max(sizes))
    parts += _legend(vehicle, 2.0 * _MARGIN_PX + length, top + height + _MARGIN_PX, scale)
    return "\n".join([*parts, "</svg>"]) + "\n"


def _extent(vehicle: Vehicle) -> tuple[list[float], list[float]]:
    """Return the corners of the box around everything that is drawn."""
    low, high = (corner.tolist() for corner in bounding_box(vehicle))
    boxes = [(one.centre, one.size) for one in vehicle.drawn()]
    points = [one.position.value for one in vehicle.thrusters]
    points += [vehicle.centre_of_gravity.value, vehicle.centre_of_buoyancy.value]
    for axis in range(3):
        low[axis] = min(
            low[axis],
            *(centre[axis] - 0.5 * size[axis] for centre, size in boxes),
            *(point[axis] for point in points),
        )
        high[axis] = max(
            high[axis],
            *(centre[axis] + 0.5 * size[axis] for centre, size in boxes),
            *(point[axis] for point in points),
        )
    return low, high


def _drawn(vehicle: Vehicle, page: Page, longest: float) -> Iterator[str]:
    view = page.view
    yield f'<text x="{page.left:.1f}" y="{page.top - 10.0:.1f}">{view.title}</text>'
    for solid in sorted(vehicle.drawn(), key=lambda one: view.nearness(one.centre)):
        yield _solid(solid, page)
    for piece in vehicle.hull:
        x, y, width, height = _rectangle(_point(piece.centre.value), _point(piece.size.value), page)
        yield (
            f'<rect class="hull" x="{x:.1f}" y="{y:.1f}" width="{width:.1f}" height="{height:.1f}">'
            f"<title>hull: {escape(piece.name)}</title></rect>"
        )
    for number, thruster in enumerate(vehicle.thrusters):
        name = f"{number}: {escape(thruster.name)}"
        position = _point(thruster.position.value)
        yield f"<g><title>{name}</title>"
        yield from _arrow(position, thruster.direction, page, _ARROW * longest)
        yield "</g>"
    for letter, place in (("G", vehicle.centre_of_gravity), ("B", vehicle.centre_of_buoyancy)):
        x, y = page.at(_point(place.value))
        fill = "#14212b" if letter == "G" else "white"
        yield f'<circle class="centre" cx="{x:.1f}" cy="{y:.1f}" r="4.5" fill="{fill}"/>'


def _point(values: tuple[float, ...]) -> Point:
    x, y, z = values
    return x, y, z


def _rectangle(centre: Point, size: Point, page: Page) -> tuple[float, float, float, float]:
    x, y = page.at(centre)
    width, height = size[page.view.right[0]] * page.scale, size[page.view.down[0]] * page.scale
    return x - 0.5 * width, y - 0.5 * height, width, height


def _solid(solid: Solid, page: Page) -> str:
    x, y, width, height = _rectangle(solid.centre, solid.size, page)
    along = page.view.right[0] == 0  # cylinders and capsules lie along x
    fill = f'class="solid" fill="{escape(solid.paint.colour)}"'
    if solid.shape == "sphere" or (solid.shape in ("cylinder", "capsule") and not along):
        return (
            f'<ellipse {fill} cx="{x + 0.5 * width:.1f}" cy="{y + 0.5 * height:.1f}" '
            f'rx="{0.5 * width:.1f}" ry="{0.5 * height:.1f}"/>'
        )
    round_px = 0.5 * min(width, height) if solid.shape == "capsule" else 0.0
    return (
        f'<rect {fill} x="{x:.1f}" y="{y:.1f}" width="{width:.1f}" height="{height:.1f}" '
        f'rx="{round_px:.1f}"/>'
    )


def _arrow(start: Point, direction: Point, page: Page, length: float) -> Iterator[str]:
    """Yield an arrow along a thrust; one that points at the reader is a dot, away a cross."""
    x, y = page.at(start)
    a, b = (length * page.scale * part for part in page.view.flat(direction))
    size = (a * a + b * b) ** 0.5
    if size < 0.2 * length * page.scale:
        yield f'<circle class="towards" cx="{x:.1f}" cy="{y:.1f}" r="7"/>'
        if page.view.nearness(direction) > 0.0:
            yield f'<circle class="thruster" cx="{x:.1f}" cy="{y:.1f}" r="2"/>'
        else:
            yield (
                f'<path class="towards" d="M{x - 5:.1f} {y - 5:.1f}l10 10M{x + 5:.1f} {y - 5:.1f}'
                'l-10 10"/>'
            )
        return
    c, d = a / size, b / size
    yield f'<line class="thruster" x1="{x:.1f}" y1="{y:.1f}" x2="{x + a:.1f}" y2="{y + b:.1f}"/>'
    left = f"{x + a - 9.0 * c - 4.0 * d:.1f},{y + b - 9.0 * d + 4.0 * c:.1f}"
    right = f"{x + a - 9.0 * c + 4.0 * d:.1f},{y + b - 9.0 * d - 4.0 * c:.1f}"
    yield f'<polygon class="thruster" points="{x + a:.1f},{y + b:.1f} {left} {right}"/>'


def _legend(vehicle: Vehicle, left: float, top: float, scale: float) -> Iterator[str]:
    nice = next(size for size in (1.0, 0.5, 0.2, 0.1, 0.05, 0.01, 1e-3) if size * scale < 200.0)
    lines = (
        f"{len(vehicle.thrusters)} thrusters: red arrows in the direction",
        "of their push; dot: towards you, cross: away",
        "dashed: hull for contacts and for the drag check",
    )
    for at, line in enumerate(lines):
        yield f'<text x="{left:.1f}" y="{top + 20.0 * at:.1f}">{line}</text>'
    y = top + 20.0 * len(lines)
    for letter, fill in (("centre of gravity", "#14212b"), ("centre of buoyancy", "white")):
        yield f'<circle class="centre" cx="{left + 5:.1f}" cy="{y - 4:.1f}" r="4.5" fill="{fill}"/>'
        yield f'<text x="{left + 18:.1f}" y="{y:.1f}">{letter}</text>'
        y += 20.0
    yield (
        f'<path class="scale" d="M{left:.1f} {y + 4:.1f}v8m0 -4h{nice * scale:.1f}m0 -4v8" '
        'fill="none"/>'
    )
    yield f'<text x="{left + nice * scale + 8:.1f}" y="{y + 12:.1f}">{nice:g} m</text>'
