"""Dynamics of a forest of links in water: frames, bias forces, mass matrix and its factor.

    H(q) v' + c(q, v) = tau

Composite rigid bodies give H, recursive Newton-Euler gives c, and H is factored as L^T D L, which
has no fill-in when a joint is eliminated before its ancestors (Featherstone 2008, ch. 5 to 8). Each
link has a 6x6 mass of its own, rigid and added, which need not be a rigid body's. Twists are
(linear, angular) of the link's origin in the link's axes (Fossen 2021), wrenches likewise. v' of a
free link is the acceleration of its origin, not the change of the numbers of its twist, which also
change because the axes turn: `step.move_coordinates` does that.

Everything is written in a frame that moves with the water, as in `physics.dynamics`: the world
then moves with minus the current, so a link that is fixed to the world needs nothing special. If
the water accelerates, the inertia force of that frame and the pressure gradient act like gravity in
another direction.

The functions work on one mechanism or, with `numerics.lanes`, on eight of the same structure.
"""

from typing import NamedTuple

from numba import njit

from seamark.sim.multibody.memory import zeros
from seamark.sim.multibody.vectors import (
    Vector,
    column,
    cross,
    dot,
    minus,
    plus,
    put,
    rotate,
    rotate_back,
    six_times,
    smaller,
    three,
    times,
)
from seamark.sim.numerics.arrays import Array, Integers
from seamark.sim.numerics.lanes import like, sqrt
from seamark.sim.numerics.libm import sincos
from seamark.sim.numerics.uncounted import uncounted
from seamark.sim.physics.current import SEGMENT
from seamark.sim.vehicles import STANDARD_GRAVITY

FREE, REVOLUTE, PRISMATIC = 0, 1, 2
WORLD = -1  # the parent of a link that hangs on nothing
FREE_COORDINATES = 7  # position NED, quaternion w x y z
FREE_SPEEDS = 6  # twist over ground


class Structure(NamedTuple):
    """What mechanisms that move side by side have in common: k links, n degrees of freedom.

    Degrees of freedom are numbered from the root of a tree to its tips.
    """

    parent: Integers  # (k,) link, or WORLD
    joint: Integers  # (k,) FREE, REVOLUTE or PRISMATIC
    coordinate: Integers  # (k,) index of its first coordinate
    speed: Integers  # (k,) index of its first degree of freedom
    root: Integers  # (k,) the link of its tree that hangs on nothing
    above: Integers  # (n,) the degree of freedom before it on the way to the root, or -1
    link: Integers  # (n,) whose degree of freedom it is


class Links(NamedTuple):
    """The numbers of k links."""

    axis: Array  # (k, 3) unit vector of the joint, in the link's axes
    offset: Array  # (k, 3) [m] origin in the parent at coordinate zero
    turn: Array  # (k, 3, 3) rotation to the parent's axes at coordinate zero
    mass: Array  # (k, 6, 6) rigid and added [kg, kg m, kg m²]
    added: Array  # (k, 6, 6) the added part
    rotor: Array  # (k,) [kg m² or kg] inertia of the motor, as the joint feels it
    net_weight: Array  # (k,) [N] weight minus buoyancy
    moment: Array  # (k, 3) [N m] weight times its centre minus buoyancy times its centre
    linear: Array  # (k, 6) drag [N s/m, N m s] about `centre`
    quadratic: Array  # (k, 6) [N s²/m², N m s²]
    centre: Array  # (k, 3) [m] the point of the link whose velocity gives the drag
    steepest: Array  # (k, 6) [N s/m, N m s] most drag per speed that a step can follow


class Frames(NamedTuple):
    """Where the links are and what moves them: written in each step."""

    rotation: Array  # (k, 3, 3) to world axes
    position: Array  # (k, 3) [m] NED
    turned: Array  # (k, 3, 3) rotation to the parent's axes now
    arm: Array  # (k, 3) [m] origin in the parent now
    segment: Array  # (k, SEGMENT) of a root, see current.Segment
    stream: Array  # (k, 9) of a root: water's velocity, acceleration, change with depth; NED
    twist: Array  # (k, 6) relative to the water
    acceleration: Array  # (k, 6) of the twist but for that of the degrees of freedom
    wrench: Array  # (k, 6) that the joint transmits to the link
    composite: Array  # (k, 6, 6) mass of the link with all beyond it
    six: Array  # (3, 6) buffers
    bias: Array  # (n,) c
    factor: Array  # (n, n), see `factorise`
    scale: Array  # (n,) square root of D
    inverse_scale: Array  # (n,)
    axis: Array  # (n, 3) world axis of the degree of freedom


