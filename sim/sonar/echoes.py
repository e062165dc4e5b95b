"""The echoes of a ping: rays in each beam, where they end, and what returns from when.

A beam has columns of rays, from its upper to its lower edge. Between two neighbours in a column
that meet the same surface lies a slice of it, whose echo is spread over the ranges in between; at
an edge, half a slice belongs to each side. So surfaces have no gaps however few the rays, and what
lies behind another one is in its shadow.

A slice returns mu sin^2(grazing angle) times its area (Lambert), which is solid angle times range
squared over sin(grazing angle): mu sin(grazing angle) times its solid angle, over range squared.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.camera.bodies import Paints, Shapes
from seamark.sim.camera.hits import FAR, hit, ray
from seamark.sim.camera.instant import Links, Mount, axes_of
from seamark.sim.camera.lighting import Lighting
from seamark.sim.camera.open_seabed import LOWEST_M
from seamark.sim.camera.sightings import Seen, Sight, bodies_seen, body_at
from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.simd import WIDTH, f32x16, load, maximum, minimum, select_greater, store
from seamark.sim.numerics.uncounted import uncounted
from seamark.sim.sonar.seabed_strength import TEXEL_M, TILE

Plane = NDArray[np.float32]

SCALE_PX = 512.0  # per unit of x and y, of the window in which bodies are found
COLUMNS = 2  # of a beam: what is narrower than their distance may be missed
WHOLE = (-4096, -4096, 4096, 4096)
DEPTH, FACING, SURFACE = 0, 1, 2  # rows of what the rays of a beam meet
NOTHING, SEABED, FIRST_BODY = 0.0, 1.0, 2.0
_LEAST = 1e-4  # [1/m] per depth; a ray that falls more slowly meets no seabed
_BIAS = float(1 << 14)  # [texel] keeps indices positive; a multiple of TILE
_F = np.float32


class Fan(NamedTuple):
    """The rays (x, y, 1) of all beams, in the axes of the sonar: starboard, down, ahead."""

    x: Array  # (columns,)
    y: Plane  # (columns, edges) of the rays; edges beyond the last repeat it
    length: Plane  # (columns, edges) of the vectors
    solid: Plane  # (1, slices) [sr] of what lies between two rays, times the beam's pattern


class Waters(NamedTuple):
    """What a ping meets."""

    shapes: Shapes
    strengths: Paints  # albedo is mu, see `acoustics`
    seabed_m: float
    sand: float  # mu of the seabed
    tile: Plane  # strength of places of the seabed relative to it
    shift: tuple[float, float]  # [texel] of the tile
    bin_m: float


class _Ground(NamedTuple):
    """The seabed in the axes of the sonar: by component of a ray, x, y and 1."""

    height: float  # [m] of the sonar
    down: tuple[float, float, float]
    north: tuple[float, float, float]
    east: tuple[float, float, float]
    north_m: float
    east_m: float


@njit(cache=True, nogil=True, error_model="numpy")
def ping(
    placed: Links,
    mount: Mount,
    fan: Fan,
    waters: Waters,
    lighting: Lighting,
    near: Plane,
    echoes: Plane,
) -> None:
    """Write what returns of each beam from each range, (beams, bins), before losses on the way.

    Parameters
    ----------
    lighting
        Any: bodies in sight have one.
    near : (3, edges)
        Memory for the rays of a column.
    """
    sight = axes_of(placed, mount)
    intrinsics = np.zeros(3)
    intrinsics[0] = SCALE_PX
    seen = bodies_seen(
        *(sight, (placed[0], placed[1]), waters.shapes, waters.strengths, lighting),
        intrinsics,
        WHOLE,
    )
    ground = _ground(sight, waters.seabed_m)
    echoes[:] = _F(0.0)
    for column in range(fan.x.shape[0]):
        _meet_seabed(ground, fan, column, near)
        across = SCALE_PX * fan.x[column]
        for k in range(seen.number):
            if seen.window[k, 0] <= across <= seen.window[k, 2]:
                _meet_body(seen, k, fan, column, near)
        _gather(ground, seen, fan, column, waters, near, echoes)


@njit(cache=True, nogil=True, error_model="numpy")
def _ground(sight: Sight, seabed_m: float) -> _Ground:
    axes, centre = sight.axes, sight.centre
    return _Ground(
        max(seabed_m - centre[2], LOWEST_M),
        (axes[0, 2], axes[1, 2], axes[2, 2]),
        (axes[0, 0], axes[1, 0], axes[2, 0]),
        (axes[0, 1], axes[1, 1], axes[2, 1]),
        centre[0],
        centre[1],
    )


@uncounted
def _meet_seabed(ground: _Ground, fan: Fan, column: int, near: Plane) -> None:
    """Write where the rays of a column meet the seabed, and how squarely."""
    fall, height = f32x16(ground.down[1]), f32x16(ground.height)
    level = f32x16(ground.down[0] * fan.x[column] + ground.down[2])
    far, least, nothing = f32x16(FAR), f32x16(_LEAST), f32x16(NOTHING)
    for q in range(0, fan.y.shape[1], WIDTH):
        down = level + fall * load(fan.y, column, q)
        store(near, DEPTH, q, select_greater(down, least, height / maximum(down, least), far))
        store(near, FACING, q, down / load(fan.length, column, q))
        store(near, SURFACE, q, select_greater(down, least, f32x16(SEABED), nothing))


@uncounted
def _meet_body(seen: Seen, k: int, fan: Fan, column: int, near: Plane) -> None:
    """Write a body where it is nearer than what the rays have met already."""
    body, kind, name = body_at(seen.numbers, k), seen.kind[k], f32x16(FIRST_BODY + k)
    x, zero = f32x16(fan.x[column]), f32x16(0.0)
    for q in range(0, fan.y.shape[1], WIDTH):
        d = ray(body, x, load(fan.y, column, q))
        depth, nx, ny, nz = hit(kind, body, d)
        before = load(near, DEPTH, q)
        along = nx * d[0] + ny * d[1] + nz * d[2]
        facing = maximum(zero - along, zero) / load(fan.length, column, q)
        store(near, DEPTH, q, minimum(before, depth))
        store(near, FACING, q, select_greater(before, depth, facing, load(near, FACING, q)))
        store(near, SURFACE, q, select_greater(before, depth, name, load(near, SURFACE, q)))


@uncounted
def _gather(
    ground: _Ground, seen: Seen, fan: Fan, column: int, waters: Waters, near: Plane, echoes: Plane
) -> None:
    """Add the echoes of the slices of a column."""
    beam = column // COLUMNS
    for i in range(fan.solid.shape[1]):
        above, below = near[SURFACE, i], near[SURFACE, i + 1]
        before, after = near[FACING, i], near[FACING, i + 1]
        start = near[DEPTH, i] * fan.length[column, i]
        end = near[DEPTH, i + 1] * fan.length[column, i + 1]
        top, low, solid = fan.y[column, i], fan.y[column, i + 1], fan.solid[0, i]
        if above == below:
            part = _Slice(above, start, end, top, low, _F(0.5) * (before + after) * solid)
            _add(ground, seen, fan.x[column], beam, waters, part, echoes)
        else:  # an edge in between
            middle, half = _F(0.5) * (top + low), _F(0.5) * solid
            cut = _range_at(ground, fan.x[column], middle, above, start)
            part = _Slice(above, start, cut, top, middle, half * before)
            _add(ground, seen, fan.x[column], beam, waters, part, echoes)
            cut = _range_at(ground, fan.x[column], middle, below, end)
            part = _Slice(below, cut, end, middle, low, half * after)
            _add(ground, seen, fan.x[column], beam, waters, part, echoes)


class _Slice(NamedTuple):
    """A slice of a surface between two rays."""

    surface: float
    start_m: float  # range at the upper ray,
    end_m: float  # at the lower one
    top: float  # y of these rays
    low: float
    echo: float  # solid angle times sine of the grazing angle


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _range_at(ground: _Ground, x: float, y: float, surface: float, here_m: float) -> float:
    """Return the range of a surface along a ray beside the one that meets it `here_m` away."""
    if surface != SEABED:
        return here_m
    down = ground.down[0] * x + ground.down[1] * y + ground.down[2]
    return ground.height / max(down, _LEAST) * math.sqrt(1.0 + x * x + y * y)


@uncounted
def _add(
    ground: _Ground,
    seen: Seen,
    x: float,
    beam: int,
    waters: Waters,
    part: _Slice,
    echoes: Plane,
) -> None:
    """Spread the echo of a slice over the ranges that it reaches from and to."""
    nearest, farthest = min(part.start_m, part.end_m), max(part.start_m, part.end_m)
    bins, wide = echoes.shape[1], waters.bin_m
    if part.surface == NOTHING or not nearest < bins * wide:
        return
    on_seabed = part.surface == SEABED
    mu = waters.sand
    if not on_seabed:
        mu = float(body_at(seen.numbers, int(part.surface - FIRST_BODY)).albedo) / 255.0
    north, east = _texel(ground, x, part.top, part.start_m)
    to_north, to_east = _texel(ground, x, part.low, part.end_m)
    first, last = int(nearest / wide), min(int(farthest / wide), bins - 1)
    across = 1.0 / max(farthest - nearest, 1e-9) * (1.0 if part.end_m > part.start_m else -1.0)
    for j in range(first, last + 1):
        begin, end = max(nearest, j * wide), min(farthest, (j + 1) * wide)
        share = 1.0 if int(farthest / wide) == first else (end - begin) * abs(across)
        if on_seabed:
            on = (0.5 * (begin + end) - part.start_m) * across
            row = int(north + on * (to_north - north) + waters.shift[0])
            column = int(east + on * (to_east - east) + waters.shift[1])
            share *= waters.tile[row & (TILE - 1), column & (TILE - 1)]
        echoes[beam, j] += _F(share * mu * part.echo)


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _texel(ground: _Ground, x: float, y: float, range_m: float) -> tuple[float, float]:
    """Return row and column of where a ray ends, north and east of the origin [texel]."""
    depth = range_m / math.sqrt(1.0 + x * x + y * y)
    north = ground.north[0] * x + ground.north[1] * y + ground.north[2]
    east = ground.east[0] * x + ground.east[1] * y + ground.east[2]
    return (
        (ground.north_m + depth * north) * (1.0 / TEXEL_M) + _BIAS,
        (ground.east_m + depth * east) * (1.0 / TEXEL_M) + _BIAS,
    )
