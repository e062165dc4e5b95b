"""What of the bodies is in view of a camera: their places in its axes, and where they are drawn."""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.camera.bodies import BOX, CAPSULE, WORLD, Paints, Shapes
from seamark.sim.camera.lighting import SKY, SUN, Lighting
from seamark.sim.numerics.arrays import Array, Integers

NEAR_M = 1e-3  # along the optical axis; what is nearer is not drawn
CORNERS = 20  # of a box that the near plane cuts, at most
_ROUNDING = 1e-3  # relative; more than float32 loses of a depth or of a radius
_LEAST_CURVED = 1e-15  # coefficient of a silhouette that ends on both sides
LINES = 12  # of the outline of its corners; a longer one is widened to its window
NARROW_PX = 32  # rows of windows that are not wider are drawn whole

MARKS = 4  # of a body: one for each face that a pixel may show

Triple = tuple[np.float32, np.float32, np.float32]
Rows = NDArray[np.float32]


class Body(NamedTuple):
    """A body as a camera sees it; vectors are in the axes of the body.

    Numbers only: to hand arrays to what is inlined into loops over pixels counts their references.
    """

    ray_x: Triple  # component of rays by image column, image row, and along the optical axis
    ray_y: Triple
    ray_z: Triple
    camera: Triple  # [m]
    half: Triple  # [m]
    sun: Triple  # daylight by normal
    lamp: Triple  # [m]
    beam: Triple  # where the lamp points
    side: Triple  # which face along each axis is towards the camera: 1 or -1
    # Of these faces: texel across and down at the middle of the face, and per metre.
    across: Triple
    across_slope: Triple
    down: Triple
    down_slope: Triple
    offset: Triple  # in the texture
    columns: Triple
    rows: Triple
    albedo: np.float32  # times 255
    mark: np.float32  # of its pixels
    textured: bool


_ALBEDO, _MARK, _TEXTURED, _NUMBERS = 48, 49, 50, 51


class Sight(NamedTuple):
    """Where a camera is and what it looks along."""

    axes: Array  # (3, 3) image right, image down, optical axis, in world axes
    centre: Array  # (3,) [m] NED


class Seen(NamedTuple):
    """The bodies that are in view."""

    kind: Integers  # (n,)
    numbers: Rows  # (n, 51) the fields of `Body`
    window: Integers  # (n, 4) [px] x0, y0, x1, y1
    nearest: Rows  # (n,) [m] depth that no point of it comes below
    lines: Array  # (n, LINES, 3) sides of the outline, see `_bounds`
    edges: Integers  # (n,) number of sides; none if the window is the outline
    silhouette: Array  # (n, 6) of what is round, see `_silhouette`; zeros of a box
    number: int


@njit(cache=True, nogil=True, error_model="numpy")
def attached_axes(
    rotation: Array, position: Array, link: int, point: Array, turn: Array
) -> tuple[Array, Array]:
    """Return axes (3, 3) by column and origin (3,) [m] in the world of what is on a link."""
    axes, origin = turn.copy(), point.copy()
    if link != WORLD:
        for i in range(3):
            origin[i] = position[link, i]
            for j in range(3):
                origin[i] += rotation[link, i, j] * point[j]
                axes[i, j] = 0.0
                for k in range(3):
                    axes[i, j] += rotation[link, i, k] * turn[k, j]
    return axes, origin


@njit(cache=True, nogil=True, error_model="numpy")
def sight_along(axes: Array, origin: Array) -> Sight:
    """Return the sight of a camera that looks along the x axis, with the z axis down the image."""
    rows = np.empty((3, 3))
    for i in range(3):
        rows[0, i], rows[1, i], rows[2, i] = axes[i, 1], axes[i, 2], axes[i, 0]
    return Sight(rows, origin)


