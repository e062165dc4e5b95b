"""Draws a window of the picture row by row: seabed, box faces, water, noise."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.camera import rows
from sim.camera.geometry import faces_seen, look, plane_map, project
from sim.camera.seabed import TEXEL_M
from sim.elementary import exp

NOISE_LENGTH = 1 << 18  # [samples] of the bank, a power of two
Array = NDArray[np.float64]
Row = NDArray[np.float32]
Texels = NDArray[np.int32]
Window = tuple[int, int, int, int]
Law = tuple[int, float, float, float, float]

_F = np.float32
_NODE = rows.NODE


@njit(cache=True, nogil=True, error_model="numpy")
def noise_start(seed: int, frame: int, row: int, channel: int) -> int:
    """Return where in the noise bank a row starts: SplitMix64's finaliser over four integers."""
    h = np.uint64(seed) * np.uint64(0x9E3779B97F4A7C15)
    h = h ^ (np.uint64(frame) + np.uint64(1)) * np.uint64(0xBF58476D1CE4E5B9)
    h = h ^ (np.uint64(row) * np.uint64(4) + np.uint64(channel)) * np.uint64(0x94D049BB133111EB)
    h = (h ^ (h >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    h = (h ^ (h >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    h = h ^ (h >> np.uint64(31))
    return int(h & np.uint64(NOISE_LENGTH - 1))


@njit(cache=True, nogil=True, error_model="numpy")
def _seabed_map(
    depth: float, rotation: Array, centre: Array, intrinsics: Array, g: Array
) -> tuple[int, int]:
    """Write the seabed's map in texels around the one below the camera; return that texel."""
    north = np.floor(centre[0] / TEXEL_M)
    east = np.floor(centre[1] / TEXEL_M)
    plane = np.zeros(12)
    plane[0] = north * TEXEL_M
    plane[1] = east * TEXEL_M
    plane[2] = depth
    plane[3] = TEXEL_M
    plane[7] = TEXEL_M
    plane_map(plane, rotation, centre, intrinsics, g)
    for k in range(3):
        g[0, k] -= 0.5 * g[2, k]
        g[1, k] -= 0.5 * g[2, k]
    return int(north), int(east)


@njit(cache=True, nogil=True, error_model="numpy")
def _nodes(g: Array, intrinsics: Array, water: Law, window: Window, out: Row) -> None:
    """Write the seabed's transmission at the nodes (row, column) that the window needs."""
    f = intrinsics[0]
    for j in range(window[1] // _NODE, (window[3] - 1) // _NODE + 2):
        v = float(j * _NODE)
        y = (v - intrinsics[2]) / f
        for i in range(window[0] // _NODE, (window[2] - 1) // _NODE + 2):
            u = float(i * _NODE)
            x = (u - intrinsics[1]) / f
            depth = 1.0 / max(g[2, 0] * u + g[2, 1] * v + g[2, 2], 1e-3)
            if water[0] == 1:
                out[j, i] = exp(-min((water[1] * depth) ** 2, 40.0))
            else:
                out[j, i] = exp(-min(water[1] * depth * np.sqrt(1.0 + x * x + y * y), 40.0))


@njit(cache=True, nogil=True, error_model="numpy")
def _row_of(g: Array, v: float, line: Row) -> None:
    """Write a plane's map along row v: value at column 0 and change per column."""
    for k in range(3):
        line[k] = g[k, 1] * v + g[k, 2]
        line[3 + k] = g[k, 0]


@njit(cache=True, nogil=True, error_model="numpy")
def _outline(
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
def _span(edges: Array, y: float, low: int, high: int, slack: float) -> tuple[int, int]:
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
def _cover(edges: Array, y: float, x0: int, x1: int, share: Row) -> None:
    """Write the coverage of the columns x0..x1: 1 inside, computed along the edges alone."""
    inner0, inner1 = _span(edges, y, x0, x1, -0.75)
    if inner1 <= inner0:
        rows.coverage(edges, y, x0, share)
        return
    share[inner0 - x0 : inner1 - x0] = _F(1.0)
    if inner0 > x0:
        rows.coverage(edges, y, x0, share[: inner0 - x0])
    if inner1 < x1:
        rows.coverage(edges, y, inner1, share[inner1 - x0 :])


@njit(cache=True, nogil=True, error_model="numpy")
def _draw_face(
    part: tuple[Row, Array, tuple[int, int, int], int, int],
    row: int,
    buffers: Row,
    index: Texels,
    intrinsics: Array,
    water: Law,
    quads: Texels,
) -> None:
    """Blend one face into the row. `part`: its line (6,), edges, place in the skin and span."""
    line, edges, place, x0, x1 = part
    n = x1 - x0
    texels = index[:n]
    fu = buffers[2, :n]
    fv = buffers[3, :n]
    light = buffers[4, :n]
    depth = buffers[5, :n]
    share = buffers[6, :n]
    rows.face_places(line, x0, place, texels, fu, fv, depth)
    rows.fetch(quads, texels)
    rows.sample(texels, fu, fv, light)
    y = (row - intrinsics[2]) / intrinsics[0]
    rows.face_transmission(depth, x0, (intrinsics[0], intrinsics[1]), y, water[:2], share)
    rows.attenuate(light, share, water[2])
    _cover(edges, float(row), x0, x1, share)
    rows.blend(buffers[0, x0:x1], buffers[1, x0:x1], light, share)


@njit(cache=True, nogil=True, error_model="numpy")
def _face_maps(
    box: tuple[Array, Texels],
    rotation: Array,
    centre: Array,
    intrinsics: Array,
    maps: Array,
    edges: Array,
    bounds: Array,
) -> NDArray[np.bool_]:
    """Write maps in texels, edges and bounding boxes; return which faces are to be drawn."""
    faces, layout = box
    seen = faces_seen(faces, centre)
    for k in range(faces.shape[0]):
        if not seen[k]:
            continue
        seen[k] = plane_map(faces[k], rotation, centre, intrinsics, maps[k]) and _outline(
            faces[k], rotation, centre, intrinsics, edges[k], bounds[k]
        )
        for c in range(3):
            maps[k, 0, c] = maps[k, 0, c] * layout[k, 1] - 0.5 * maps[k, 2, c]
            maps[k, 1, c] = maps[k, 1, c] * layout[k, 2] - 0.5 * maps[k, 2, c]
    return seen


@njit(cache=True, nogil=True, error_model="numpy")
def _between(nodes: Row, row: int, x0: int, x1: int, out: Row) -> None:
    """Write the transmission of a row at its nodes' columns, from the nodes above and below."""
    j = row // _NODE
    share = _F((row - j * _NODE) / _NODE)
    for i in range(x0 // _NODE, (x1 - 1) // _NODE + 2):
        out[i] = nodes[j, i] + share * (nodes[j + 1, i] - nodes[j, i])


@njit(cache=True, nogil=True, error_model="numpy")
def _draw_ground(
    line: Row,
    x0: int,
    ground: tuple[Texels, int, int, float],
    transmission: Row,
    places: tuple[Texels, Row, Row],
    out: Row,
) -> None:
    """Write a row of seabed through the water. `ground`: tile, its shift north and east, veil."""
    tile, north, east, veil = ground
    texels, fu, fv = places
    rows.seabed_places(line, x0, north, east, texels, fu, fv)
    rows.fetch(tile, texels)
    rows.sample(texels, fu, fv, out)
    rows.spread(transmission, x0, fu)
    rows.attenuate(out, fu, veil)


@njit(cache=True, nogil=True, error_model="numpy")
def draw(
    pose: Array,
    optics: tuple[Array, Array],
    scene: tuple[Texels, float, Array, Texels, Texels],
    water: Law,
    grain: tuple[Row, int, int, int],
    window: Window,
    work: tuple[Row, Texels, Row],
    out: NDArray[np.uint8],
) -> None:
    """Draw the window x0, y0, x1, y1 into `out` (H, W) uint8.

    Parameters
    ----------
    optics : tuple
        intrinsics (3,), mount (3,).
    scene : tuple
        seabed tile, depth of the seabed [m], faces (5, 12), the faces' packed textures and where
        each lies in them (5, 3).
    water : tuple
        law (0 beer, 1 uwsim), attenuation, veil [grey], read variance [grey^2], shot gain [grey].
    grain : tuple
        noise bank, noise seed, frame, channel.
    work : tuple
        buffers (7, W) float32, index (W,) int32, nodes (rows, columns) float32.
    """
    intrinsics, mount = optics
    tile, depth, faces, skin, layout = scene
    noise, seed, frame, channel = grain
    buffers, index, nodes = work
    x0, y0, x1, y1 = window
    rotation = np.empty((3, 3))
    centre = np.empty(3)
    look(pose, mount, rotation, centre)
    g = np.empty((3, 3))
    texel = _seabed_map(depth, rotation, centre, intrinsics, g)
    _nodes(g, intrinsics, water, window, nodes)
    count = faces.shape[0]
    maps = np.empty((count, 3, 3))
    edges = np.empty((count, 4, 3))
    boxes = np.empty((count, 4))
    seen = _face_maps((faces, layout), rotation, centre, intrinsics, maps, edges, boxes)
    line = np.empty(6, np.float32)
    ground = (tile, texel[0] - 4096, texel[1] - 4096, water[2])
    total = buffers[0, x0:x1]
    places = (index[: x1 - x0], buffers[2, : x1 - x0], buffers[3, : x1 - x0])
    between = np.empty(nodes.shape[1], np.float32)
    for row in range(y0, y1):
        _row_of(g, float(row), line)
        _between(nodes, row, x0, x1, between)
        _draw_ground(line, x0, ground, between, places, total)
        copied = False
        for k in range(count):
            if not seen[k] or row < boxes[k, 1] or row >= boxes[k, 3]:
                continue
            a, b = _span(edges[k], float(row), x0, x1, 0.75)
            if b <= a:
                continue
            if not copied:
                buffers[1, x0:x1] = total
                copied = True
            _row_of(maps[k], float(row), line)
            part = (line, edges[k], (layout[k, 0], layout[k, 1], layout[k, 2]), a, b)
            _draw_face(part, row, buffers, index, intrinsics, water, skin)
        start = noise_start(seed, frame, row, channel) + x0
        rows.expose(total, noise[start : start + x1 - x0], water[3], water[4], out[row, x0:x1])
