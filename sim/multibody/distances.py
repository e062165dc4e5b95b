"""Distances between primitives: where two shapes touch, how far apart they are, in which direction.

A touch is a point in the world, the unit normal that pushes the first shape away from the second,
and the gap along it [m], negative where they overlap. Every degenerate direction (a point on the
axis of a hole, at the centre of a box) has a fixed choice. There are no branches on numbers, so the
functions serve one pair or, with `numerics.lanes`, eight of them.
"""

from numba import njit

from seamark.sim.multibody.vectors import (
    Vector,
    across,
    choose,
    clamped,
    dot,
    larger,
    minus,
    plus,
    times,
    unit_or,
)
from seamark.sim.numerics.lanes import like, select, sqrt

Touch = tuple[Vector, Vector, float]
_CLOSE = 1e-6  # [m]
_TINY = 1e-12  # [m] lengths below it have no direction
_SHORT = 1e-3  # share of a segment: a common stretch below it is a point
_BISECTIONS = 20  # of a segment of 1 m: within 1 um
_FLAT = 0.001  # sine of the angle to a face below which a segment is along it
_NO_DIRECTION = 1e-6
_SQRT_HALF = 0.7071067811865476
_PARALLEL = 1e-8  # squared sine of the angle below which segments have no nearest points
_NEARLY_PARALLEL = 0.01  # below which the ends of their common stretch are nearly as near


@njit(cache=True, error_model="numpy")
def point_box(p: Vector, half: Vector) -> tuple[Vector, float]:
    """Return normal and signed distance of a point to a box around the origin, in the box's axes.

    Inside, the nearest face counts.
    """
    x, y, z = p
    zero = like(x, 0.0)
    sx, sy, sz = (
        select(x < 0.0, zero - 1.0, zero + 1.0),
        select(y < 0.0, zero - 1.0, zero + 1.0),
        select(z < 0.0, zero - 1.0, zero + 1.0),
    )
    qx, qy, qz = abs(x) - half[0], abs(y) - half[1], abs(z) - half[2]
    by_x = (qx >= qy) & (qx >= qz)
    by_y = qy >= qz
    face = choose(by_x, (sx, zero, zero), choose(by_y, (zero, sy, zero), (zero, zero, sz)))
    deepest = larger(larger(qx, qy), qz)
    out = (sx * larger(qx, zero), sy * larger(qy, zero), sz * larger(qz, zero))
    away = sqrt(dot(out, out))
    outside = away > _TINY
    normal = choose(outside, times(out, 1.0 / select(outside, away, 1.0)), face)
    return normal, select(outside, away, deepest)


@njit(cache=True, error_model="numpy")
def point_cylinder(p: Vector, half: Vector) -> tuple[Vector, float]:
    """Return normal and signed distance of a point to a cylinder along x around the origin.

    `half` is half its length, and its radius twice. Inside, the nearest surface counts; a point on
    the axis is pushed along y.
    """
    x, y, z = p
    zero = like(x, 0.0)
    one = zero + 1.0
    end = select(x < 0.0, -one, one)
    off = sqrt(y * y + z * z)
    centred = off <= _TINY
    safe = select(centred, one, off)
    y, z = select(centred, one, y / safe), select(centred, zero, z / safe)
    past, beside = abs(x) - half[0], off - half[1]
    by_end = past >= beside
    face = choose(by_end, (end, zero, zero), (zero, y, z))
    outwards = larger(beside, zero)
    out = (end * larger(past, zero), y * outwards, z * outwards)
    away = sqrt(dot(out, out))
    outside = away > _TINY
    normal = choose(outside, times(out, 1.0 / select(outside, away, 1.0)), face)
    return normal, select(outside, away, larger(past, beside))


@njit(cache=True, error_model="numpy")
def _beyond(p: Vector, half: Vector, is_round: bool) -> Vector:
    """Return the vector to a point from the nearest of a box, or of a cylinder along x."""
    if is_round:
        x = p[0] - clamped(p[0], -half[0], half[0])
        off = sqrt(p[1] * p[1] + p[2] * p[2])
        share = larger(off - half[1], like(off, 0.0)) / larger(off, half[1])
        return x, p[1] * share, p[2] * share
    return past_box(p, half)


@njit(cache=True, error_model="numpy")
def past_box(p: Vector, half: Vector) -> Vector:
    """Return the vector to a point from the nearest of a box around the origin."""
    return (
        p[0] - clamped(p[0], -half[0], half[0]),
        p[1] - clamped(p[1], -half[1], half[1]),
        p[2] - clamped(p[2], -half[2], half[2]),
    )