@njit(cache=True, nogil=True, error_model="numpy")
def bodies_seen(
    sight: Sight,
    placed: tuple[Array, Array],
    shapes: Shapes,
    paints: Paints,
    lighting: Lighting,
    intrinsics: Array,
    window: tuple[int, int, int, int],
) -> Seen:
    """Return the bodies that may be seen in a window of the image, or one pixel around it."""
    n = shapes.kind.shape[0]
    seen = Seen(
        np.empty(n, np.int64),
        np.zeros((n, _NUMBERS), np.float32),
        np.empty((n, 4), np.int64),
        np.empty(n, np.float32),
        np.empty((n, LINES, 3)),
        np.zeros(n, np.int64),
        np.zeros((n, 6)),
        0,
    )
    corners, points = np.empty((8, 3)), np.empty((CORNERS, 2))
    count = 0
    for k in range(n):
        axes, origin = attached_axes(
            placed[0], placed[1], shapes.link[k], shapes.centre[k], shapes.turn[k]
        )
        _corners(shapes.kind[k], shapes.half[k], axes, origin, sight, corners)
        found = _image_points(corners, intrinsics, points)
        if found < 3 or not _window(points[:found], window, seen.window[count]):
            continue
        seen.nearest[count] = _nearest(corners)
        wide = seen.window[count, 2] - seen.window[count, 0] > NARROW_PX
        seen.edges[count] = _outline(points[:found], seen.lines[count]) if wide else 0
        seen.kind[count] = shapes.kind[k]
        numbers = seen.numbers[count]
        _place(shapes.half[k], axes, origin, sight, lighting, numbers)
        if shapes.kind[k] != BOX:
            _silhouette(numbers, intrinsics, seen.silhouette[count])
        numbers[_ALBEDO] = 255.0 * paints.albedo[k]
        numbers[_MARK] = MARKS * (count + 1)
        if paints.layout[k, 0, 1] > 0:
            _texture(shapes.half[k], paints.layout[k], numbers)
        count += 1
    return Seen(
        seen.kind,
        seen.numbers,
        seen.window,
        seen.nearest,
        seen.lines,
        seen.edges,
        seen.silhouette,
        count,
    )


@njit(cache=True, nogil=True, error_model="numpy")
def _corners(
    kind: int, half: Array, axes: Array, origin: Array, sight: Sight, corners: Array
) -> None:
    """Write the corners (8, 3) of the box around a body in the axes of the camera [m]."""
    along = half[0] + (half[1] if kind == CAPSULE else 0.0)
    for k in range(8):
        a = along if k & 1 else -along
        b = half[1] if k & 2 else -half[1]
        c = half[2] if k & 4 else -half[2]
        for i in range(3):
            corners[k, i] = 0.0
        for j in range(3):
            way = origin[j] + axes[j, 0] * a + axes[j, 1] * b + axes[j, 2] * c - sight.centre[j]
            for i in range(3):
                corners[k, i] += sight.axes[i, j] * way


@njit(cache=True, nogil=True, error_model="numpy")
def _nearest(corners: Array) -> float:
    """Return a depth [m] a little below that of every corner; 0 if one is behind the near plane."""
    depth = corners[0, 2]
    for k in range(1, 8):
        depth = min(depth, corners[k, 2])
    return 0.0 if depth < NEAR_M else depth * (1.0 - _ROUNDING)


@njit(cache=True, nogil=True, error_model="numpy")
def _silhouette(numbers: Rows, intrinsics: Array, out: Array) -> None:
    """Write the quadratic form, in image column and row, of rays that meet an endless cylinder.

    It lies along x, and a ray d from the camera o passes its axis at a distance below the radius r
    where r^2 (dy^2 + dz^2) > (oy dz - oz dy)^2: a u^2 + 2 (b v + c) u + (d v^2 + 2 e v + f) > 0.
    What is round is inside such a cylinder.
    """
    f, u0, v0 = intrinsics[0], intrinsics[1], intrinsics[2]
    oy, oz, radius = float(numbers[10]), float(numbers[11]), float(numbers[13])
    square = radius * radius * (1.0 + _ROUNDING)
    y, z = np.empty(3), np.empty(3)  # of the ray of a pixel: per column, per row, at (0, 0)
    for row, first in ((y, 3), (z, 6)):
        row[0], row[1] = numbers[first] / f, numbers[first + 1] / f
        row[2] = numbers[first + 2] - row[0] * u0 - row[1] * v0
    at = 0
    for i in range(3):
        for j in range(i, 3):
            cross = (oy * z[i] - oz * y[i]) * (oy * z[j] - oz * y[j])
            out[at] = square * (y[i] * y[j] + z[i] * z[j]) - cross
            at += 1