def frames_for(links: int, speeds: int, lanes: tuple[int, ...] = ()) -> Frames:
    """Return the memory for a structure of this size; two threads need two."""
    k, n = links, speeds
    sizes = {
        "rotation": (k, 3, 3),
        "position": (k, 3),
        "turned": (k, 3, 3),
        "arm": (k, 3),
        "segment": (k, SEGMENT),
        "stream": (k, 9),
        "twist": (k, 6),
        "acceleration": (k, 6),
        "wrench": (k, 6),
        "composite": (k, 6, 6),
        "six": (3, 6),
        "bias": (n,),
        "factor": (n, n),
        "scale": (n,),
        "inverse_scale": (n,),
        "axis": (n, 3),
    }
    return zeros(Frames, sizes, lanes)


@njit(cache=True, error_model="numpy", inline="always")
def _place_root(i: int, at: int, q: Array, to: Frames) -> None:
    """Write the frame of a free link."""
    w, x, y, z = q[at + 3], q[at + 4], q[at + 5], q[at + 6]
    r = to.rotation
    r[i, 0, 0] = 1.0 - 2.0 * (y * y + z * z)
    r[i, 0, 1] = 2.0 * (x * y - w * z)
    r[i, 0, 2] = 2.0 * (x * z + w * y)
    r[i, 1, 0] = 2.0 * (x * y + w * z)
    r[i, 1, 1] = 1.0 - 2.0 * (x * x + z * z)
    r[i, 1, 2] = 2.0 * (y * z - w * x)
    r[i, 2, 0] = 2.0 * (x * z - w * y)
    r[i, 2, 1] = 2.0 * (y * z + w * x)
    r[i, 2, 2] = 1.0 - 2.0 * (x * x + y * y)
    for a in range(3):
        to.position[i, a] = q[at + a]


@njit(cache=True, error_model="numpy", inline="always")
def _turn_joint(i: int, angle: float, links: Links, to: Frames) -> None:
    """Write the rotation of a revolute joint's link in its parent (Rodrigues)."""
    x, y, z = three(links.axis, i, 0)
    s, c = sincos(angle)
    d = 1.0 - c
    columns = (
        (c + d * x * x, d * x * y + s * z, d * x * z - s * y),
        (d * x * y - s * z, c + d * y * y, d * y * z + s * x),
        (d * x * z + s * y, d * y * z - s * x, c + d * z * z),
    )
    for b in range(3):
        turned = rotate(links.turn, i, columns[b])
        for a in range(3):
            to.turned[i, a, b] = turned[a]


@njit(cache=True, error_model="numpy", inline="always")
def _place_in_world(i: int, parent: int, offset: Vector, to: Frames) -> None:
    """Write the world frame of a link whose frame in its parent is known."""
    if parent == WORLD:
        put(to.position, i, 0, offset)
        for a in range(3):
            for b in range(3):
                to.rotation[i, a, b] = to.turned[i, a, b]
        return
    there = rotate(to.rotation, parent, offset)
    put(to.position, i, 0, plus(three(to.position, parent, 0), there))
    for b in range(3):
        turned = rotate(to.rotation, parent, column(to.turned, i, b))
        for a in range(3):
            to.rotation[i, a, b] = turned[a]


@njit(cache=True, error_model="numpy", inline="always")
def _place_joint(i: int, at: int, structure: Structure, links: Links, q: Array, to: Frames) -> None:
    """Write the frame of a joint's link, in its parent and in the world."""
    offset = three(links.offset, i, 0)
    if structure.joint[i] == REVOLUTE:
        _turn_joint(i, q[at], links, to)
    else:
        for a in range(3):
            for b in range(3):
                to.turned[i, a, b] = links.turn[i, a, b]
        along = rotate(links.turn, i, three(links.axis, i, 0))
        offset = plus(offset, times(along, q[at]))
    put(to.arm, i, 0, offset)
    _place_in_world(i, structure.parent[i], offset, to)


