"""The faces of the box: their outlines, the pixels that they cover, and their radiance."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.camera import rows
from seamark.sim.camera.geometry import (
    RowMap,
    map_along_row,
    plane_homography,
    project,
    visible_faces,
)
from seamark.sim.camera.scene import Buffers, Channel, Scene
from seamark.sim.numerics.simd import (
    WIDTH,
    f32x16,
    gather_pairs,
    i32x16,
    load,
    maximum,
    minimum,
    select_greater,
    sqrt,
    store,
    to_f32,
    to_i32,
)
from seamark.sim.numerics.stack import on_stack
from seamark.sim.numerics.uncounted import uncounted

if TYPE_CHECKING:
    from seamark.sim.numerics.simd import F32x16

Array = NDArray[np.float64]
Row = NDArray[np.float32]
Plane = NDArray[np.float32]
Texels = NDArray[np.uint16]
Places = NDArray[np.int32]

_F = np.float32


@njit(cache=True, nogil=True, error_model="numpy")
def outline(
    plane: Array, rotation: Array, centre: Array, intrinsics: Array, edges: Array, box: Array
) -> bool:
    """Write a face's edges as lines and its bounding box; False if a corner has no image point."""
    corners, q = on_stack(np.float64, 4, 3), on_stack(np.float64, 4, 2)
    for j in range(3):
        corners[0, j] = plane[j]
        corners[1, j] = plane[j] + plane[3 + j]
        corners[2, j] = corners[1, j] + plane[6 + j]
        corners[3, j] = plane[j] + plane[6 + j]
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
def columns_inside(edges: Array, y: float, low: int, high: int, slack: float) -> tuple[int, int]:
    """Return the columns, in low <= column < high, inside a polygon widened by `slack` [px]."""
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
def _texture(
    box_texture: Texels, u: "F32x16", v: "F32x16", layout: tuple[int, int, int]
) -> "F32x16":
    """Return the radiance [grey] of a face at texels u, v; its edges are repeated.

    `layout` is the face in the texture: offset, columns, rows.
    """
    offset, columns, height = layout
    zero = f32x16(0.0)
    u = minimum(maximum(u, zero), f32x16(_F(columns) - _F(1.001)))
    v = minimum(maximum(v, zero), f32x16(_F(height) - _F(1.001)))
    iu, iv = to_i32(u), to_i32(v)
    four = gather_pairs(box_texture, i32x16(offset) + (iv * i32x16(columns) + iu))
    return rows.bilinear(four, u - to_f32(iu), v - to_f32(iv))


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _transmission(path: "F32x16") -> "F32x16":
    """Return exp(-path) as p(-path / 64)^64, p a polynomial: to 1e-5 of it for path < 10."""
    one = f32x16(1.0)
    t = maximum(path * f32x16(-1.0), f32x16(-40.0)) * f32x16(1.0 / 64.0)
    p = f32x16(1.0 / 24.0) + t * f32x16(1.0 / 120.0)
    p = f32x16(1.0 / 6.0) + t * p
    p = f32x16(0.5) + t * p
    p = one + t * p
    p = one + t * p
    p = p * p
    p = p * p
    p = p * p
    p = p * p
    p = p * p
    return p * p