@njit(cache=True, nogil=True, error_model="numpy")
def _image_points(corners: Array, intrinsics: Array, points: Array) -> int:
    """Write the image points [px] of a box in front of the near plane; return how many."""
    count = 0
    for k in range(8):
        if corners[k, 2] >= NEAR_M:
            points[count, 0] = intrinsics[0] * corners[k, 0] / corners[k, 2] + intrinsics[1]
            points[count, 1] = intrinsics[0] * corners[k, 1] / corners[k, 2] + intrinsics[2]
            count += 1
    if count in (0, 8):
        return count
    for k in range(8):
        for bit in (1, 2, 4):
            other = k | bit
            if k & bit or (corners[k, 2] >= NEAR_M) == (corners[other, 2] >= NEAR_M):
                continue
            share = (NEAR_M - corners[k, 2]) / (corners[other, 2] - corners[k, 2])
            x = corners[k, 0] + share * (corners[other, 0] - corners[k, 0])
            y = corners[k, 1] + share * (corners[other, 1] - corners[k, 1])
            points[count, 0] = intrinsics[0] * x / NEAR_M + intrinsics[1]
            points[count, 1] = intrinsics[0] * y / NEAR_M + intrinsics[2]
            count += 1
    return count


@njit(cache=True, nogil=True, error_model="numpy")
def _window(points: Array, window: tuple[int, int, int, int], out: Integers) -> bool:
    """Write the pixels around points, within one of the window; False if there are none."""
    low_x, low_y, high_x, high_y = 1e9, 1e9, -1e9, -1e9
    for k in range(points.shape[0]):
        low_x, high_x = min(low_x, points[k, 0]), max(high_x, points[k, 0])
        low_y, high_y = min(low_y, points[k, 1]), max(high_y, points[k, 1])
    # A pixel reaches half a pixel from its centre; the rest is for rounding.
    out[0] = int(max(np.floor(low_x - 0.6), window[0] - 1.0))
    out[1] = int(max(np.floor(low_y - 0.6), window[1] - 1.0))
    out[2] = int(min(np.ceil(high_x + 0.6) + 1.0, window[2] + 1.0))
    out[3] = int(min(np.ceil(high_y + 0.6) + 1.0, window[3] + 1.0))
    return bool(out[0] < out[2] and out[1] < out[3])


@njit(cache=True, nogil=True, error_model="numpy")
def _outline(points: Array, lines: Array) -> int:
    """Write the sides of the convex hull of points (n, 2); return how many.

    None if it has more than LINES or no area. Sorts the points. By Andrew's monotone chain.
    """
    n = points.shape[0]
    for k in range(1, n):
        x, y = points[k, 0], points[k, 1]
        at = k
        while at > 0 and (
            points[at - 1, 0] > x or (points[at - 1, 0] == x and points[at - 1, 1] > y)
        ):
            points[at, 0], points[at, 1] = points[at - 1, 0], points[at - 1, 1]
            at -= 1
        points[at, 0], points[at, 1] = x, y
    hull = np.empty((2 * CORNERS, 2))
    size = 0
    for k in range(n):
        size = _chained(hull, size, 0, points[k])
    start = size - 1
    for k in range(n - 2, -1, -1):
        size = _chained(hull, size, start, points[k])
    size -= 1  # the first point again
    return _bounds(hull[:size], lines)


@njit(cache=True, nogil=True, error_model="numpy")
def _chained(hull: Array, size: int, start: int, point: Array) -> int:
    """Add a point to a chain that began at `start` and turns one way only; return its new end."""
    x, y = point[0], point[1]
    while size >= start + 2:
        ax, ay = hull[size - 2, 0], hull[size - 2, 1]
        bx, by = hull[size - 1, 0], hull[size - 1, 1]
        if (bx - ax) * (y - ay) - (by - ay) * (x - ax) > 0.0:
            break
        size -= 1
    hull[size, 0], hull[size, 1] = x, y
    return size + 1


