"""The box's faces: their outlines, what of a row they cover, and their share of its light."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.camera import rows
from seamark.sim.camera.geometry import Line, faces_seen, plane_map, project, row_of
from seamark.sim.camera.scene import Channel, Scene, Work
from seamark.sim.numerics.simd import (
    WIDTH,
    gather,
    lanes,
    larger,
    load,
    places,
    real,
    root,
    smaller,
    store,
    where_larger,
    whole,
)

if TYPE_CHECKING:
    from seamark.sim.numerics.simd import Lanes

Array = NDArray[np.float64]
Row = NDArray[np.float32]
Plane = NDArray[np.float32]
Texels = NDArray[np.int32]

_F = np.float32


@njit(cache=True, nogil=True, error_model="numpy")
def outline(
    plane: Array, rotation: Array, centre: Array, intrinsics: Array, edges: Array, box: Array
) -> bool:
    """Write a face's four edges as lines and its bounding box; False if a corner has no image."""
    corners = np.empty((4, 3))
    for j in range(3):
        corners[0, j] = plane[j]
        corners[1, j] = plane[j] + plane[3 + j]
        corners[2, j] = corners[1, j] + plane[6 + j]
        corners[3, j] = plane[j] + plane[6 + j]
    q = np.empty((4, 2))
    project(corners, rotation, centre, intrinsics, q)
    for k in range(4):
        if not abs(q[k, 0]) + abs(q[k, 1]) < 1e5:
            return False
    area = 0.0
    for k in range(4):
        n = (k + 1) % 4
        area += q[k, 0] * q[n, 1] - q[n, 0] * q[k, 1]
    if abs(area) < 1e-3:
        return False
    turn = 1.0 if area > 0 else -1.0
    for k in range(4):
        n = (k + 1) % 4
        dx = q[n, 0] - q[k, 0]
        dy = q[n, 1] - q[k, 1]
        length = max(np.sqrt(dx * dx + dy * dy), 1e-9)
        edges[k, 0] = turn * dy / length
        edges[k, 1] = -turn * dx / length
        edges[k, 2] = -(edges[k, 0] * q[k, 0] + edges[k, 1] * q[k, 1])
    box[0] = np.floor(q[:, 0].min() - 1.0)
    box[1] = np.floor(q[:, 1].min() - 1.0)
    box[2] = np.floor(q[:, 0].max() + 2.0)
    box[3] = np.floor(q[:, 1].max() + 2.0)
    return True


@njit(cache=True, nogil=True, error_model="numpy")
def span(edges: Array, y: float, low: int, high: int, slack: float) -> tuple[int, int]:
    """Return the columns of a row at most `slack` px outside a polygon, low <= column < high."""
    first = float(low)
    last = float(high - 1)
    for k in range(4):
        nx = edges[k, 0]
        rest = edges[k, 1] * y + edges[k, 2] - slack
        if abs(nx) < 1e-6:
            if rest > 0.0:
                return low, low
        elif nx > 0.0:
            last = min(last, np.floor(-rest / nx))
        else:
            first = max(first, np.ceil(-rest / nx))
    if last < first:
        return low, low
    return int(first), int(last) + 1


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _texture(skin: Texels, u: "Lanes", v: "Lanes", layout: tuple[int, int, int]) -> "Lanes":
    """Return light [grey] of a face at texels u, v; its edges are repeated.

    `layout` is the face in the skin: offset, columns, rows.
    """
    offset, columns, height = layout
    zero = lanes(0.0)
    u = smaller(larger(u, zero), lanes(_F(columns) - _F(1.001)))
    v = smaller(larger(v, zero), lanes(_F(height) - _F(1.001)))
    iu, iv = whole(u), whole(v)
    four = gather(skin, places(offset) + (iv * places(columns) + iu))
    return rows.mixture(four, u - real(iu), v - real(iv))


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _transmission(path: "Lanes") -> "Lanes":
    """Return exp(-path) as p(-path / 64)^64, p a polynomial: to 1e-5 of it for path < 10."""
    one = lanes(1.0)
    t = larger(path * lanes(-1.0), lanes(-40.0)) * lanes(1.0 / 64.0)
    p = lanes(1.0 / 24.0) + t * lanes(1.0 / 120.0)
    p = lanes(1.0 / 6.0) + t * p
    p = lanes(0.5) + t * p
    p = one + t * p
    p = one + t * p
    p = p * p
    p = p * p
    p = p * p
    p = p * p
    p = p * p
    return p * p