@uncounted
def place(structure: Structure, links: Links, q: Array, to: Frames) -> None:
    """Write the frames of all links at coordinates q, and the axes of the degrees of freedom."""
    for i in range(structure.parent.size):
        at, first = structure.coordinate[i], structure.speed[i]
        if structure.joint[i] == FREE:
            _place_root(i, at, q, to)
            for j in range(3):
                for a in range(3):
                    to.axis[first + j, a] = to.rotation[i, a, j]
                    to.axis[first + 3 + j, a] = to.rotation[i, a, j]
        else:
            _place_joint(i, at, structure, links, q, to)
            put(to.axis, first, 0, rotate(to.rotation, i, three(links.axis, i, 0)))


@njit(cache=True, error_model="numpy", inline="always")
def _move_root(i: int, first: int, v: Array, to: Frames) -> None:
    moving = rotate_back(to.rotation, i, three(to.stream, i, 0))
    for a in range(3):
        to.twist[i, a] = v[first + a] - moving[a]
        to.twist[i, 3 + a] = v[first + 3 + a]
        to.acceleration[i, 3 + a] = 0.0
    turning = cross(three(to.twist, i, 0), three(to.twist, i, 3))
    put(to.acceleration, i, 0, turning)


@njit(cache=True, error_model="numpy", inline="always")
def _move_joint(i: int, speed: float, structure: Structure, links: Links, to: Frames) -> None:
    parent, root = structure.parent[i], structure.root[i]
    if parent == WORLD:
        zero = like(speed, 0.0)
        still = (zero, zero, zero)
        linear, rates = minus(still, three(to.stream, root, 0)), still
        pushed, turned = minus(still, three(to.stream, root, 3)), still
    else:
        linear, rates = three(to.twist, parent, 0), three(to.twist, parent, 3)
        pushed, turned = three(to.acceleration, parent, 0), three(to.acceleration, parent, 3)
    arm = three(to.arm, i, 0)
    linear = rotate_back(to.turned, i, plus(linear, cross(rates, arm)))
    rates = rotate_back(to.turned, i, rates)
    pushed = rotate_back(to.turned, i, plus(pushed, cross(turned, arm)))
    turned = rotate_back(to.turned, i, turned)
    x, y, z = three(links.axis, i, 0)
    own = (speed * x, speed * y, speed * z)
    # The axes turn with the link: Featherstone's v x S q'.
    pushed_by_own = cross(rates, own)
    if structure.joint[i] == REVOLUTE:
        pushed = plus(pushed, cross(linear, own))
        turned = plus(turned, pushed_by_own)
        rates = plus(rates, own)
    else:
        pushed = plus(pushed, pushed_by_own)
        linear = plus(linear, own)
    put(to.twist, i, 0, linear)
    put(to.twist, i, 3, rates)
    put(to.acceleration, i, 0, pushed)
    put(to.acceleration, i, 3, turned)


