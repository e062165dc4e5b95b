"""Contacts: which shapes touch where, in a fixed number of slots for each pair of shapes."""

from typing import NamedTuple

from numba import njit

from seamark.sim.multibody.distances import (
    Touch,
    common_stretch,
    middle_of_passage,
    nearest_on_segment,
    nearest_to_ends,
    past_box,
    point_box,
    point_cylinder,
    point_socket,
    rim_direction,
    segments,
    spheres,
    to_line,
)
from seamark.sim.multibody.memory import zeros
from seamark.sim.multibody.tree import WORLD, Frames
from seamark.sim.multibody.vectors import (
    Vector,
    choose,
    clamped,
    column,
    cross,
    dot,
    larger,
    minus,
    plus,
    put,
    rotate,
    rotate_back,
    smaller,
    three,
    times,
)
from seamark.sim.numerics.arrays import Array, Integers
from seamark.sim.numerics.lanes import like, select, some, sqrt
from seamark.sim.numerics.uncounted import uncounted
from seamark.sim.physics.terrain import Mounds, height_and_slope

# Kinds of shapes. Capsules and cylinders lie along their x axis; a sphere is a short capsule.
CAPSULE, BOX, CYLINDER, GROUND, SOCKET = 0, 1, 2, 3, 4
# Slots of each pair of kinds that can touch.
SLOTS = {
    (CAPSULE, GROUND): 2,
    (BOX, GROUND): 8,
    (CYLINDER, GROUND): 6,
    (CAPSULE, CAPSULE): 3,
    (CAPSULE, BOX): 4,
    (CAPSULE, CYLINDER): 4,
    (BOX, BOX): 40,
    (CYLINDER, SOCKET): 7,
}
MARGIN_M = 0.01  # a gap above it is no contact: more than shapes approach each other in a step
_ROUNDING_M = 1e-6  # more than the error of a distance
_LEANING_M = 0.001  # capsules that count as parallel are at most so much nearer at an end
_SAME_POINT = 0.01  # share of a segment's half: nearer to its end is the end
_STEEP = 0.1  # least cosine of the angle between the axes of a cylinder and of its hole
_UPRIGHT = 1e-6  # sine of the angle below which a circle lies in a plane across
_HALF, _ROOT = 0.5, 0.8660254037844386  # cosine and sine of 60 degrees


class Shapes(NamedTuple):
    """k shapes, and m pairs of them that may touch."""

    kind: Integers  # (k,)
    link: Integers  # (k,) or WORLD
    first: Integers  # (m,) shape of each pair
    second: Integers  # (m,)
    slot: Integers  # (m,) first of its slots
    place: Array  # (k, 3) [m] centre in the link
    turn: Array  # (k, 3, 3) rotation to the link's axes
    size: (
        Array  # (k, 3) [m]: radius, half length; half lengths; radius, depth and chamfer of a hole
    )
    reach: (
        Array  # (k,) [m] radius of the sphere around the centre that contains it; inf without end
    )


class Touches(NamedTuple):
    """Where shapes are, and the contacts of s slots."""

    centre: Array  # (k, 3) [m] world
    turned: Array  # (k, 3, 3) rotation to world axes
    point: Array  # (s, 3) [m] world
    normal: Array  # (s, 3) pushes the first shape away from the second
    gap: Array  # (s,) [m]; above MARGIN_M for an unused slot
    corner: Array  # (8, 3) buffers
    near: Integers  # (m,) 1 for pairs whose slots may be in use, in one of the lanes


def touches_for(shapes: int, pairs: int, slots: int, lanes: tuple[int, ...] = ()) -> Touches:
    """Return the memory for so many shapes, pairs and slots."""
    sizes = {
        "centre": (shapes, 3),
        "turned": (shapes, 3, 3),
        "point": (slots, 3),
        "normal": (slots, 3),
        "gap": (slots,),
        "corner": (8, 3),
    }
    return zeros(Touches, sizes, lanes, integers={"near": (pairs,)})


