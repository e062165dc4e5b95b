"""One step of a mechanism in water: semi-implicit, with all impulses at its end."""

from typing import NamedTuple

from numba import njit

from seamark.sim.multibody.contacts import Shapes, Touches, find_touches, place_shapes
from seamark.sim.multibody.solver import (
    Constraints,
    Impulses,
    Moving,
    Rows,
    Solving,
    Timing,
    apply_impulses,
)
from seamark.sim.multibody.tree import (
    FREE,
    WORLD,
    Frames,
    Links,
    Structure,
    factorise,
    place,
    solve,
    turn_at_the_middle,
    write_bias,
    write_mass,
)
from seamark.sim.multibody.vectors import (
    cross,
    dot,
    plus,
    put,
    rotate,
    rotate_back,
    three,
    times,
)
from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.lanes import like, sqrt
from seamark.sim.numerics.uncounted import uncounted
from seamark.sim.physics.current import Water, at_depth, flow, segment_at, segment_of
from seamark.sim.physics.terrain import Mounds


class Thrusters(NamedTuple):
    """The thrusters of link 0."""

    allocation: Array  # (6, m) wrench of each unit thrust about its origin
    lag: Array  # (1,) share of a change of thrust that a step makes


class Model(NamedTuple):
    """What does not change while a mechanism moves."""

    structure: Structure
    links: Links
    shapes: Shapes
    rows: Rows
    thrusters: Thrusters


class State(NamedTuple):
    """What changes: all that the next step depends on."""

    q: Array  # (c,) coordinates [m, 1, rad]
    v: Array  # (n,) speeds over ground; of a free link its twist in its own axes [m/s, rad/s]
    thrust: Array  # (m,) [N]
    impulses: Impulses


class Command(NamedTuple):
    """What is held over a step."""

    thrust: Array  # (m,) [N] steady thrusts
    speed: Array  # (a,) of each motor [rad/s or m/s]


class Work(NamedTuple):
    """Memory of one thread."""

    frames: Frames
    touches: Touches
    solving: Solving
    wrench: Array  # (6,)
    x: Array  # (n,)
    before: Array  # (n,) speeds at the beginning of the step
    acceleration: Array  # (n,) v' of the last step, see `tree`, relative to the water


@uncounted
def advance(
    span: tuple[int, int],
    timing: Timing,
    model: Model,
    state: State,
    command: Command,
    water: Water,
    ground: Mounds,
    work: Work,
) -> None:
    """Advance one mechanism; `span` is the number of steps since the level began, and to make."""
    first, steps = span
    for done in range(steps):
        t = (first + done) * timing.step_s + 0.5 * timing.step_s
        place_in_water(t, model, state, water, work)
        take_step(t, timing, model, state, command, water, ground, work)


@uncounted
def place_in_water(t: float, model: Model, state: State, water: Water, work: Work) -> None:
    """Place the links of one mechanism, and choose the segments of the water at time t [s]."""
    structure, frames = model.structure, work.frames
    place(structure, model.links, state.q, frames)
    grid = (water.top, water.spacing)
    for i in range(structure.parent.size):
        if structure.parent[i] == WORLD:
            segment = segment_at(t, frames.position[i, 2], water.law, grid, water.drift)
            for j in range(len(segment)):
                frames.segment[i, j] = segment[j]


@uncounted
def take_step(
    middle: float,
    timing: Timing,
    model: Model,
    state: State,
    command: Command,
    water: Water,
    ground: Mounds,
    work: Work,
) -> None:
    """Advance a mechanism, or lanes of them, in place by one step around the time `middle` [s].

    It has been placed, and the segments of its water have been chosen for that time.
    """
    structure, frames, step_s = model.structure, work.frames, timing.step_s
    _write_streams(middle, structure, water, frames)
    _write_push(model.thrusters, state.thrust, command.thrust, work.wrench)
    free, before = work.x, work.before
    for j in range(before.size):
        before[j] = state.v[j]
    move_freely(step_s, structure, model.links, state.v, work)
    for j in range(free.size):
        free[j] = state.v[j]
    place_shapes(model.shapes, frames, work.touches)
    find_touches(model.shapes, ground, work.touches)
    constraints = Constraints(structure, model.shapes, model.rows, state.impulses)
    moving = Moving(state.q, state.v, before, command.speed)
    apply_impulses(timing, constraints, moving, frames, work.touches, work.solving)
    for j in range(free.size):
        work.acceleration[j] += (state.v[j] - free[j]) / step_s
    move_coordinates(step_s, structure, state, frames)