@njit(cache=True, error_model="numpy", inline="always")
def _write_own_wrench(i: int, structure: Structure, links: Links, to: Frames) -> None:
    """Write the wrench that a link needs for its bias acceleration against water and weight."""
    root = structure.root[i]
    linear, rates = three(to.twist, i, 0), three(to.twist, i, 3)
    pushed, turned = three(to.acceleration, i, 0), three(to.acceleration, i, 3)
    push, spin = six_times(links.mass, i, linear, rates)  # momentum
    force, torque = six_times(links.mass, i, pushed, turned)  # of the bias acceleration
    force = plus(force, cross(rates, push))
    torque = plus(torque, plus(cross(rates, spin), cross(linear, push)))
    centre = three(links.centre, i, 0)
    past = plus(linear, cross(rates, centre))
    drag = _drag(links, i, 0, past)
    force = plus(force, drag)
    torque = plus(torque, cross(centre, drag))
    torque = plus(torque, _drag(links, i, 3, rates))
    # Vertical motion through sheared flow: only the added mass feels it, see `physics.dynamics`.
    sinking = dot((to.rotation[i, 2, 0], to.rotation[i, 2, 1], to.rotation[i, 2, 2]), linear)
    sheared = rotate_back(to.rotation, i, times(three(to.stream, root, 6), sinking))
    # Weight and buoyancy along the apparent vertical.
    tilt = -1.0 / STANDARD_GRAVITY
    rise = times(three(to.stream, root, 3), tilt)
    down = rotate_back(to.rotation, i, (rise[0], rise[1], rise[2] + 1.0))
    turning = cross(three(links.moment, i, 0), down)
    for a in range(3):
        felt, twisted = _added_times(links, i, a, sheared), _added_times(links, i, 3 + a, sheared)
        to.wrench[i, a] = (force[a] - felt) - links.net_weight[i] * down[a]
        to.wrench[i, 3 + a] = (torque[a] - twisted) - turning[a]


@njit(cache=True, error_model="numpy", inline="always")
def _added_times(links: Links, i: int, row: int, linear: Vector) -> float:
    """Return a row of the added mass of link i times a linear acceleration."""
    value: float = links.added[i, row, 0] * linear[0] + (
        links.added[i, row, 1] * linear[1] + links.added[i, row, 2] * linear[2]
    )
    return value


@njit(cache=True, error_model="numpy", inline="always")
def _drag(links: Links, i: int, first: int, v: Vector) -> Vector:
    """Return the drag of link i along three axes, as what the water takes from it."""
    x, y, z = v
    return (
        _drag_per_speed(links, i, first, x) * x,
        _drag_per_speed(links, i, first + 1, y) * y,
        _drag_per_speed(links, i, first + 2, z) * z,
    )


@njit(cache=True, error_model="numpy", inline="always")
def _drag_per_speed(links: Links, i: int, at: int, speed: float) -> float:
    """Return drag over speed, at most as much as stops the link in a step."""
    wanted = links.linear[i, at] + links.quadratic[i, at] * abs(speed)
    return smaller(wanted, links.steepest[i, at])


@njit(cache=True, error_model="numpy", inline="always")
def _pass_wrench(i: int, structure: Structure, links: Links, to: Frames) -> None:
    """Write the bias forces of a link's joint, and hand its wrench on to its parent."""
    first, parent = structure.speed[i], structure.parent[i]
    if structure.joint[i] == FREE:
        for a in range(6):
            to.bias[first + a] = to.wrench[i, a]
        return
    to.bias[first] = dot(three(links.axis, i, 0), three(to.wrench, i, _part(structure.joint[i])))
    if parent != WORLD:
        force, torque = in_parent(i, three(to.wrench, i, 0), three(to.wrench, i, 3), to)
        for a in range(3):
            to.wrench[parent, a] += force[a]
            to.wrench[parent, 3 + a] += torque[a]


@njit(cache=True, error_model="numpy", inline="always")
def _part(joint: int) -> int:
    """Return where the half of a twist begins along which a joint moves."""
    return 3 if joint == REVOLUTE else 0


@njit(cache=True, error_model="numpy", inline="always")
def in_parent(i: int, force: Vector, torque: Vector, to: Frames) -> tuple[Vector, Vector]:
    """Return a wrench about the origin of link i about that of its parent, in the parent's axes."""
    force, torque = rotate(to.turned, i, force), rotate(to.turned, i, torque)
    return force, plus(torque, cross(three(to.arm, i, 0), force))


@uncounted
def write_bias(structure: Structure, links: Links, v: Array, push: Array, to: Frames) -> None:
    """Write the bias forces c of all links at speeds v (n,); `place` has been called.

    `push` (6,) is a wrench on link 0 about its origin, as that of its thrusters [N, N m].
    """
    for i in range(structure.parent.size):
        first = structure.speed[i]
        if structure.joint[i] == FREE:
            _move_root(i, first, v, to)
        else:
            _move_joint(i, v[first], structure, links, to)
        _write_own_wrench(i, structure, links, to)
    for a in range(6):
        to.wrench[0, a] -= push[a]
    for i in range(structure.parent.size - 1, -1, -1):
        _pass_wrench(i, structure, links, to)