@uncounted
def _write_lines(edges: Array, out: Plane) -> None:
    """Write nx and the coefficients s, m, scale of `_inside` for each edge (4, 3): (4, 4)."""
    for k in range(4):
        nx = _F(edges[k, 0])
        a = max(abs(nx), _F(0.02))
        b = max(_F(abs(edges[k, 1])), _F(0.02))
        out[k, 0] = nx
        out[k, 1] = (a + b) * _F(0.5)
        out[k, 2] = abs(a - b) * _F(0.5)
        out[k, 3] = _F(0.5) / (a * b)


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _inside(distance: "F32x16", s: np.float32, m: np.float32, scale: np.float32) -> "F32x16":
    """Return the covered area of pixels, given the distances of their centres inside an edge.

    The second difference of t^2 / 2: the area that a half-plane cuts from a unit square.
    """
    zero, one = f32x16(0.0), f32x16(1.0)
    q1 = maximum(distance + f32x16(s), zero)
    q2 = maximum(distance + f32x16(m), zero)
    q3 = maximum(distance - f32x16(m), zero)
    q4 = maximum(distance - f32x16(s), zero)
    area = ((q1 * q1 - q2 * q2) - (q3 * q3 - q4 * q4)) * f32x16(scale)
    return select_greater(distance, f32x16(s), one, minimum(maximum(area, zero), one))


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _coverage(lines: Plane, bases: Row, x: int) -> "F32x16":
    """Return the share of sixteen pixels from column x on that lies inside a convex polygon.

    Exact along straight edges. `lines` are those of `_edge_lines`, `bases` their
    distances outwards at column 0 of this row.
    """
    cover = f32x16(1.0)
    first, last = _F(x), _F(x + (WIDTH - 1))
    column = f32x16(first) + load(rows.STEPS, 0, 0)
    for k in range(4):
        nx, s = lines[k, 0], lines[k, 1]
        if -(bases[k] + max(nx * first, nx * last)) > s:  # all of them are inside this edge
            continue
        distance = (f32x16(bases[k]) + f32x16(nx) * column) * f32x16(-1.0)
        cover = cover * _inside(distance, s, lines[k, 2], lines[k, 3])
    return cover


class Outlines(NamedTuple):
    """The faces in one image."""

    seen: NDArray[np.bool_]  # (n,) visible faces
    maps: Array  # (n, 3, 3) pixel -> texel/z, texel/z, 1/z
    edges: Array  # (n, 4, 3)
    boxes: Array  # (n, 4) [px] x0, y0, x1, y1


@njit(cache=True, nogil=True, error_model="numpy")
def outlines(
    faces: Array, layout: Places, rotation: Array, centre: Array, intrinsics: Array
) -> Outlines:
    """Return which faces (n, 12) are visible and where; `layout` is (n, 3)."""
    count = faces.shape[0]
    maps = np.empty((count, 3, 3))
    edges = np.empty((count, 4, 3))
    boxes = np.empty((count, 4))
    seen = visible_faces(faces, centre)
    for k in range(count):
        if not seen[k]:
            continue
        seen[k] = plane_homography(faces[k], rotation, centre, intrinsics, maps[k]) and outline(
            faces[k], rotation, centre, intrinsics, edges[k], boxes[k]
        )
        for c in range(3):
            maps[k, 0, c] = maps[k, 0, c] * layout[k, 1] - 0.5 * maps[k, 2, c]
            maps[k, 1, c] = maps[k, 1, c] * layout[k, 2] - 0.5 * maps[k, 2, c]
    return Outlines(seen, maps, edges, boxes)


@uncounted
def _draw_row(
    shape: tuple[RowMap, Plane, Row, tuple[int, int, int]],
    extent: tuple[int, int, int, int],
    ray: tuple[float, float, float],
    channel: tuple[Texels, bool, float, float],
    light: Plane,
    ground: Plane,
    gain: Plane,
) -> None:
    """Blend a row of a face into the light, (rows, width) as the ground and the gain.

    `shape` is the row's map, the edges, their distances and the layout in the texture; `extent` the
    row, its first and last column in the strip, and where the strip starts; `ray` focal length,
    principal column [px] and slope of the row in the camera frame; `channel` texture, law,
    attenuation and veil.
    """
    line, lines, bases, layout = shape
    r, first, end, start = extent
    box_texture, fog, attenuation, veil = channel
    a0, b0, w0 = f32x16(line[0]), f32x16(line[1]), f32x16(line[2])
    a1, b1, w1 = f32x16(line[3]), f32x16(line[4]), f32x16(line[5])
    inverse, middle = f32x16(1.0 / ray[0]), f32x16(ray[1])
    square, c = f32x16(1.0 + ray[2] * ray[2]), f32x16(attenuation)
    one, b, steps = f32x16(1.0), f32x16(veil), load(rows.STEPS, 0, 0)
    for q in range(first, end, WIDTH):
        column = f32x16(float(start + q)) + steps
        z = one / maximum(w0 + w1 * column, f32x16(1e-3))
        radiance = _texture(box_texture, (a0 + a1 * column) * z, (b0 + b1 * column) * z, layout)
        if gain.shape[1]:
            radiance = radiance * load(gain, r, q)
        path = c * z
        x = (column - middle) * inverse
        path = path * path if fog else path * sqrt(square + x * x)
        arrived = (radiance - b) * _transmission(path) + b
        cover = _coverage(lines, bases, start + q)
        before = load(light, r, q)
        store(light, r, q, before + cover * (arrived - load(ground, r, q)))


