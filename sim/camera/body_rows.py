"""Draws the bodies into rows of the image, in front of and behind each other and the seabed.

First the middle of each pixel: its depth, its radiance, and a mark that names the face it shows.
Where the mark changes between neighbours there is an edge: those pixels are the mean of sixteen
places in them. An edge through a pixel that is straight there and longer than the pixel always lies
between its middle and that of a neighbour.
"""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.camera import rows
from seamark.sim.camera.hits import hit, mark, ray, tone
from seamark.sim.camera.instant import Instant
from seamark.sim.camera.lighting import arriving, glow
from seamark.sim.camera.open_seabed import LEAST, Ground
from seamark.sim.camera.rows import CHUNK
from seamark.sim.camera.scene import STRIP
from seamark.sim.camera.sightings import MARKS, body_at, columns_seen
from seamark.sim.numerics.arrays import Integers
from seamark.sim.numerics.simd import (
    ALL_LANES,
    WIDTH,
    f32x16,
    greater_bits,
    horizontal_sum,
    load,
    maximum,
    minimum,
    select_greater,
    store,
)
from seamark.sim.numerics.uncounted import uncounted

if TYPE_CHECKING:
    from seamark.sim.numerics.simd import F32x16

Plane = NDArray[np.float32]
Texels = NDArray[np.uint16]
Array = NDArray[np.float64]

NEIGHBOURS = 4  # of a pixel
_ACROSS, _DOWN = np.array([-1, 1, 0, 0]), np.array([0, 0, -1, 1])
_F = np.float32
HALO = 16  # [px] columns to both sides of a strip; a row above and one below suffice
# Places in a pixel: one in each of sixteen columns and rows (van der Corput).
_ORDER = (0, 8, 4, 12, 2, 10, 6, 14, 1, 9, 5, 13, 3, 11, 7, 15)
PLACES = np.array(
    [[(k + 0.5) / 16 - 0.5 for k in range(WIDTH)], [(k + 0.5) / 16 - 0.5 for k in _ORDER]],
    np.float32,
)


class Edges(NamedTuple):
    """Pixels of a strip that show more than one thing."""

    row: Integers  # (n,) and
    column: Integers  # (n,) from the strip's first pixel on
    seabed: Plane  # (n,) [grey] what reaches the camera of the seabed there


class Layers(NamedTuple):
    """What the pixels of a strip with its halo show."""

    depth: Plane  # (n,) [m] along the optical axis
    tone: Plane  # (n,) [grey] radiance there
    mark: Plane  # (n,) 0 for the seabed
    span: Integers  # (rows, 2) columns that bodies may touch
    edges: Edges
    changed: Integers  # (n / 16,) which pixels are at an edge, as bits; in the span alone
    hidden: NDArray[np.bool_]  # (n / 16,) whether they and their neighbours show no seabed
    faces: Plane  # (2, NEIGHBOURS + 1) mark and brightness of what a pixel at an edge may show