@njit(cache=True, nogil=True, error_model="numpy")
def _edge_lines(edges: Array) -> Plane:
    """Return for each edge (4, 3) what its distances say: (4, 4) nx and `_inside`'s s, m, scale."""
    out = np.empty((4, 4), np.float32)
    for k in range(4):
        nx = _F(edges[k, 0])
        a = max(abs(nx), _F(0.02))
        b = max(_F(abs(edges[k, 1])), _F(0.02))
        out[k, 0] = nx
        out[k, 1] = (a + b) * _F(0.5)
        out[k, 2] = abs(a - b) * _F(0.5)
        out[k, 3] = _F(0.5) / (a * b)
    return out


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _inside(distance: "Lanes", s: np.float32, m: np.float32, scale: np.float32) -> "Lanes":
    """Return how much of pixels lies inside an edge, by the distances of their centres inwards.

    The second difference of t^2 / 2: the area that a half-plane cuts from a unit square.
    """
    zero, one = lanes(0.0), lanes(1.0)
    q1 = larger(distance + lanes(s), zero)
    q2 = larger(distance + lanes(m), zero)
    q3 = larger(distance - lanes(m), zero)
    q4 = larger(distance - lanes(s), zero)
    area = ((q1 * q1 - q2 * q2) - (q3 * q3 - q4 * q4)) * lanes(scale)
    return where_larger(distance, lanes(s), one, smaller(larger(area, zero), one))


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _coverage(lines: Plane, bases: Row, x: int) -> "Lanes":
    """Return how much of sixteen pixels from column x on lies inside a convex polygon.

    Exact along straight edges. `lines` are those of `_edge_lines`, `bases` their distances
    outwards at column 0 of this row.
    """
    cover = lanes(1.0)
    first, last = _F(x), _F(x + (WIDTH - 1))
    column = lanes(first) + load(rows.STEPS, 0, 0)
    for k in range(4):
        nx, s = lines[k, 0], lines[k, 1]
        if -(bases[k] + max(nx * first, nx * last)) > s:  # all of them are inside this edge
            continue
        distance = (lanes(bases[k]) + lanes(nx) * column) * lanes(-1.0)
        cover = cover * _inside(distance, s, lines[k, 2], lines[k, 3])
    return cover


class Outlines(NamedTuple):
    """The faces in one picture."""

    seen: NDArray[np.bool_]  # (n,) whether to draw it
    maps: Array  # (n, 3, 3) pixel -> texel/z, texel/z, 1/z
    edges: Array  # (n, 4, 3)
    boxes: Array  # (n, 4) [px] x0, y0, x1, y1


@njit(cache=True, nogil=True, error_model="numpy")
def outlines(
    faces: Array, layout: Texels, rotation: Array, centre: Array, intrinsics: Array
) -> Outlines:
    """Return which faces (n, 12) are to be drawn and where; `layout` is (n, 3)."""
    count = faces.shape[0]
    maps = np.empty((count, 3, 3))
    edges = np.empty((count, 4, 3))
    boxes = np.empty((count, 4))
    seen = faces_seen(faces, centre)
    for k in range(count):
        if not seen[k]:
            continue
        seen[k] = plane_map(faces[k], rotation, centre, intrinsics, maps[k]) and outline(
            faces[k], rotation, centre, intrinsics, edges[k], boxes[k]
        )
        for c in range(3):
            maps[k, 0, c] = maps[k, 0, c] * layout[k, 1] - 0.5 * maps[k, 2, c]
            maps[k, 1, c] = maps[k, 1, c] * layout[k, 2] - 0.5 * maps[k, 2, c]
    return Outlines(seen, maps, edges, boxes)