@njit(cache=True, nogil=True, error_model="numpy")
def _bounds(hull: Array, lines: Array) -> int:
    """Write the columns that the sides of a hull leave in a row: which end, at row 0, per row."""
    count = hull.shape[0]
    if count < 3 or count > LINES:
        return 0
    for k in range(count):
        n = (k + 1) % count
        dx, dy = hull[n, 0] - hull[k, 0], hull[n, 1] - hull[k, 1]
        slope = dx / dy if abs(dy) > 1e-3 else 0.0
        lines[k, 0] = 0.0 if abs(dy) <= 1e-3 else (1.0 if dy > 0.0 else -1.0)
        # A pixel reaches half a pixel from its centre, across and down; the rest is for rounding.
        slack = 0.6 + 0.6 * abs(slope)
        lines[k, 1] = hull[k, 0] - slope * hull[k, 1] + lines[k, 0] * slack
        lines[k, 2] = slope
    return int(count)


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def columns_seen(seen: Seen, k: int, row: int) -> tuple[int, int]:
    """Return the columns that a body may touch in a row: the first, and the one after the last."""
    first, last = float(seen.window[k, 0]), float(seen.window[k, 2])
    for i in range(seen.edges[k]):
        bound = seen.lines[k, i, 1] + seen.lines[k, i, 2] * row
        if seen.lines[k, i, 0] > 0.0:
            last = min(last, bound + 1.0)
        elif seen.lines[k, i, 0] < 0.0:
            first = max(first, bound)
    form = seen.silhouette
    if form[k, 0] < -_LEAST_CURVED:
        middle = -(form[k, 1] * row + form[k, 2]) / form[k, 0]
        rest = (form[k, 3] * row + 2.0 * form[k, 4]) * row + form[k, 5]
        square = middle * middle - rest / form[k, 0]
        reach = np.sqrt(max(square, 0.0)) + 1.0
        first = max(first, min(middle - reach, last))
        last = min(last, max(middle + reach + 1.0, first))
    return int(np.floor(first)), int(np.ceil(last))


@njit(cache=True, nogil=True, error_model="numpy")
def _place(
    half: Array, axes: Array, origin: Array, sight: Sight, lighting: Lighting, numbers: Rows
) -> None:
    """Write where camera, light and lamp are in the axes of a body."""
    for i in range(3):
        towards, sun, lamp, beam = 0.0, 0.0, 0.0, 0.0
        for j in range(3):
            towards += axes[j, i] * (sight.centre[j] - origin[j])
            sun += axes[j, i] * SUN[j]
            lamp += axes[j, i] * (lighting.place[j] - origin[j])
            beam += axes[j, i] * lighting.beam[j]
        for row in range(3):
            slope = 0.0
            for j in range(3):
                slope += axes[j, i] * sight.axes[row, j]
            numbers[3 * i + row] = slope
        numbers[9 + i], numbers[12 + i] = towards, half[i]
        numbers[15 + i] = sun * SKY
        numbers[18 + i], numbers[21 + i] = lamp, beam
        numbers[24 + i] = 1.0 if towards > 0.0 else -1.0


@njit(cache=True, nogil=True, error_model="numpy")
def _texture(half: Array, layout: NDArray[np.int32], numbers: Rows) -> None:
    """Write how places on the faces that face the camera map to texels.

    One reads along x on the faces along y and z, along y on those along x; down is z, but y on the
    faces along z. What is seen from its other side is mirrored.
    """
    numbers[_TEXTURED] = 1.0
    for axis in range(3):
        positive = numbers[24 + axis] > 0.0
        offset, columns, rows = layout[2 * axis + (0 if positive else 1)]
        mirrored = positive if axis == 0 else not positive
        across = half[1] if axis == 0 else half[0]
        down = half[1] if axis == 2 else half[2]
        slope, fall = 0.5 * columns / across, 0.5 * rows / down
        if axis == 2:
            mirrored = False
            fall = -fall if positive else fall
        numbers[27 + axis], numbers[33 + axis] = 0.5 * columns - 0.5, 0.5 * rows - 0.5
        numbers[30 + axis], numbers[36 + axis] = -slope if mirrored else slope, fall
        numbers[39 + axis], numbers[42 + axis], numbers[45 + axis] = offset, columns, rows


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def body_at(n: Rows, k: int) -> Body:
    """Return one of the bodies that are seen."""
    return Body(
        (n[k, 0], n[k, 1], n[k, 2]),
        (n[k, 3], n[k, 4], n[k, 5]),
        (n[k, 6], n[k, 7], n[k, 8]),
        (n[k, 9], n[k, 10], n[k, 11]),
        (n[k, 12], n[k, 13], n[k, 14]),
        (n[k, 15], n[k, 16], n[k, 17]),
        (n[k, 18], n[k, 19], n[k, 20]),
        (n[k, 21], n[k, 22], n[k, 23]),
        (n[k, 24], n[k, 25], n[k, 26]),
        (n[k, 27], n[k, 28], n[k, 29]),
        (n[k, 30], n[k, 31], n[k, 32]),
        (n[k, 33], n[k, 34], n[k, 35]),
        (n[k, 36], n[k, 37], n[k, 38]),
        (n[k, 39], n[k, 40], n[k, 41]),
        (n[k, 42], n[k, 43], n[k, 44]),
        (n[k, 45], n[k, 46], n[k, 47]),
        n[k, 48],
        n[k, 49],
        n[k, 50] > np.float32(0.0),
    )