@uncounted
def place_shapes(shapes: Shapes, frames: Frames, to: Touches) -> None:
    """Write centre and axes of all shapes in the world."""
    for k in range(shapes.kind.size):
        link, centre = shapes.link[k], three(shapes.place, k, 0)
        if link == WORLD:
            put(to.centre, k, 0, centre)
            for j in range(3):
                _put_column(to.turned, k, j, column(shapes.turn, k, j))
        else:
            centre = rotate(frames.rotation, link, centre)
            put(to.centre, k, 0, plus(three(frames.position, link, 0), centre))
            for j in range(3):
                axis = rotate(frames.rotation, link, column(shapes.turn, k, j))
                _put_column(to.turned, k, j, axis)


@njit(cache=True, error_model="numpy", inline="always")
def _put_column(m: Array, k: int, j: int, v: Vector) -> None:
    m[k, 0, j], m[k, 1, j], m[k, 2, j] = v[0], v[1], v[2]


@njit(cache=True, error_model="numpy", inline="always")
def _put_touch(slot: int, touch: Touch, to: Touches) -> None:
    point, normal, gap = touch
    put(to.point, slot, 0, point)
    put(to.normal, slot, 0, normal)
    to.gap[slot] = gap


@uncounted
def find_touches(shapes: Shapes, ground: Mounds, to: Touches) -> None:
    """Write the contacts of all pairs; `place_shapes` has been called."""
    far = like(to.gap[0], 2.0 * MARGIN_M)
    for slot in range(to.gap.size):
        to.gap[slot] = far
    for pair in range(shapes.first.size):
        a, b, slot = shapes.first[pair], shapes.second[pair], shapes.slot[pair]
        on_ground = shapes.kind[b] == GROUND
        if on_ground:
            top = ground.depth - ground.height
            near = some(to.centre[a, 2] + shapes.reach[a] + MARGIN_M > top)
        else:
            near = _may_touch(a, b, shapes, to)
        to.near[pair] = near
        if near and on_ground:
            _touch_ground(a, slot, shapes, ground, to)
        elif near:
            _touch_pair(a, b, slot, shapes, to)


@njit(cache=True, error_model="numpy", inline="always")
def _may_touch(a: int, b: int, shapes: Shapes, to: Touches) -> bool:
    """Return whether two primitives may be nearer than the margin, in any of the lanes.

    By their spheres; then by the sphere of the first and the box, or the box around the cylinder:
    the sphere of a long one reaches far beyond its sides.
    """
    apart = minus(three(to.centre, a, 0), three(to.centre, b, 0))
    reach = shapes.reach[a] + shapes.reach[b] + MARGIN_M
    if not some(dot(apart, apart) < reach * reach):
        return False
    if shapes.kind[b] != BOX and shapes.kind[b] != CYLINDER:
        return True
    beyond = past_box(rotate_back(to.turned, b, apart), _half_lengths(b, shapes))
    reach = shapes.reach[a] + (MARGIN_M + _ROUNDING_M)
    return some(dot(beyond, beyond) < reach * reach)


@njit(cache=True, error_model="numpy", inline="always")
def _half_lengths(b: int, shapes: Shapes) -> Vector:
    """Return half lengths along the axes of a box, or of a cylinder."""
    half = three(shapes.size, b, 0)
    if shapes.kind[b] == CYLINDER:
        half = (half[1], half[0], half[0])
    return half


@njit(cache=True, error_model="numpy", inline="always")
def _touch_pair(a: int, b: int, slot: int, shapes: Shapes, to: Touches) -> None:
    """Write the contacts of two primitives, of kinds in an order of SLOTS."""
    if shapes.kind[b] == CAPSULE:
        _touch_capsules(a, b, slot, shapes, to)
    elif shapes.kind[b] == SOCKET:
        _touch_socket(a, b, slot, shapes, to)
    elif shapes.kind[a] == CAPSULE:
        _touch_capsule_solid(a, b, slot, shapes, to)
    else:
        _touch_boxes(a, b, slot, shapes, to)