@njit(cache=True, error_model="numpy")
def nearest_on_segment(
    middle: Vector, along: Vector, half: Vector, side: float, is_round: bool
) -> float:
    """Return where the segment middle ± along is nearest to a box around the origin: -1 to 1.

    With `is_round` to a cylinder along x, see `point_cylinder`. If it is along a face, that is a
    stretch; `side` is -1 for its first end and 1 for its last. The slope of the distance grows
    along the segment, so its sign is bisected.
    """
    low = like(middle[0], -1.0)
    high = like(middle[0], 1.0)
    flat = side * _FLAT * sqrt(dot(along, along))
    for _ in range(_BISECTIONS):
        t = 0.5 * (low + high)
        p = plus(middle, times(along, t))
        beyond = _beyond(p, half, is_round)
        slope = dot(beyond, along)
        falls = slope < flat * sqrt(dot(beyond, beyond))
        low, high = select(falls, t, low), select(falls, high, t)
    return 0.5 * (low + high)


@njit(cache=True, error_model="numpy")
def nearest_to_ends(
    middle: Vector, along: Vector, half: Vector, share: float, is_round: bool
) -> tuple[bool, bool]:
    """Return for either side of `nearest_on_segment` whether that may be within ± share.

    The distance is convex along the segment, so it falls up to where it still falls.
    """
    length = sqrt(dot(along, along))
    first = _beyond(plus(middle, times(along, -share)), half, is_round)
    last = _beyond(plus(middle, times(along, share)), half, is_round)
    off_first, off_last = sqrt(dot(first, first)), sqrt(dot(last, last))
    close = 3.0 * _FLAT * length + _CLOSE  # there rounding has a say in the slope
    near_first, near_last = off_first < close, off_last < close
    slope_first, slope_last = dot(first, along), dot(last, along)
    flat, slack = _FLAT * length, _NO_DIRECTION * length
    return (
        (near_first | (slope_first <= (slack - flat) * off_first))
        & (near_last | (slope_last >= (-slack - flat) * off_last)),
        (near_first | (slope_first <= (slack + flat) * off_first))
        & (near_last | (slope_last >= (flat - slack) * off_last)),
    )


@njit(cache=True, error_model="numpy")
def middle_of_passage(p: Vector, along: Vector, half: Vector) -> tuple[float, bool]:
    """Return the middle of what a box around the origin contains of a segment, p to p + along.

    Returns
    -------
    share : float
        From 0 to 1.
    passes : bool
        Whether the segment enters the box and leaves it: both ends are outside.
    """
    enters, leaves = like(p[0], -1.0), like(p[0], 2.0)
    for i in range(3):
        flat = abs(along[i]) < _TINY
        slope = select(flat, 1.0, along[i])
        one, two = (-half[i] - p[i]) / slope, (half[i] - p[i]) / slope
        first, last = select(one < two, one, two), select(one < two, two, one)
        outside = abs(p[i]) > half[i]
        first = select(flat, select(outside, 3.0, like(slope, -1.0)), first)
        last = select(flat, select(outside, -2.0, like(slope, 2.0)), last)
        enters, leaves = larger(enters, first), select(leaves < last, leaves, last)
    passes = (enters > 0.0) & (leaves < 1.0) & (enters < leaves)
    return select(passes, 0.5 * (enters + leaves), 0.5), passes


@njit(cache=True, error_model="numpy")
def segments(a: Vector, along_a: Vector, b: Vector, along_b: Vector) -> tuple[float, float]:
    """Return where two segments a ± along_a and b ± along_b are nearest to each other.

    Returns
    -------
    s, t : float
        Share of `along_a` and of `along_b`, from -1 to 1 (Ericson 2005, 5.1.9). Of parallel ones,
        the middle of their common stretch.
    """
    zero = like(a[0], 0.0)
    one = zero + 1.0
    between = minus(a, b)
    aa, bb, ab = dot(along_a, along_a), dot(along_b, along_b), dot(along_a, along_b)
    ca, cb = dot(along_a, between), dot(along_b, between)
    long_a, long_b = aa > _TINY * _TINY, bb > _TINY * _TINY
    safe_a, safe_b = select(long_a, aa, 1.0), select(long_b, bb, 1.0)
    spread = aa * bb - ab * ab
    crossing = spread > _PARALLEL * aa * bb
    first, last = clamped((-ab - ca) / safe_a, -one, one), clamped((ab - ca) / safe_a, -one, one)
    crossed = clamped((ab * cb - ca * bb) / select(crossing, spread, one), -one, one)
    s = select(crossing, crossed, 0.5 * (first + last))
    t = select(long_b, clamped((ab * s + cb) / safe_b, -one, one), zero)
    s = select(crossing | (abs(t) >= one), clamped((ab * t - ca) / safe_a, -one, one), s)
    return select(long_a, s, zero), t