@njit(cache=True, error_model="numpy", inline="always")
def _turned_block(i: int, rows: int, columns: int, to: Frames) -> tuple[Vector, Vector, Vector]:
    """Return the rows of a 3x3 block of link i's composite mass in its parent's axes."""
    x, y, z = (
        _turned_part(i, rows, columns, to),
        _turned_part(i, rows, columns + 1, to),
        _turned_part(i, rows, columns + 2, to),
    )
    return (
        rotate(to.turned, i, (x[0], y[0], z[0])),
        rotate(to.turned, i, (x[1], y[1], z[1])),
        rotate(to.turned, i, (x[2], y[2], z[2])),
    )


@njit(cache=True, error_model="numpy", inline="always")
def _turned_part(i: int, row: int, at: int, to: Frames) -> Vector:
    """Return three numbers of a column of link i's composite mass in its parent's axes."""
    m = to.composite
    return rotate(to.turned, i, (m[i, row, at], m[i, row + 1, at], m[i, row + 2, at]))


@njit(cache=True, error_model="numpy", inline="always")
def _add_to_parent(i: int, parent: int, to: Frames) -> None:
    """Add the composite mass of link i to its parent's."""
    linear, angular = _turned_block(i, 0, 0, to), _turned_block(i, 3, 3, to)
    x, y, z = _turned_block(i, 0, 3, to)  # B
    composite, arm = to.composite, three(to.arm, i, 0)
    # The coupling block at the parent's origin: C = B - A [r]x, by rows.
    moved = (
        minus(x, cross(linear[0], arm)),
        minus(y, cross(linear[1], arm)),
        minus(z, cross(linear[2], arm)),
    )
    for a in range(3):
        for b in range(3):
            composite[parent, a, b] += linear[a][b]
            composite[parent, a, 3 + b] += moved[a][b]
            composite[parent, 3 + b, a] += moved[a][b]
    # [r]x C - B^T [r]x + D.
    for a in range(3):
        back = cross((x[a], y[a], z[a]), arm)
        for b in range(3):
            turned = cross(arm, (moved[0][b], moved[1][b], moved[2][b]))
            composite[parent, 3 + a, 3 + b] += (angular[a][b] + turned[a]) - back[b]


@njit(cache=True, error_model="numpy", inline="always")
def _write_joint_mass(i: int, structure: Structure, links: Links, to: Frames) -> None:
    """Write what links up to the root feel of the acceleration of a joint: its row of H."""
    first, part = structure.speed[i], _part(structure.joint[i])
    axis = three(links.axis, i, 0)
    force = (
        _along_axis(i, 0, part, axis, to),
        _along_axis(i, 1, part, axis, to),
        _along_axis(i, 2, part, axis, to),
    )
    torque = (
        _along_axis(i, 3, part, axis, to),
        _along_axis(i, 4, part, axis, to),
        _along_axis(i, 5, part, axis, to),
    )
    to.factor[first, first] = dot(torque if part else force, axis) + links.rotor[i]
    link = i
    while structure.parent[link] != WORLD:
        force, torque = in_parent(link, force, torque, to)
        link = structure.parent[link]
        above = structure.speed[link]
        if structure.joint[link] == FREE:
            put(to.factor, first, above, force)
            put(to.factor, first, above + 3, torque)
        else:
            along = torque if _part(structure.joint[link]) else force
            to.factor[first, above] = dot(three(links.axis, link, 0), along)


@njit(cache=True, error_model="numpy", inline="always")
def _along_axis(i: int, row: int, part: int, axis: Vector, to: Frames) -> float:
    """Return a row of link i's composite mass times a unit motion along its joint's axis."""
    x, y, z = axis
    value: float = to.composite[i, row, part] * x + (
        to.composite[i, row, part + 1] * y + to.composite[i, row, part + 2] * z
    )
    return value