@njit(cache=True, error_model="numpy", inline="always")
def _touch_ground(a: int, slot: int, shapes: Shapes, ground: Mounds, to: Touches) -> None:
    centre = three(to.centre, a, 0)
    radius, half = shapes.size[a, 0], shapes.size[a, 1]
    axis = column(to.turned, a, 0)
    if shapes.kind[a] == CAPSULE:
        along = times(axis, half)
        _put_touch(slot, _sphere_ground(plus(centre, along), radius, ground), to)
        point, normal, gap = _sphere_ground(minus(centre, along), radius, ground)
        gap = select(half > 0.0, gap, 2.0 * MARGIN_M)  # a sphere has one end
        _put_touch(slot + 1, (point, normal, gap), to)
    elif shapes.kind[a] == BOX:
        for corner in range(8):
            p = _corner(a, corner, shapes, to)
            _put_touch(slot + corner, _sphere_ground(p, like(radius, 0.0), ground), to)
    else:
        zero = like(radius, 0.0)
        down = (zero, zero, zero + 1.0)
        for end in range(2):
            middle = plus(centre, times(axis, half if end == 1 else -half))
            for k in range(3):
                p = _rim_point(middle, axis, down, radius, k)
                _put_touch(slot + 3 * end + k, _sphere_ground(p, zero, ground), to)


@uncounted
def _sphere_ground(p: Vector, radius: float, ground: Mounds) -> Touch:
    """Return the touch of a sphere and the bottom, which is taken as flat around it."""
    height, north, east = height_and_slope(p[0], p[1], ground)
    steep = 1.0 / sqrt(north * north + east * east + 1.0)
    normal = (-north * steep, -east * steep, -steep)
    gap = (ground.depth - height - p[2]) * steep - radius
    return minus(p, times(normal, radius)), normal, gap


@njit(cache=True, error_model="numpy", inline="always")
def _corner(a: int, corner: int, shapes: Shapes, to: Touches) -> Vector:
    """Return corner 0 to 7 of a box in the world."""
    x, y, z = three(shapes.size, a, 0)
    x = x if corner & 1 else -x
    y = y if corner & 2 else -y
    z = z if corner & 4 else -z
    return plus(three(to.centre, a, 0), rotate(to.turned, a, (x, y, z)))


@uncounted
def _rim_point(middle: Vector, axis: Vector, wanted: Vector, radius: float, k: int) -> Vector:
    """Return a point of a circle: the farthest in a direction (k = 0), or 120 degrees beside it."""
    towards = rim_direction(wanted, axis)
    if k > 0:
        beside = cross(axis, towards)
        side = _ROOT if k == 1 else -_ROOT
        towards = plus(times(towards, -_HALF), times(beside, side))
    return plus(middle, times(towards, radius))


@uncounted
def _nearer(one: Touch, two: Touch) -> Touch:
    """Return the touch with the smaller gap; the first of equal ones."""
    first = one[2] <= two[2]
    return (
        choose(first, one[0], two[0]),
        choose(first, one[1], two[1]),
        select(first, one[2], two[2]),
    )


@uncounted
def _rim_at(middle: Vector, axis: Vector, deep: Vector, x: float, radius: float) -> Vector:
    """Return where a circle crosses a plane of that x, or is nearest; elsewhere with -radius."""
    towards = rim_direction(deep, axis)
    leans = abs(towards[0]) > _UPRIGHT
    slope = abs(radius) * select(leans, towards[0], 1.0)
    share = clamped((x - middle[0]) / slope, like(slope, -1.0), like(slope, 1.0))
    side = times(cross(axis, towards), radius * sqrt(1.0 - share * share))
    return plus(middle, plus(times(towards, abs(radius) * share), side))


@njit(cache=True, error_model="numpy", inline="always")
def _touch_capsules(a: int, b: int, slot: int, shapes: Shapes, to: Touches) -> None:
    """Write the touches of two capsules: where they are nearest, and beside each other's ends."""
    centre_a, centre_b = three(to.centre, a, 0), three(to.centre, b, 0)
    along_a = times(column(to.turned, a, 0), shapes.size[a, 1])
    along_b = times(column(to.turned, b, 0), shapes.size[b, 1])
    s, t = segments(centre_a, along_a, centre_b, along_b)
    nearest = spheres(
        plus(centre_a, times(along_a, s)),
        shapes.size[a, 0],
        plus(centre_b, times(along_b, t)),
        shapes.size[b, 0],
    )
    _put_touch(slot, nearest, to)
    if not some(nearest[2] < MARGIN_M + _LEANING_M):
        return
    first, first_b, last, last_b, exists = common_stretch(centre_a, along_a, centre_b, along_b)
    for k in range(1, 3):
        one, two = (first, first_b) if k == 1 else (last, last_b)
        p, q = plus(centre_a, times(along_a, one)), plus(centre_b, times(along_b, two))
        point, normal, gap = spheres(p, shapes.size[a, 0], q, shapes.size[b, 0])
        gap = select(exists, gap, 2.0 * MARGIN_M)
        _put_touch(slot + k, (point, normal, gap), to)