@uncounted
def _draw_face(
    shape: tuple[Array, Array, Places],
    extent: tuple[int, int, int, int],
    lens: tuple[Array, bool],
    channel: tuple[Texels, float, float],
    light: Plane,
    ground: Plane,
    gain: Plane,
) -> None:
    """Blend one face into rows of a strip (rows, width); `ground` is the radiance without any face.

    `shape` is its map, edges and layout in the texture; `extent` row and column of the first pixel
    and the window's columns; `lens` intrinsics and law; `channel` texture, attenuation and veil.
    """
    pixel_map, edges, layout = shape
    top, start, x0, x1 = extent
    box_texture, attenuation, veil = channel
    f, u0, v0 = lens[0][0], lens[0][1], lens[0][2]
    corner = (layout[0], layout[1], layout[2])
    lines, bases = on_stack(np.float32, 4, 4), on_stack(np.float32, 4)
    _write_lines(edges, lines)
    of_channel = (box_texture, lens[1], attenuation, veil)
    for r in range(light.shape[0]):
        v = float(top + r)
        a, b = columns_inside(edges, v, x0, x1, 0.75)
        if b <= a:
            continue
        for k in range(4):
            bases[k] = edges[k, 1] * v + edges[k, 2]
        first = (a - start) // WIDTH * WIDTH
        _draw_row(
            (map_along_row(pixel_map, v), lines, bases, corner),
            (r, first, b - start, start),
            (f, u0, (v - v0) / f),
            of_channel,
            light,
            ground,
            gain,
        )


@njit(cache=True, nogil=True, error_model="numpy")
def _rows_in_strip(shapes: Outlines, k: int, row: int, end: int) -> tuple[int, int]:
    """Return the rows, from `row` to `end`, that a face may touch; none of an unseen one."""
    if not shapes.seen[k]:
        return row, row
    top = max(row, int(max(shapes.boxes[k, 1], -1e6)))
    return top, min(end, int(min(shapes.boxes[k, 3], 1e6)))


@uncounted
def draw_faces(
    shapes: Outlines,
    extent: tuple[int, int, int, int, int],
    scene: Scene,
    channel: Channel,
    buffers: Buffers,
    light: Row,
    gain: Row,
) -> None:
    """Blend the faces into a strip of rows, (rows * width,) [grey].

    `extent` is row and column of the strip's first pixel, its width, and the window's columns.
    `gain` is the light on the faces if it is not the usual daylight, else empty.
    """
    row, start, width, x0, x1 = extent
    height = light.shape[0] // width
    drawn = 0
    for k in range(shapes.seen.shape[0]):
        top, end = _rows_in_strip(shapes, k, row, row + height)
        drawn += top < end
    ground = light
    if drawn > 1:  # a single face finds the ground unchanged
        ground = buffers.ground[: light.shape[0]]
        rows.copy(light, ground)
    shape = height, width
    lit, bare = light.reshape(shape), ground.reshape(shape)
    daylight = gain.reshape(height, gain.shape[0] // height)
    for k in range(shapes.seen.shape[0]):
        top, end = _rows_in_strip(shapes, k, row, row + height)
        if top >= end:
            continue
        first, last = top - row, end - row
        _draw_face(
            (shapes.maps[k], shapes.edges[k], scene.layout[k]),
            (top, start, x0, x1),
            (scene.intrinsics, scene.fog),
            (channel.box_texture, channel.attenuation, channel.veil),
            lit[first:last],
            bare[first:last],
            daylight[first:last],
        )
