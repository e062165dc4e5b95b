"""The impulses of a step: motors, gear friction, limits of joints, contacts with friction.

Every one is a row: the speed J v that an impulse changes, the range of the impulse, the speed that
is wanted. Projected Gauss-Seidel goes through the rows a fixed number of times, beginning with the
impulses of the last step. Contacts are springs with dampers that are integrated implicitly, so they
may be stiff; friction is the disc |f| <= mu n, without a spring, so nothing creeps that is held.

Speeds are kept as w = D^(1/2) L v with the factors of `tree.factorise`. The rows are J L^-1
D^(-1/2), which have numbers only for the degrees of freedom on the way to the root.
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.multibody.contacts import MARGIN_M, Shapes, Touches
from seamark.sim.multibody.tree import FREE, PRISMATIC, WORLD, Frames, Structure
from seamark.sim.multibody.vectors import (
    Vector,
    across,
    cross,
    dot,
    larger,
    minus,
    put,
    smaller,
    three,
)
from seamark.sim.numerics.arrays import Array, Integers
from seamark.sim.numerics.lanes import like, select, some, sqrt
from seamark.sim.numerics.uncounted import uncounted

MOTOR, FRICTION, LOWER, UPPER, COUPLING = 0, 1, 2, 3, 4


class Rows(NamedTuple):
    """r rows of joints in b places, and the degrees of freedom that rows and contacts move.

    `chain` are lists, of place j in row j, of pair p in row b + p. Each runs from tips to root, and
    `length` says where it ends. Its numbers are unsigned: Numba looks at every other one whether it
    counts from the end of an array.
    """

    kind: Integers  # (r,)
    place: Integers  # (r,) of the row
    motor: Integers  # (r,) which command it follows
    order: NDArray[np.uint64]  # (r,) rows by their places
    first: Integers  # (b + 1,) where those of a place begin in `order`
    speed: Integers  # (b,) degree of freedom
    other: Integers  # (b,) coupled degree of freedom, or -1
    coordinate: Integers  # (b,) its coordinate
    other_coordinate: Integers  # (b,)
    chain: NDArray[np.uint64]  # (b + m, c)
    length: Integers  # (b + m,)
    aside: Integers  # (m,) so many first places share no speed with the pair and later places
    side: Integers  # as `chain`: 1 if it moves the first shape alone, -1 the second, 0 both
    ratio: Array  # (b,) of the coupling: speed - ratio * other = 0
    most: Array  # (r,) [N m or N] largest effort; coordinate of a limit [rad or m]
    sliding: Array  # (r,) [N m or N] friction in motion
    stiffness: Array  # (r,) of a limit or a coupling [N m/rad or N/m]
    friction: Array  # (m,) coefficient of each pair
    spring: Array  # (m,) [N/m] of each pair


class Impulses(NamedTuple):
    """What the solver keeps from step to step."""

    joint: Array  # (r,) [N m s or N s]
    contact: Array  # (s, 3) [N s] along normal, and two directions across it


class Constraints(NamedTuple):
    """What ties links together: joints, shapes, and the impulses that act between them."""

    structure: Structure
    shapes: Shapes
    rows: Rows
    impulses: Impulses


class Moving(NamedTuple):
    """What moves in a step, and how it should."""

    q: Array  # (c,) coordinates
    v: Array  # (n,) speeds: those of the end of the step, changed by impulses
    before: Array  # (n,) those of its beginning
    command: Array  # (a,) speeds of the motors


class Timing(NamedTuple):
    """Length of a step [s], and how often the solver goes through its rows."""

    step_s: float
    iterations: int


class Solving(NamedTuple):
    """Memory of the solver."""

    w: Array  # (n,)
    x: Array  # (3, n) buffers
    basis: Array  # (b, c) rows of joints
    basis_size: Array  # (b,) their squared lengths
    wanted: Array  # (r,) speed that the row tends to, negative
    low: Array  # (r,) range of the impulse
    high: Array  # (r,)
    soft: Array  # (r,) compliance [rad/(N m s)]
    across: Array  # (s, 6) two directions of friction
    row: Array  # (3 s, c) rows of contacts
    size: Array  # (s, 2) effective inverse masses: normal, friction
    aim: Array  # (s, 2) speed that a contact tends to, negative; its compliance
    used: Integers  # (s,) slots in use, by their numbers
    pair_of: Integers  # (s,)
    in_use: Integers  # (1,) how many those are; the contact impulses of all others are zero


STICTION_SPEED = 1e-3  # [rad/s or m/s] E: below it friction at rest counts
# [1/kg] Least inverse mass in a direction. Nothing weighs so much: shapes cannot be moved in it, as
# those of a piston across its bore, and a force there would mean nothing.
IMMOVABLE = 1e-9
RELAXATION_S = 0.005  # E: damper over spring of contacts, limits and couplings
# E: by so much do shapes approach each other faster than their links have moved through the water:
# the current, turns and impulses of a step. What cannot touch by the end of a step gets no rows.
SUDDEN_M_S = 1.0


@njit(cache=True, error_model="numpy", inline="always")
def _half_solve(chain: int, structure: Structure, rows: Rows, frames: Frames, x: Array) -> None:
    """Replace J by J L^-1 in x[0], (n,), on a chain; what follows multiplies by D^(-1/2)."""
    for k in range(rows.length[chain]):
        i = rows.chain[chain, k]
        value, j = x[0, i], structure.above[i]
        while j >= 0:
            x[0, j] -= frames.factor[i, j] * value
            j = structure.above[j]


@njit(cache=True, error_model="numpy", inline="always")
def _half_solve_three(
    chain: int, structure: Structure, rows: Rows, frames: Frames, x: Array
) -> None:
    """Do to each row of x, (3, n), what `_half_solve` does to the first."""
    for k in range(rows.length[chain]):
        i = rows.chain[chain, k]
        one, two, three = x[0, i], x[1, i], x[2, i]
        j = structure.above[i]
        while j >= 0:
            factor = frames.factor[i, j]
            x[0, j] -= factor * one
            x[1, j] -= factor * two
            x[2, j] -= factor * three
            j = structure.above[j]


@njit(cache=True, error_model="numpy", inline="always")
def _prepare_places(structure: Structure, rows: Rows, frames: Frames, work: Solving) -> None:
    x = work.x
    for place in range(rows.speed.size):
        for k in range(rows.length[place]):
            x[0, rows.chain[place, k]] = 0.0
        x[0, rows.speed[place]] = 1.0
        if rows.other[place] >= 0:
            x[0, rows.other[place]] = -rows.ratio[place]
        _half_solve(place, structure, rows, frames, x)
        size = like(x[0, 0], 0.0)
        for k in range(rows.length[place]):
            i = rows.chain[place, k]
            value = x[0, i] * frames.inverse_scale[i]
            work.basis[place, k] = value
            size += value * value
        work.basis_size[place] = size


@njit(cache=True, error_model="numpy", inline="always")
def _prepare_joints(
    rows: Rows,
    moving: Moving,
    step_s: float,
    impulses: Impulses,
    work: Solving,
) -> None:
    q = moving.q
    infinite = np.inf
    for r in range(rows.kind.size):
        kind, place = rows.kind[r], rows.place[r]
        most = rows.most[r]
        zero = like(most, 0.0)
        wanted, low, high, soft = zero, zero, zero, zero
        at = rows.coordinate[place]
        share, give = soft_row(rows.stiffness[r], step_s)
        if kind == MOTOR:
            wanted = -moving.command[rows.motor[r]]
            low, high = -step_s * most, step_s * most
        elif kind == FRICTION:
            resting = abs(moving.before[rows.speed[place]]) < STICTION_SPEED
            most = select(resting, most, rows.sliding[r])
            low, high = -step_s * most, step_s * most
        elif kind == COUPLING:
            error = q[at] - rows.ratio[place] * q[rows.other_coordinate[place]]
            wanted, soft = error * (share / step_s), give
            low, high = zero - infinite, zero + infinite
        else:
            gap = q[at] - most if kind == LOWER else most - q[at]
            free = gap > 0.0
            aim = select(free, gap, gap * share) / step_s
            soft = select(free, 0.0, give)
            wanted = aim if kind == LOWER else -aim
            low = zero if kind == LOWER else zero - infinite
            high = zero + infinite if kind == LOWER else zero
        work.wanted[r], work.low[r], work.high[r], work.soft[r] = wanted, low, high, soft
        impulses.joint[r] = smaller(larger(impulses.joint[r], low), high)


@uncounted
def soft_row(stiffness: float, step_s: float) -> tuple[float, float]:
    """Return the share of an error that a spring takes back in a step, and its compliance.

    Force k (x + h v) + d v over a step h with d = k RELAXATION_S, as an impulse at the end of the
    step: Catto 2011, Soft constraints.
    """
    return step_s / (step_s + RELAXATION_S), 1.0 / (step_s * stiffness * (step_s + RELAXATION_S))


@njit(cache=True, error_model="numpy", inline="always")
def _write_rows(
    slot: int,
    chain: int,
    directions: tuple[Vector, Vector, Vector],
    point: Vector,
    constraints: Constraints,
    frames: Frames,
    work: Solving,
) -> tuple[float, float, float]:
    """Write the rows of a contact in three directions; return their squared lengths."""
    structure, rows = constraints.structure, constraints.rows
    normal, one, two = directions
    x, zero = work.x, like(point[0], 0.0)
    for k in range(rows.length[chain]):
        i = rows.chain[chain, k]
        link, moved = structure.link[i], (zero, zero, zero)
        if rows.side[chain, k] != 0:
            way, kind = three(frames.axis, i, 0), structure.joint[link]
            if not (kind == PRISMATIC or (kind == FREE and i < structure.speed[link] + 3)):
                way = cross(way, minus(point, three(frames.position, link, 0)))
            moved = (dot(way, normal), dot(way, one), dot(way, two))
            if rows.side[chain, k] < 0:
                moved = (-moved[0], -moved[1], -moved[2])
        x[0, i], x[1, i], x[2, i] = moved[0], moved[1], moved[2]
    _half_solve_three(chain, structure, rows, frames, x)
    along, first, second = zero, zero, zero
    row = 3 * slot
    for k in range(rows.length[chain]):
        i = rows.chain[chain, k]
        scale = frames.inverse_scale[i]
        a, b, c = x[0, i] * scale, x[1, i] * scale, x[2, i] * scale
        work.row[row, k] = a
        work.row[row + 1, k] = b
        work.row[row + 2, k] = c
        along += a * a
        first += b * b
        second += c * c
    return along, first, second


@njit(cache=True, error_model="numpy", inline="always")
def _prepare_contacts(
    constraints: Constraints, step_s: float, frames: Frames, touches: Touches, work: Solving
) -> int:
    """Write the rows of all slots in use; return how many those are."""
    shapes, rows, impulses = constraints.shapes, constraints.rows, constraints.impulses
    count, cleared = 0, 0
    for pair in range(shapes.first.size):
        if not touches.near[pair]:
            continue
        chain = rows.speed.size + pair
        margin = _within_reach(pair, shapes, step_s, frames)
        for slot in range(shapes.slot[pair], shapes.slot[pair + 1]):
            near = touches.gap[slot] < margin
            if not some(near):
                continue
            touches.gap[slot] = select(near, touches.gap[slot], 2.0 * MARGIN_M)
            _clear(cleared, slot, impulses)
            cleared = slot + 1
            for a in range(3):
                impulses.contact[slot, a] = select(near, impulses.contact[slot, a], 0.0)
            work.used[count] = slot
            work.pair_of[count] = pair
            count += 1
            point, normal = three(touches.point, slot, 0), three(touches.normal, slot, 0)
            one = across(normal)
            two = cross(normal, one)
            put(work.across, slot, 0, one)
            put(work.across, slot, 3, two)
            directions = (normal, one, two)
            lengths = _write_rows(slot, chain, directions, point, constraints, frames, work)
            both = like(lengths[0], 0.0)
            for k in range(rows.length[chain]):
                both += work.row[3 * slot + 1, k] * work.row[3 * slot + 2, k]
            # Both directions of friction change together: the larger eigenvalue of their block.
            half = 0.5 * (lengths[1] - lengths[2])
            gap = touches.gap[slot]
            free = gap > 0.0
            share, give = soft_row(rows.spring[pair], step_s)
            soft = select(free, 0.0, give)
            least = like(gap, IMMOVABLE)
            work.size[slot, 0] = larger(lengths[0] + soft, least)
            mean = 0.5 * (lengths[1] + lengths[2])
            work.size[slot, 1] = larger(mean + sqrt(half * half + both * both), least)
            work.aim[slot, 0] = select(free, gap, gap * share) / step_s
            work.aim[slot, 1] = soft
    _clear(cleared, shapes.slot[shapes.first.size], impulses)
    work.in_use[0] = count
    return count


@njit(cache=True, error_model="numpy", inline="always")
def _within_reach(pair: int, shapes: Shapes, step_s: float, frames: Frames) -> float:
    """Return the gap [m] above which a pair cannot touch by the end of a step."""
    speed = like(frames.twist[0, 0], SUDDEN_M_S)
    for shape in (shapes.first[pair], shapes.second[pair]):
        link = shapes.link[shape]
        if link != WORLD:
            moving = three(frames.twist, link, 0)
            speed += sqrt(dot(moving, moving))
    return smaller(step_s * speed, like(speed, MARGIN_M))


@njit(cache=True, error_model="numpy", inline="always")
def _clear(first: int, last: int, impulses: Impulses) -> None:
    """Let no impulses act in slots from the first on, up to but not including the last."""
    zero = like(impulses.contact[0, 0], 0.0)
    for slot in range(first, last):
        for a in range(3):
            impulses.contact[slot, a] = zero


@njit(cache=True, error_model="numpy", inline="always")
def _product(matrix: Array, row: int, chain: int, rows: Rows, w: Array) -> float:
    value = like(w[0], 0.0)
    for k in range(rows.length[chain]):
        value += matrix[row, k] * w[rows.chain[chain, k]]
    return value


@njit(cache=True, error_model="numpy", inline="always")
def _push(matrix: Array, row: int, chain: int, impulse: float, rows: Rows, w: Array) -> None:
    for k in range(rows.length[chain]):
        w[rows.chain[chain, k]] += matrix[row, k] * impulse


@njit(cache=True, error_model="numpy", inline="always")
def _push_and_products(
    matrix: Array, row: int, chain: int, impulse: float, rows: Rows, w: Array
) -> tuple[float, float]:
    """Push by one row; return what `_product` then gives for the two rows after it."""
    one, two = like(impulse, 0.0), like(impulse, 0.0)
    for k in range(rows.length[chain]):
        i = rows.chain[chain, k]
        value = w[i] + matrix[row, k] * impulse
        w[i] = value
        one += matrix[row + 1, k] * value
        two += matrix[row + 2, k] * value
    return one, two


@njit(cache=True, error_model="numpy", inline="always")
def _push_two(
    matrix: Array,
    row: int,
    chain: int,
    impulses: tuple[float, float],
    rows: Rows,
    w: Array,
) -> None:
    """Push by one row and then by the one after it."""
    one, two = impulses
    for k in range(rows.length[chain]):
        i = rows.chain[chain, k]
        w[i] = (w[i] + matrix[row, k] * one) + matrix[row + 1, k] * two


@njit(cache=True, error_model="numpy", inline="always")
def _rests(kind: int, change: float, old: float) -> bool:
    """Return whether a row is a limit from which a joint stays away: its impulse remains zero."""
    if kind == LOWER:
        return not some((change < 0.0) | (old != 0.0))
    if kind == UPPER:
        return not some((change > 0.0) | (old != 0.0))
    return False


@njit(cache=True, error_model="numpy", inline="always")
def _solve_place(place: int, rows: Rows, impulses: Impulses, work: Solving) -> None:
    """Change the impulses in one place of joints, and the speeds by them."""
    size = work.basis_size[place]
    speed = _product(work.basis, place, place, rows, work.w)
    given = like(speed, 0.0)
    # Rows of one place change one speed: it is read and written once for all of them.
    for k in range(rows.first[place], rows.first[place + 1]):
        r = rows.order[k]
        old, soft = impulses.joint[r], work.soft[r]
        change = ((speed + given * size) + work.wanted[r]) + soft * old
        if _rests(rows.kind[r], change, old):
            continue
        new = old - change / (size + soft)
        new = smaller(larger(new, work.low[r]), work.high[r])
        impulses.joint[r] = new + 0.0
        given += new - old
    _push(work.basis, place, place, given, rows, work.w)


@njit(cache=True, error_model="numpy", inline="always")
def _acts(impulses: Vector) -> bool:
    return some((impulses[0] != 0.0) | (impulses[1] != 0.0) | (impulses[2] != 0.0))


@njit(cache=True, error_model="numpy", inline="always")
def _solve_contact(at: int, rows: Rows, impulses: Impulses, work: Solving, gap: Array) -> None:
    """Change the impulses in one slot, and the speeds by them."""
    slot, pair = work.used[at], work.pair_of[at]
    chain = rows.speed.size + pair
    touching = gap[slot] < MARGIN_M
    row = 3 * slot
    old = impulses.contact[slot, 0]
    speed = _product(work.row, row, chain, rows, work.w)
    change = (speed + work.aim[slot, 0]) + work.aim[slot, 1] * old
    new = larger(old - change / work.size[slot, 0], like(old, 0.0))
    new = select(touching, new, 0.0)
    a, b = impulses.contact[slot, 1], impulses.contact[slot, 2]
    if not (_acts((old, a, b)) or some(new != 0.0)):
        return  # near, but not touching
    impulses.contact[slot, 0] = new
    along, beside = _push_and_products(work.row, row, chain, new - old, rows, work.w)
    # Friction across the normal.
    most = rows.friction[pair] * new
    size = work.size[slot, 1]
    x, y = a - along / size, b - beside / size
    length = sqrt(x * x + y * y)
    slides = length > most
    shorter = select(slides, most / select(slides, length, 1.0), 1.0)
    x, y = select(touching, x * shorter, 0.0), select(touching, y * shorter, 0.0)
    impulses.contact[slot, 1], impulses.contact[slot, 2] = x + 0.0, y + 0.0
    _push_two(work.row, row + 1, chain, (x - a, y - b), rows, work.w)


@njit(cache=True, error_model="numpy", inline="always")
def _places_aside(count: int, rows: Rows, work: Solving) -> int:
    """Return how many first places share no speed with contacts in use and later places."""
    aside = rows.speed.size
    for at in range(count):
        aside = min(aside, rows.aside[work.pair_of[at]])
    return aside


@njit(cache=True, error_model="numpy", inline="always")
def _begin(count: int, v: Array, constraints: Constraints, frames: Frames, work: Solving) -> None:
    """Write w of the speeds v, and apply the impulses of the last step."""
    above, rows, impulses = constraints.structure.above, constraints.rows, constraints.impulses
    w = work.w
    for i in range(above.size):
        value = v[i]
        j = above[i]
        while j >= 0:
            value += frames.factor[i, j] * v[j]
            j = above[j]
        w[i] = frames.scale[i] * value
    for place in range(rows.speed.size):
        given = like(w[0], 0.0)
        for k in range(rows.first[place], rows.first[place + 1]):
            given += impulses.joint[rows.order[k]]
        _push(work.basis, place, place, given, rows, w)
    for at in range(count):
        slot = work.used[at]
        chain = rows.speed.size + work.pair_of[at]
        if _acts(three(impulses.contact, slot, 0)):
            for a in range(3):
                _push(work.row, 3 * slot + a, chain, impulses.contact[slot, a], rows, w)


@uncounted
def apply_impulses(
    timing: Timing,
    constraints: Constraints,
    moving: Moving,
    frames: Frames,
    touches: Touches,
    work: Solving,
) -> None:
    """Change the speeds of the end of a step by all impulses.

    `frames` hold the factors of the mass matrix, `touches` the contacts of the step's beginning.
    """
    structure, rows, impulses = constraints.structure, constraints.rows, constraints.impulses
    _prepare_places(structure, rows, frames, work)
    _prepare_joints(rows, moving, timing.step_s, impulses, work)
    count = _prepare_contacts(constraints, timing.step_s, frames, touches, work)
    v = moving.v
    _begin(count, v, constraints, frames, work)
    # Joints before contacts; side by side where they share no speed, since a processor has idle
    # units while one operation waits for another.
    places = rows.speed.size
    aside = _places_aside(count, rows, work)
    for _ in range(timing.iterations):
        for k in range(max(aside, places - aside + count)):
            if k < aside:
                _solve_place(k, rows, impulses, work)
            other = k + aside
            if other < places:
                _solve_place(other, rows, impulses, work)
            elif other < places + count:
                _solve_contact(other - places, rows, impulses, work, touches.gap)
    above = structure.above
    for i in range(above.size):
        value = work.w[i] * frames.inverse_scale[i]
        j = above[i]
        while j >= 0:
            value -= frames.factor[i, j] * v[j]
            j = above[j]
        v[i] = value + 0.0  # no -0.0: one mechanism skips a slot where lanes add zeros