@njit(cache=True, error_model="numpy")
def common_stretch(
    a: Vector, along_a: Vector, b: Vector, along_b: Vector
) -> tuple[float, float, float, float, bool]:
    """Return the ends of what two segments that are nearly parallel have beside each other.

    Returns
    -------
    s, t, s_last, t_last : float
        Shares of `along_a` and of `along_b` at one end and at the other, from -1 to 1.
    exists : bool
        Whether they are nearly parallel and have such a stretch.
    """
    zero = like(a[0], 0.0)
    one = zero + 1.0
    between = minus(a, b)
    aa, bb, ab = dot(along_a, along_a), dot(along_b, along_b), dot(along_a, along_b)
    ca, cb = dot(along_a, between), dot(along_b, between)
    long_a, long_b = aa > _TINY * _TINY, bb > _TINY * _TINY
    safe_a, safe_b = select(long_a, aa, 1.0), select(long_b, bb, 1.0)
    first, last = clamped((-ab - ca) / safe_a, -one, one), clamped((ab - ca) / safe_a, -one, one)
    exists = long_a & long_b & (aa * bb - ab * ab <= _NEARLY_PARALLEL * aa * bb)
    return (
        first,
        clamped((ab * first + cb) / safe_b, -one, one),
        last,
        clamped((ab * last + cb) / safe_b, -one, one),
        exists & (abs(last - first) > _SHORT),
    )


@njit(cache=True, error_model="numpy")
def spheres(a: Vector, radius_a: float, b: Vector, radius_b: float) -> Touch:
    """Return the touch of two spheres; concentric ones are pushed up (NED)."""
    zero = like(a[0], 0.0)
    apart = minus(a, b)
    distance = sqrt(dot(apart, apart))
    normal = unit_or(apart, (zero, zero, zero - 1.0), _TINY)
    gap = distance - (radius_a + radius_b)
    return plus(b, times(normal, radius_b + 0.5 * gap)), normal, gap


@njit(cache=True, error_model="numpy")
def point_socket(p: Vector, socket: Vector) -> tuple[Vector, float]:
    """Return normal and signed distance of a point to a wall with a hole, in the socket's axes.

    The wall's face is x = 0, x points out of it, and the axis of the hole is x. A point on the axis
    that touches the bore is pushed along -y.

    Parameters
    ----------
    socket : three floats [m]
        Radius of the hole, its depth, and width of the chamfer at 45 degrees at its mouth.
    """
    radius, depth, chamfer = socket
    x, y, z = p
    zero = like(x, 0.0)
    one = zero + 1.0
    off = sqrt(y * y + z * z)
    centred = off <= _TINY
    y, z = select(centred, one, y), select(centred, zero, z)
    off_or_one = select(centred, one, off)
    y, z = y / off_or_one, z / off_or_one
    bore, cone = radius - off, (x + (radius + chamfer - off)) * _SQRT_HALF
    floor = x + depth
    wall = larger(larger(x, bore), cone)
    normal = choose(
        (x >= bore) & (x >= cone),
        (one, zero, zero),
        choose(
            bore >= cone,
            (zero, -y, -z),
            (_SQRT_HALF * one, -_SQRT_HALF * y, -_SQRT_HALF * z),
        ),
    )
    by_floor = floor < wall
    return choose(by_floor, (one, zero, zero), normal), select(by_floor, floor, wall)


@njit(cache=True, error_model="numpy")
def to_line(p: Vector, a: Vector, axis: Vector) -> tuple[Vector, float, float]:
    """Return how a point lies beside the line through a along a unit vector.

    Returns
    -------
    normal : Vector
        From the point to the line; of a point on the line, a fixed one across it.
    distance, along : float [m]
        From the line; of the foot of the perpendicular from a.
    """
    from_a = minus(p, a)
    along = dot(from_a, axis)
    beside = minus(times(axis, along), from_a)
    distance = sqrt(dot(beside, beside))
    return unit_or(beside, across(axis), _TINY), distance, along


@njit(cache=True, error_model="numpy")
def rim_direction(wanted: Vector, axis: Vector) -> Vector:
    """Return the unit vector across an axis that is nearest to a direction; a fixed one for none.

    Directions within 1e-6 rad of the axis are none: from them rounding would choose.
    """
    flat = minus(wanted, times(axis, dot(wanted, axis)))
    return unit_or(flat, across(axis), _NO_DIRECTION)