@njit(cache=True, nogil=True, error_model="numpy")
def _draw_row(
    shape: tuple[Line, Plane, Row, tuple[int, int, int]],
    place: tuple[int, int, int, int],
    ray: tuple[float, float, float],
    channel: tuple[Texels, bool, float, float],
    light: Plane,
    ground: Plane,
    gain: Plane,
) -> None:
    """Blend a row of a face into the light, (rows, width) as the ground and the gain.

    `shape` is the row's map, the edges and their distances, and the place in the skin; `place` the
    row, its first column and the end in the strip, and where the strip starts; `ray` focal length,
    principal column [px] and the row's slope in the camera frame; `channel` skin, law, attenuation
    and veil.
    """
    line, lines, bases, layout = shape
    r, first, end, start = place
    skin, fog, attenuation, veil = channel
    a0, b0, w0 = lanes(line[0]), lanes(line[1]), lanes(line[2])
    a1, b1, w1 = lanes(line[3]), lanes(line[4]), lanes(line[5])
    inverse, middle = lanes(1.0 / ray[0]), lanes(ray[1])
    square, c = lanes(1.0 + ray[2] * ray[2]), lanes(attenuation)
    one, b, steps = lanes(1.0), lanes(veil), load(rows.STEPS, 0, 0)
    for q in range(first, end, WIDTH):
        column = lanes(float(start + q)) + steps
        z = one / larger(w0 + w1 * column, lanes(1e-3))
        radiance = _texture(skin, (a0 + a1 * column) * z, (b0 + b1 * column) * z, layout)
        if gain.shape[1]:
            radiance = radiance * load(gain, r, q)
        path = c * z
        x = (column - middle) * inverse
        path = path * path if fog else path * root(square + x * x)
        arrived = (radiance - b) * _transmission(path) + b
        cover = _coverage(lines, bases, start + q)
        before = load(light, r, q)
        store(light, r, q, before + cover * (arrived - load(ground, r, q)))


@njit(cache=True, nogil=True, error_model="numpy")
def _draw_face(
    shape: tuple[Array, Array, Texels],
    place: tuple[int, int, int, int],
    lens: tuple[Array, bool],
    channel: tuple[Texels, float, float],
    light: Plane,
    ground: Plane,
    gain: Plane,
) -> None:
    """Blend one face into rows of a strip (rows, width); `ground` is what was there before all.

    `shape` is its map, edges and place in the skin, `place` row and column of the first pixel and
    the window's columns, `lens` intrinsics and law, `channel` skin, attenuation and veil.
    """
    pixel_map, edges, layout = shape
    top, start, x0, x1 = place
    skin, attenuation, veil = channel
    f, u0, v0 = lens[0][0], lens[0][1], lens[0][2]
    corner = (layout[0], layout[1], layout[2])
    lines = _edge_lines(edges)
    bases = np.empty(4, np.float32)
    of_channel = (skin, lens[1], attenuation, veil)
    for r in range(light.shape[0]):
        v = float(top + r)
        a, b = span(edges, v, x0, x1, 0.75)
        if b <= a:
            continue
        for k in range(4):
            bases[k] = edges[k, 1] * v + edges[k, 2]
        first = (a - start) // WIDTH * WIDTH
        _draw_row(
            (row_of(pixel_map, v), lines, bases, corner),
            (r, first, b - start, start),
            (f, u0, (v - v0) / f),
            of_channel,
            light,
            ground,
            gain,
        )


@njit(cache=True, nogil=True, error_model="numpy")
def _in_strip(shapes: Outlines, k: int, row: int, end: int) -> tuple[int, int]:
    """Return the rows, from `row` to `end`, that a face may touch; none of an unseen one."""
    if not shapes.seen[k]:
        return row, row
    top = max(row, int(max(shapes.boxes[k, 1], -1e6)))
    return top, min(end, int(min(shapes.boxes[k, 3], 1e6)))


@njit(cache=True, nogil=True, error_model="numpy")
def draw_faces(
    shapes: Outlines,
    place: tuple[int, int, int, int, int],
    scene: Scene,
    channel: Channel,
    work: Work,
    light: Row,
    gain: Row,
) -> None:
    """Blend the faces into a strip of rows, (rows * width,) [grey].

    `place` is row and column of the strip's first pixel, its width, and the window's columns.
    `gain` is the light on the faces if it is not the usual daylight, else empty.
    """
    row, start, width, x0, x1 = place
    height = light.shape[0] // width
    drawn = 0
    for k in range(shapes.seen.shape[0]):
        top, end = _in_strip(shapes, k, row, row + height)
        drawn += top < end
    ground = light
    if drawn > 1:  # a face alone finds the ground as it was
        ground = work.ground[: light.shape[0]]
        rows.copy(light, ground)
    shape = height, width
    lit, bare = light.reshape(shape), ground.reshape(shape)
    daylight = gain.reshape(height, gain.shape[0] // height)
    for k in range(shapes.seen.shape[0]):
        top, end = _in_strip(shapes, k, row, row + height)
        if top >= end:
            continue
        first, last = top - row, end - row
        _draw_face(
            (shapes.maps[k], shapes.edges[k], scene.layout[k]),
            (top, start, x0, x1),
            (scene.intrinsics, scene.fog),
            (channel.skin, channel.attenuation, channel.veil),
            lit[first:last],
            bare[first:last],
            daylight[first:last],
        )