@uncounted
def write_mass(structure: Structure, links: Links, to: Frames) -> None:
    """Write H to the lower triangle of `factor`, where a degree of freedom has those above it."""
    count = structure.parent.size
    for i in range(count):
        for a in range(6):
            for b in range(6):
                to.composite[i, a, b] = links.mass[i, a, b]
    for i in range(count - 1, -1, -1):
        if structure.joint[i] == FREE:
            _write_free_mass(i, structure.speed[i], to)
            continue
        _write_joint_mass(i, structure, links, to)
        if structure.parent[i] != WORLD:
            _add_to_parent(i, structure.parent[i], to)


@njit(cache=True, error_model="numpy", inline="always")
def _write_free_mass(i: int, first: int, to: Frames) -> None:
    for a in range(6):
        for b in range(a + 1):
            to.factor[first + a, first + b] = to.composite[i, a, b]


@uncounted
def factorise(structure: Structure, to: Frames) -> None:
    """Replace H by its factors: H = L^T D L, L of unit diagonal; D's root goes to `scale`."""
    above, h = structure.above, to.factor
    for k in range(above.size - 1, -1, -1):
        to.scale[k] = sqrt(h[k, k])
        to.inverse_scale[k] = 1.0 / to.scale[k]
        i = above[k]
        while i >= 0:
            share = h[k, i] / h[k, k]
            j = i
            while j >= 0:
                h[i, j] -= share * h[k, j]
                j = above[j]
            h[k, i] = share
            i = above[i]


@njit(cache=True, error_model="numpy", inline="always")
def solve(structure: Structure, to: Frames, x: Array) -> None:
    """Replace x by H^-1 x, (n,)."""
    above, factor = structure.above, to.factor
    for i in range(above.size - 1, -1, -1):
        value, j = x[i], above[i]
        while j >= 0:
            x[j] -= factor[i, j] * value
            j = above[j]
    for i in range(above.size):
        value, j = (x[i] * to.inverse_scale[i]) * to.inverse_scale[i], above[i]
        while j >= 0:
            value -= factor[i, j] * x[j]
            j = above[j]
        x[i] = value


@uncounted
def turn_at_the_middle(step_s: float, structure: Structure, to: Frames) -> None:
    """Let the bias of each tree as a whole be that of the middle of a step; H is factored.

    Forces that turn a momentum, taken from a step's beginning, would add energy to what tumbles.
    """
    for i in range(structure.parent.size):
        if structure.joint[i] != FREE:
            continue
        first = structure.speed[i]
        for a in range(6):
            to.six[2, a] = to.twist[i, a]
        _write_turning(i, 0, to)
        _answer(first, to)
        for a in range(6):
            to.six[2, a] = to.twist[i, a] + 0.5 * step_s * to.six[2, a]
        _write_turning(i, 1, to)
        for a in range(6):
            change = to.six[1, a] - to.six[0, a]
            to.bias[first + a] += change
            to.wrench[i, a] += change


@njit(cache=True, error_model="numpy", inline="always")
def _answer(first: int, to: Frames) -> None:
    """Write the acceleration of a free link to the bias six[0] to six[2]: `solve` of its part."""
    x, h = to.six, to.factor
    for a in range(6):
        x[2, a] = -x[0, a]
    for a in range(5, -1, -1):
        for b in range(a):
            x[2, b] -= h[first + a, first + b] * x[2, a]
    for a in range(6):
        scale = to.inverse_scale[first + a]
        x[2, a] = (x[2, a] * scale) * scale
        for b in range(a):
            x[2, a] -= h[first + a, first + b] * x[2, b]


@njit(cache=True, error_model="numpy", inline="always")
def _write_turning(i: int, at: int, to: Frames) -> None:
    """Write the bias of a tree as one body with the twist six[2] to six[at]; see `_move_root`."""
    six, mass = to.six, to.composite
    linear, rates = three(six, 2, 0), three(six, 2, 3)
    turning = cross(linear, rates)
    push, spin = six_times(mass, i, linear, rates)
    put(six, at, 0, cross(rates, push))
    put(six, at, 3, plus(cross(rates, spin), cross(linear, push)))
    for a in range(6):
        value = six[at, a]
        for b in range(3):
            value += mass[i, a, b] * turning[b]
        six[at, a] = value