@njit(cache=True, error_model="numpy", inline="always")
def _touch_capsule_solid(a: int, b: int, slot: int, shapes: Shapes, to: Touches) -> None:
    """Write the touches of a capsule with a box or a cylinder: at both ends, and between.

    Along a face or a side that is a stretch, so it has two ends.
    """
    half, radius = _half_lengths(b, shapes), shapes.size[a, 0]
    is_round = shapes.kind[b] == CYLINDER
    away = minus(three(to.centre, a, 0), three(to.centre, b, 0))
    middle = rotate_back(to.turned, b, away)
    along = rotate_back(to.turned, b, times(column(to.turned, a, 0), shapes.size[a, 1]))
    one, long = like(radius, 1.0), shapes.size[a, 1] > 0.0
    between_ends = nearest_to_ends(middle, along, half, 1.0 - 0.5 * _SAME_POINT, is_round)
    for k in range(4):
        share = -one if k == 0 else one
        if k >= 2:
            if not some(between_ends[k - 2]):
                continue
            share = nearest_on_segment(middle, along, half, -1.0 if k == 2 else 1.0, is_round)
        p = plus(middle, times(along, share))
        if is_round:
            point, normal, gap = _sphere_cylinder(p, radius, b, half, to)
        else:
            point, normal, gap = _sphere_box(p, radius, b, half, to)
        if k == 1:
            gap = select(long, gap, 2.0 * MARGIN_M)
        elif k >= 2:
            between = abs(share) < 1.0 - _SAME_POINT
            gap = select(between & long, gap, 2.0 * MARGIN_M)
        _put_touch(slot + k, (point, normal, gap), to)


@uncounted
def _sphere_box(p: Vector, radius: float, b: int, half: Vector, to: Touches) -> Touch:
    """Return the touch of a sphere at p, in the axes of box b, and that box."""
    normal, distance = point_box(p, half)
    return _sphere_touch(p, radius, b, normal, distance, to)


@njit(cache=True, error_model="numpy", inline="always")
def _sphere_cylinder(p: Vector, radius: float, b: int, half: Vector, to: Touches) -> Touch:
    """Return the touch of a sphere at p, in the axes of cylinder b, and that cylinder."""
    normal, distance = point_cylinder(p, half)
    return _sphere_touch(p, radius, b, normal, distance, to)


@njit(cache=True, error_model="numpy", inline="always")
def _sphere_touch(
    p: Vector, radius: float, b: int, normal: Vector, distance: float, to: Touches
) -> Touch:
    point = minus(p, times(normal, radius))
    world = plus(three(to.centre, b, 0), rotate(to.turned, b, point))
    return world, rotate(to.turned, b, normal), distance - radius


@njit(cache=True, error_model="numpy", inline="always")
def _touch_boxes(a: int, b: int, slot: int, shapes: Shapes, to: Touches) -> None:
    """Write the touches of each box's corners, and of edges that pass through, with the other."""
    _touch_box(a, b, slot, 1.0, shapes, to)
    _touch_box(b, a, slot + 20, -1.0, shapes, to)


@uncounted
def _touch_box(a: int, b: int, slot: int, sign: float, shapes: Shapes, to: Touches) -> None:
    """Write the touches of a's corners and edges with b; `sign` -1 if the normal pushes b."""
    half = three(shapes.size, b, 0)
    zero = like(half[0], 0.0)
    for corner in range(8):
        p = _corner_in(a, corner, b, shapes, to)
        put(to.corner, corner, 0, p)
        if some(_reaches(p, p, half, MARGIN_M + _ROUNDING_M)):
            point, normal, gap = _sphere_box(p, zero, b, half, to)
            _put_touch(slot + corner, (point, times(normal, sign), gap), to)
    for edge in range(12):
        # Its two corners differ in one bit, that of its axis.
        axis, other = edge // 4, edge % 4
        low = (other & ((1 << axis) - 1)) | ((other >> axis) << (axis + 1))
        p, q = three(to.corner, low, 0), three(to.corner, low | (1 << axis), 0)
        if not some(_reaches(p, q, half, 0.0)):
            continue
        share, inside = middle_of_passage(p, minus(q, p), half)
        point, normal, gap = _sphere_box(plus(p, times(minus(q, p), share)), zero, b, half, to)
        gap = select(inside, gap, 2.0 * MARGIN_M)
        _put_touch(slot + 8 + edge, (point, times(normal, sign), gap), to)