def layers_for(width: int) -> Layers:
    """Return the memory for strips of images of this width [px]."""
    # A row above and one below, and a halo on both sides of at most STRIP / CHUNK rows.
    size = 3 * (STRIP + width) + 6 * HALO + 2 * HALO * (STRIP // CHUNK)
    edges = Edges(np.zeros(size, np.int64), np.zeros(size, np.int64), np.zeros(size, np.float32))
    depth, tone, mark = (np.zeros(size, np.float32) for _ in range(3))
    return Layers(
        depth,
        tone,
        mark,
        np.zeros((STRIP // CHUNK + 2, 2), np.int64),
        edges,
        np.zeros(size // WIDTH, np.int64),
        np.zeros(size // WIDTH, np.bool_),
        np.zeros((2, NEIGHBOURS + 1), np.float32),
    )


@njit(cache=True, nogil=True, error_model="numpy")
def _planes(layers: Layers, height: int, width: int) -> tuple[Plane, Plane, Plane]:
    """Return depth, tone and mark of a strip with its halo, (height + 2, width + 2 HALO)."""
    shape = (height + 2, width + 2 * HALO)
    size = shape[0] * shape[1]
    return (
        layers.depth[:size].reshape(shape),
        layers.tone[:size].reshape(shape),
        layers.mark[:size].reshape(shape),
    )


@njit(cache=True, nogil=True, error_model="numpy")
def find_bodies(
    instant: Instant,
    texels: Texels,
    extent: tuple[int, int, int],
    height: int,
    layers: Layers,
    whole: bool,
) -> bool:
    """Write what the middles of a strip's pixels show, and where bodies hide the seabed.

    Return whether there may be bodies. `extent` is row and column of the strip's first pixel, and
    its width. The depth of what the pixels show, see `depths`, is known where there are bodies, or
    in the `whole` strip.
    """
    seen = instant.seen
    row, start, width = extent
    layers.hidden[: height * (width // WIDTH)] = False
    left, top = start - HALO, row - 1
    first, end = (0, width) if whole else (width, 0)  # columns of the strip that bodies touch
    for k in range(seen.number):
        if seen.window[k, 1] < row + height + 1 and seen.window[k, 3] > top:
            first = min(first, seen.window[k, 0] - start)
            end = max(end, seen.window[k, 2] - start)
    first = max(first, 0) // WIDTH * WIDTH
    end = min((end + WIDTH - 1) // WIDTH * WIDTH, width)
    if first >= end:
        return False
    planes = _planes(layers, height, width)
    depth, _, marks = planes
    layers.span[: height + 2, 0], layers.span[: height + 2, 1] = width + 2 * HALO, 0
    _clear(instant.ground, (top, left), (first, end + 2 * HALO), depth, marks)
    for k in range(seen.number):
        _draw_middles(instant, k, texels, (top, left), planes, layers.span)
    _survey((height, width), marks, layers)
    return True


@njit(cache=True, nogil=True, error_model="numpy")
def draw_bodies(
    instant: Instant, extent: tuple[int, int, int], layers: Layers, light: Plane
) -> None:
    """Draw the bodies into a strip (rows * width,) of what reaches the camera from the seabed.

    `find_bodies` has found them; `extent` is as it is there.
    """
    row, start, width = extent
    height = light.shape[0] // width
    planes = _planes(layers, height, width)
    lit = light.reshape(height, width)
    count = _compose(instant, (row, start), planes, layers, lit)
    _draw_edges(instant, (row, start, count), planes[1:], layers, lit)


@njit(cache=True, nogil=True, error_model="numpy")
def depths(layers: Layers, height: int, width: int) -> Plane:
    """Return the depth of what a strip shows (rows, columns) [m], a view."""
    shape = (height + 2, width + 2 * HALO)
    return layers.depth[: shape[0] * shape[1]].reshape(shape)[1:-1, HALO:-HALO]


@uncounted
def draw_glow(
    instant: Instant,
    extent: tuple[int, int, int],
    layers: Layers,
    light: Plane,
) -> None:
    """Add the light of the lamp that the water scatters back to a strip (rows * width,)."""
    row, start, width = extent
    lit = light.reshape(light.shape[0] // width, width)
    shape = (lit.shape[0] + 2, width + 2 * HALO)
    depth = layers.depth[: shape[0] * shape[1]].reshape(shape)
    lens, lighting = instant.lens, instant.lighting
    inverse_f, u0 = f32x16(1.0 / lens[0]), f32x16(lens[1])
    steps, white = load(rows.STEPS, 0, 0), f32x16(255.0)
    for r in range(lit.shape[0]):
        y = f32x16((row + r - lens[2]) / lens[0])
        for q in range(0, width, WIDTH):
            x = ((f32x16(float(start + q)) + steps) - u0) * inverse_f
            back = glow(load(depth, r + 1, q + HALO), x, y, lighting)
            store(lit, r, q, load(lit, r, q) + white * back)


@uncounted
def _clear(
    ground: Ground, corner: tuple[int, int], span: tuple[int, int], depth: Plane, marks: Plane
) -> None:
    """Write the depth of the seabed and the mark of none."""
    top, left = corner
    one, least, zero = f32x16(1.0), f32x16(LEAST), f32x16(0.0)
    steps = load(rows.STEPS, 0, 0)
    for r in range(depth.shape[0]):
        v = float(top + r)
        w = f32x16(ground.map[2, 1] * v + ground.map[2, 2])
        slope = f32x16(ground.map[2, 0])
        for q in range(span[0], span[1], WIDTH):
            column = f32x16(float(left + q)) + steps
            store(depth, r, q, one / maximum(w + slope * column, least))
            store(marks, r, q, zero)


@uncounted
def _draw_middles(
    instant: Instant,
    k: int,
    texels: Texels,
    corner: tuple[int, int],
    planes: tuple[Plane, Plane, Plane],
    span: Integers,
) -> None:
    """Write a body where it is nearer than what is drawn already."""
    top, left = corner
    depth, tones, marks = planes
    seen = instant.seen
    body, kind = body_at(seen.numbers, k), seen.kind[k]
    lens, lighting = instant.lens, instant.lighting
    inverse_f, u0 = f32x16(1.0 / lens[0]), f32x16(lens[1])
    steps, nearest = load(rows.STEPS, 0, 0), f32x16(seen.nearest[k])
    last = min(seen.window[k, 3], top + depth.shape[0])
    for v in range(max(seen.window[k, 1], top), last):
        a, b = columns_seen(seen, k, v)
        r = v - top
        y = f32x16((v - lens[2]) / lens[0])
        first = (a - left) // WIDTH * WIDTH
        span[r, 0], span[r, 1] = min(span[r, 0], first), max(span[r, 1], b - left)
        for q in range(first, b - left, WIDTH):
            before = load(depth, r, q)
            if not greater_bits(before, nearest):
                continue
            x = ((f32x16(float(left + q)) + steps) - u0) * inverse_f
            d = ray(body, x, y)
            hits = hit(kind, body, d)
            if not greater_bits(before, hits[0]):
                continue
            radiance = tone(body, d, hits, texels, lighting)
            store(depth, r, q, select_greater(before, hits[0], hits[0], before))
            store(tones, r, q, select_greater(before, hits[0], radiance, load(tones, r, q)))
            name = mark(kind, body, hits)
            store(marks, r, q, select_greater(before, hits[0], name, load(marks, r, q)))


@uncounted
def _survey(size: tuple[int, int], marks: Plane, layers: Layers) -> None:
    """Write which pixels of a strip are at an edge, and which sixteen hide the seabed."""
    height, width = size
    half, across = f32x16(0.5), width // WIDTH
    for r in range(height):
        first, end = _touched(layers.span, r + 1, height + 1)
        for q in range(max(first - HALO, 0), min(end - HALO, width), WIDTH):
            i, j, k = r + 1, q + HALO, r * across + q // WIDTH
            own = load(marks, i, j)
            one, two = load(marks, i, j - 1), load(marks, i, j + 1)
            three, four = load(marks, i - 1, j), load(marks, i + 1, j)
            beside = maximum(_squared(one - own), _squared(two - own))
            above = maximum(_squared(three - own), _squared(four - own))
            layers.changed[k] = greater_bits(maximum(beside, above), half)
            lowest = minimum(own, minimum(minimum(one, two), minimum(three, four)))
            layers.hidden[k] = greater_bits(lowest, half) == ALL_LANES


@uncounted
def _compose(
    instant: Instant,
    corner: tuple[int, int],
    planes: tuple[Plane, Plane, Plane],
    layers: Layers,
    light: Plane,
) -> int:
    """Write the bodies over the seabed, list the pixels at edges, and return how many there are.

    `corner` is row and column of the strip's first pixel.
    """
    row, start = corner
    depth, tones, marks = planes
    lens, lighting = instant.lens, instant.lighting
    inverse_f, u0 = f32x16(1.0 / lens[0]), f32x16(lens[1])
    steps, half = load(rows.STEPS, 0, 0), f32x16(0.5)
    count, edge, span = 0, layers.edges, layers.span
    height, width = light.shape
    for r in range(-1, height + 1):
        y = f32x16((row + r - lens[2]) / lens[0])
        first, end = _touched(span, r + 1, height + 1)
        for q in range(max(first - HALO, -WIDTH), min(end - HALO, width + WIDTH), WIDTH):
            own = load(marks, r + 1, q + HALO)
            inside, changed = 0 <= r < height and 0 <= q < width, 0
            if inside:
                changed = layers.changed[r * (width // WIDTH) + q // WIDTH]
            if not changed and not greater_bits(own, half):
                continue
            x = ((f32x16(float(start + q)) + steps) - u0) * inverse_f
            arrived = arriving(
                load(tones, r + 1, q + HALO), load(depth, r + 1, q + HALO), x, y, lighting
            )
            store(tones, r + 1, q + HALO, arrived)
            if not inside:
                continue
            before = load(light, r, q)
            count = _listed(changed, (r, q), light, edge, count)
            store(light, r, q, select_greater(own, half, arrived, before))
    return count


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _touched(span: Integers, r: int, last: int) -> tuple[int, int]:
    """Return the columns in which a row, or an edge in it, may show a body."""
    above, below = max(r - 1, 0), min(r + 1, last)
    first = min(span[r, 0], span[above, 0], span[below, 0])
    return first - WIDTH, max(span[r, 1], span[above, 1], span[below, 1]) + WIDTH


@uncounted
def _listed(changed: int, at: tuple[int, int], light: Plane, edge: Edges, count: int) -> int:
    """List those of sixteen pixels, from a row and a column on, whose bits are set."""
    r, q = at
    while changed:
        if changed & 1:
            edge.row[count], edge.column[count] = r, q
            edge.seabed[count] = light[r, q]
            count += 1
        changed >>= 1
        q += 1
    return count


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _squared(value: "F32x16") -> "F32x16":
    return value * value


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _others(
    marks: Plane, tones: Plane, at: tuple[int, int], seabed: np.float32, faces: Plane
) -> int:
    """Write mark and brightness of what the neighbours of a pixel show, and return how many.

    Each face once, without that of the pixel; `faces` is (2, NEIGHBOURS).
    """
    i, j = at
    own, count = marks[i, j], 0
    for n in range(NEIGHBOURS):
        mark = marks[i + _DOWN[n], j + _ACROSS[n]]
        if mark != own:
            for other in range(count):
                if faces[0, other] == mark:
                    break
            else:
                faces[0, count] = mark
                tone = tones[i + _DOWN[n], j + _ACROSS[n]]
                faces[1, count] = tone if mark > _F(0.0) else seabed
                count += 1
    return count


@uncounted
def _draw_edges(
    instant: Instant,
    at: tuple[int, int, int],
    planes: tuple[Plane, Plane],
    layers: Layers,
    light: Plane,
) -> None:
    """Write the pixels at edges: each is the mean of sixteen places in it.

    A place has the brightness of the middle of that pixel, of this one and its neighbours, which
    shows the same face. `at` is row and column of the strip's first pixel, and the number of edge
    pixels; `planes` what reaches the camera, and the marks.
    """
    row, start, count = at
    tones, marks = planes
    edge, faces = layers.edges, layers.faces
    g, lens, seen = instant.ground.map, instant.lens, instant.seen
    inverse_f, u0, v0 = f32x16(1.0 / lens[0]), f32x16(lens[1]), f32x16(lens[2])
    zero, half, one, least = f32x16(0.0), f32x16(0.5), f32x16(1.0), f32x16(LEAST)
    across, down = load(PLACES, 0, 0), load(PLACES, 1, 0)
    for k in range(count):
        r, q = edge.row[k], edge.column[k]
        own = marks[r + 1, q + HALO]
        others = _others(marks, tones, (r + 1, q + HALO), edge.seabed[k], faces)
        v, u = f32x16(float(row + r)) + down, f32x16(float(start + q)) + across
        inverse = f32x16(g[2, 0]) * u + (f32x16(g[2, 1]) * v + f32x16(g[2, 2]))
        nearest = one / maximum(inverse, least)
        x, y = (u - u0) * inverse_f, (v - v0) * inverse_f
        shown = zero
        faces[0, others] = own  # last, so that it is among those that rays are cast at
        for n in range(others + 1):
            number = _new_body(faces, n)
            if number >= 0:
                body, kind = body_at(seen.numbers, number), seen.kind[number]
                hits = hit(kind, body, ray(body, x, y))
                shown = select_greater(nearest, hits[0], mark(kind, body, hits), shown)
                nearest = select_greater(nearest, hits[0], hits[0], nearest)
        value = f32x16(light[r, q])
        for n in range(others):
            same = _squared(shown - f32x16(faces[0, n]))
            value = select_greater(half, same, f32x16(faces[1, n]), value)
        light[r, q] = horizontal_sum(value) * _F(1.0 / WIDTH)


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _new_body(faces: Plane, n: int) -> int:
    """Return the body of a face; -1 for the seabed, and if a face before it is of that body."""
    number = int(faces[0, n] * _F(1.0 / MARKS)) - 1
    for other in range(n):
        if int(faces[0, other] * _F(1.0 / MARKS)) - 1 == number:
            return -1
    return number