@njit(cache=True, error_model="numpy", inline="always")
def _write_streams(t: float, structure: Structure, water: Water, frames: Frames) -> None:
    """Write the water of each tree at the depth of its root; see `physics.dynamics`.

    Link 0 is a root. What `flow` returns is the same at all depths.
    """
    law = (water.law, water.shear, water.bottom, water.height)
    flowing = flow(t, water, segment_of(frames.segment, 0))
    for i in range(structure.parent.size):
        if structure.parent[i] != WORLD:
            continue
        segment = segment_of(frames.segment, i)
        moving = at_depth(t, frames.position[i, 2], flowing, law, segment)
        put(frames.stream, i, 0, moving[0:3])
        put(frames.stream, i, 3, moving[3:6])
        put(frames.stream, i, 6, moving[6:9])


@njit(cache=True, error_model="numpy", inline="always")
def _write_push(thrusters: Thrusters, thrust: Array, target: Array, wrench: Array) -> None:
    """Let the thrusts follow their targets, and write their wrench, (6,)."""
    for j in range(thrust.size):
        thrust[j] += (target[j] - thrust[j]) * thrusters.lag[0]
    for i in range(6):
        push = like(wrench[0], 0.0)
        for j in range(thrust.size):
            push += thrusters.allocation[i, j] * thrust[j]
        wrench[i] = push


@uncounted
def move_freely(step_s: float, structure: Structure, links: Links, v: Array, work: Work) -> None:
    """Change the speeds by a step without motors, joint friction and contacts.

    `place` has been called, `work.wrench` is the push of the thrusters. The speeds of a free link
    remain in its axes of the step's beginning.
    """
    frames, acceleration = work.frames, work.acceleration
    write_bias(structure, links, v, work.wrench, frames)
    write_mass(structure, links, frames)
    factorise(structure, frames)
    turn_at_the_middle(step_s, structure, frames)
    for j in range(v.size):
        acceleration[j] = -frames.bias[j]
    solve(structure, frames, acceleration)
    for j in range(v.size):
        v[j] += step_s * acceleration[j]
    for i in range(structure.parent.size):
        if structure.joint[i] == FREE:
            at = structure.speed[i]
            rise = rotate_back(frames.rotation, i, three(frames.stream, i, 3))
            for a in range(3):
                v[at + a] += step_s * rise[a]


@njit(cache=True, error_model="numpy", inline="always")
def move_coordinates(step_s: float, structure: Structure, state: State, frames: Frames) -> None:
    """Move the coordinates by a step at the speeds of its end."""
    q, v = state.q, state.v
    for i in range(structure.parent.size):
        c, s = structure.coordinate[i], structure.speed[i]
        if structure.joint[i] != FREE:
            q[c] += step_s * v[s]
            continue
        way = rotate(frames.rotation, i, (v[s], v[s + 1], v[s + 2]))
        for a in range(3):
            q[c + a] += step_s * way[a]
        # The half angle's tangent along the axis: tan x = x (1 + x²/3 + ...).
        half = times((v[s + 3], v[s + 4], v[s + 5]), 0.5 * step_s)
        size = half[0] * half[0] + half[1] * half[1] + half[2] * half[2]
        turn_x, turn_y, turn_z = times(half, 1.0 + size * (1.0 / 3.0))
        w, x, y, z = q[c + 3], q[c + 4], q[c + 5], q[c + 6]
        w_new = w - x * turn_x - y * turn_y - z * turn_z
        x_new = x + w * turn_x + y * turn_z - z * turn_y
        y_new = y + w * turn_y + z * turn_x - x * turn_z
        z_new = z + w * turn_z + x * turn_y - y * turn_x
        length = sqrt(w_new * w_new + x_new * x_new + y_new * y_new + z_new * z_new)
        # The same turn takes the velocity into the new axes.
        turn, linear = (turn_x, turn_y, turn_z), (v[s], v[s + 1], v[s + 2])
        scale = 2.0 / (1.0 + dot(turn, turn))
        past = cross(linear, turn)
        back = plus(past, cross(past, turn))
        for a in range(3):
            v[s + a] += scale * back[a]
        q[c + 3], q[c + 4] = w_new / length, x_new / length
        q[c + 5], q[c + 6] = y_new / length, z_new / length