@njit(cache=True, error_model="numpy", inline="always")
def _reaches(p: Vector, q: Vector, half: Vector, margin: float) -> bool:
    """Return whether a segment, p to q, is not beyond one side of a box around the origin."""
    return (
        _overlaps(p[0], q[0], half[0] + margin)
        & _overlaps(p[1], q[1], half[1] + margin)
        & _overlaps(p[2], q[2], half[2] + margin)
    )


@njit(cache=True, error_model="numpy", inline="always")
def _overlaps(p: float, q: float, half: float) -> bool:
    return (smaller(p, q) <= half) & (larger(p, q) >= -half)


@njit(cache=True, error_model="numpy", inline="always")
def _corner_in(a: int, corner: int, b: int, shapes: Shapes, to: Touches) -> Vector:
    """Return a corner of box a in the axes of box b."""
    away = minus(_corner(a, corner, shapes, to), three(to.centre, b, 0))
    return rotate_back(to.turned, b, away)


@njit(cache=True, error_model="numpy", inline="always")
def _touch_socket(a: int, b: int, slot: int, shapes: Shapes, to: Touches) -> None:
    """Write the touches of a cylinder and a hole: tip and hole, side and mouth, tip and mouth."""
    radius, half = shapes.size[a, 0], shapes.size[a, 1]
    socket = three(shapes.size, b, 0)
    away = minus(three(to.centre, a, 0), three(to.centre, b, 0))
    centre = rotate_back(to.turned, b, away)
    axis = rotate_back(to.turned, b, column(to.turned, a, 0))
    inwards = axis[0] > 0.0  # from here on the axis points into the hole
    axis = choose(inwards, times(axis, -1.0), axis)
    tip = plus(centre, times(axis, half))
    zero = like(radius, 0.0)
    far = zero + 2.0 * MARGIN_M
    deep = (zero - 1.0, zero, zero)
    off = (zero, tip[1], tip[2])
    _put_touch(slot, _socket_point(_rim_point(tip, axis, off, radius, 0), b, socket, to), to)
    for k in range(3):
        p = _rim_point(tip, axis, deep, radius, k)
        _put_touch(slot + 1 + k, _socket_point(p, b, socket, to), to)
    for k in range(2):
        # The edge of the bore, then that of the chamfer, on the side to which the cylinder leans.
        depth = -socket[2] if k == 0 else zero
        wide = socket[0] if k == 0 else socket[0] + socket[2]
        to_plane = (depth - centre[0]) / select(axis[0] < -_STEEP, axis[0], -_STEEP)
        crossing = plus(centre, times(axis, to_plane))
        lean = rim_direction((zero, crossing[1], crossing[2]), (zero + 1.0, zero, zero))
        edge = plus((depth, zero, zero), times(lean, wide))
        normal, distance, along = to_line(edge, centre, axis)
        # Nearer to the cylinder's end than to its side, the edge meets the end: the tip's touches.
        by_side = (abs(along) <= half) & (distance - radius >= abs(along) - half)
        world = plus(three(to.centre, b, 0), rotate(to.turned, b, edge))
        normal, gap = rotate(to.turned, b, normal), select(by_side, distance - radius, far)
        _put_touch(slot + 4 + k, (world, normal, gap), to)
    one = _socket_point(_rim_at(tip, axis, deep, -socket[2], radius), b, socket, to)
    two = _socket_point(_rim_at(tip, axis, deep, -socket[2], -radius), b, socket, to)
    _put_touch(slot + 6, _nearer(one, two), to)


@uncounted
def _socket_point(p: Vector, b: int, socket: Vector, to: Touches) -> Touch:
    normal, gap = point_socket(p, socket)
    world = plus(three(to.centre, b, 0), rotate(to.turned, b, p))
    return world, rotate(to.turned, b, normal), gap
