"""The box's faces: their outlines, what of a row they cover, and their share of its light."""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.camera import rows
from sim.camera.geometry import Line, faces_seen, plane_map, project, row_of
from sim.camera.scene import Channel, Scene, Work
from sim.lanes import (
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
    whole,
)

Array = NDArray[np.float64]
Row = NDArray[np.float32]
Rows = NDArray[np.float32]
Texels = NDArray[np.int32]

LANES = 8  # pixels of one vector
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


@njit(cache=True, nogil=True, error_model="numpy")
def face_light(
    skin: Texels,
    line: Line,
    x0: int,
    layout: tuple[int, int, int],
    ray: tuple[float, float, float],
    water: tuple[bool, float],
    out: Rows,
) -> None:
    """Write light [grey] and transmission of a face along a row, (2, n); its edges are repeated.

    `layout` is the face in the skin: offset, columns, rows. `ray` is focal length and principal
    column [px] and the row's slope in the camera frame, `water` whether UWSim's fog, and c.

    exp(x) = p(x / 64)^64 with a polynomial p: for x > -10 the relative error is below 1e-5.
    """
    offset, columns, height = layout
    a0, b0, w0 = lanes(line[0]), lanes(line[1]), lanes(line[2])
    a1, b1, w1 = lanes(line[3]), lanes(line[4]), lanes(line[5])
    right = lanes(_F(columns) - _F(1.001))
    bottom = lanes(_F(height) - _F(1.001))
    inverse, middle = lanes(1.0 / ray[0]), lanes(ray[1])
    square, c = lanes(1.0 + ray[2] * ray[2]), lanes(water[1])
    zero, one, steps = lanes(0.0), lanes(1.0), load(rows.STEPS, 0, 0)
    for block in range(out.shape[1] // WIDTH):
        column = lanes(float(x0 + block * WIDTH)) + steps
        z = one / larger(w0 + w1 * column, lanes(1e-3))
        u = smaller(larger((a0 + a1 * column) * z, zero), right)
        v = smaller(larger((b0 + b1 * column) * z, zero), bottom)
        iu, iv = whole(u), whole(v)
        four = gather(skin, places(offset) + (iv * places(columns) + iu))
        store(out, 0, block * WIDTH, rows.mixture(four, u - real(iu), v - real(iv)))
        x = (column - middle) * inverse
        path = c * z
        path = path * path if water[0] else path * root(square + x * x)
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
        store(out, 1, block * WIDTH, p * p)


@njit(cache=True, nogil=True, error_model="numpy")
def coverage(edges: NDArray[np.float64], y: float, x0: int, out: Row) -> None:
    """Write how much of each pixel lies inside a convex polygon: exact along straight edges.

    The length of `out` is a multiple of LANES, so that short spans are vectors as well.

    Parameters
    ----------
    edges : (4, 3)
        Outward unit normal and offset of each edge [px]: distance = nx u + ny v + offset.
    y : float
        Row.
    """
    rows.fill(1.0, out)
    first = np.int32(x0)
    for k in range(edges.shape[0]):
        nx = _F(edges[k, 0])
        base = _F(edges[k, 1] * y + edges[k, 2])
        a = max(abs(nx), _F(0.02))
        b = max(_F(abs(edges[k, 1])), _F(0.02))
        s = (a + b) * _F(0.5)
        m = abs(a - b) * _F(0.5)
        scale = _F(0.5) / (a * b)
        farthest = max(nx * _F(first), nx * _F(np.int32(first + np.int32(out.shape[0] - 1))))
        if -(base + farthest) > s:  # the whole span is inside this edge: every factor is 1
            continue
        for block in range(out.shape[0] // LANES):
            piece = out[block * LANES : (block + 1) * LANES]
            start = np.int32(first + np.int32(block * LANES))
            for q in range(LANES):
                t = -(base + nx * _F(np.int32(start + np.int32(q))))
                # Second difference of t^2/2: the area a half-plane cuts from a unit square.
                q1 = max(t + s, _F(0.0))
                q2 = max(t + m, _F(0.0))
                q3 = max(t - m, _F(0.0))
                q4 = max(t - s, _F(0.0))
                area = ((q1 * q1 - q2 * q2) - (q3 * q3 - q4 * q4)) * scale
                inside = min(max(area, _F(0.0)), _F(1.0))
                piece[q] = piece[q] * (_F(1.0) if t > s else inside)


@njit(cache=True, nogil=True, error_model="numpy")
def blend(total: Row, ground: Row, light: Row, cover: Row) -> None:
    """Add a face's share of each pixel to the row, in place of the ground's."""
    for q in range(total.shape[0]):
        total[q] = total[q] + cover[q] * (light[q] - ground[q])


@njit(cache=True, nogil=True, error_model="numpy")
def _cover(edges: Array, y: float, x0: int, x1: int, share: Row) -> None:
    """Write the coverage of the columns from x0 on: 1 inside, computed along the edges alone.

    `share` is longer than x1 - x0 by less than rows.CHUNK; behind x1 it becomes zero.
    """
    inner0, inner1 = span(edges, y, x0, x1, -0.75)
    n = share.shape[0]
    if inner1 <= inner0:
        coverage(edges, y, x0, share)
        return
    # To whole vectors: further in, `coverage` writes exactly 1, further out exactly 0.
    left = min((inner0 - x0 + LANES - 1) // LANES * LANES, n)
    right = (inner1 - x0) // LANES * LANES
    if left >= right:
        coverage(edges, y, x0, share)
        return
    end = min((x1 - x0 + LANES - 1) // LANES * LANES, n)
    coverage(edges, y, x0, share[:left])
    rows.fill(1.0, share[left:right])
    coverage(edges, y, x0 + right, share[right:end])
    rows.fill(0.0, share[end:])


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
def _draw_face(
    shape: tuple[Array, Array, Texels],
    place: tuple[int, int, int, int, int],
    lens: tuple[Array, bool],
    channel: tuple[Texels, float, float],
    work: Work,
    light: Row,
    ground: Row,
    gain: Row,
) -> None:
    """Blend one face into a strip of rows; `ground` is the strip before all faces.

    `shape` is its map, edges and place in the skin, `place` that of `draw_faces` without rows
    beside the face, `lens` intrinsics and law, `channel` skin, attenuation and veil.
    """
    pixel_map, edges, layout = shape
    top, start, width, x0, x1 = place
    skin, attenuation, veil = channel
    f, u0, v0 = lens[0][0], lens[0][1], lens[0][2]
    water = (lens[1], attenuation)
    corner = (layout[0], layout[1], layout[2])
    for r in range(light.shape[0] // width):
        v = float(top + r)
        a, b = span(edges, v, x0, x1, 0.75)
        if b <= a:
            continue
        n = (b - a + rows.CHUNK - 1) // rows.CHUNK * rows.CHUNK
        drawn = work.face[: 2 * n].reshape(2, n)
        share = work.share[:n]
        ray = (f, u0, (v - v0) / f)
        face_light(skin, row_of(pixel_map, v), a, corner, ray, water, drawn)
        _cover(edges, v, a, b, share)
        # What a short row has too much is cut off, or it would reach into the next row.
        begin = r * width + a - start
        end = min(begin + n, (r + 1) * width)
        radiance, transmission = drawn[0], drawn[1]
        if gain.shape[0]:
            rows.shine(radiance, gain[begin:end], transmission, veil)
        else:
            rows.arrive(radiance, transmission, veil)
        blend(light[begin:end], ground[begin:end], radiance, share)


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
    copied = False
    for k in range(shapes.seen.shape[0]):
        if not shapes.seen[k]:
            continue
        top = max(row, int(max(shapes.boxes[k, 1], -1e6)))
        end = min(row + height, int(min(shapes.boxes[k, 3], 1e6)))
        if top >= end:
            continue
        if not copied:
            rows.copy(light, work.ground[: light.shape[0]])
            copied = True
        part = (top - row) * width, (end - row) * width
        _draw_face(
            (shapes.maps[k], shapes.edges[k], scene.layout[k]),
            (top, start, width, x0, x1),
            (scene.intrinsics, scene.fog),
            (channel.skin, channel.attenuation, channel.veil),
            work,
            light[part[0] : part[1]],
            work.ground[part[0] : part[1]],
            gain[part[0] : part[1]],
        )
