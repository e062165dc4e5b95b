"""What joints transmit and shapes feel: the readings behind force, torque and touch sensors."""

from numba import njit

from seamark.sim.multibody.solver import Timing
from seamark.sim.multibody.step import Model, State, Work
from seamark.sim.multibody.tree import FREE, REVOLUTE, WORLD, in_parent
from seamark.sim.multibody.vectors import (
    Vector,
    cross,
    minus,
    plus,
    put,
    rotate_back,
    six_times,
    three,
    times,
)
from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.lanes import like
from seamark.sim.numerics.uncounted import uncounted


@uncounted
def write_loads(
    timing: Timing, model: Model, state: State, work: Work, out: Array, first: int = 0
) -> None:
    """Write the wrench that each joint has transmitted to its link in the last step.

    Parameters
    ----------
    state, work
        As that step left them.
    out : (k, 6) [N, N m]
        About the link's origin in its axes, from its parent; of a free link what is left over,
        which is zero but for rounding, if nothing but water, weight, thrusters and contacts act.
    first
        Of the links before this one nothing is written.
    """
    parents = model.structure.parent
    for i in range(parents.size):
        _accelerate(i, parents[i], model, work)
    _write_inertia(first, model, work)
    _take_contacts(first, timing.step_s, model, state, work)
    for i in range(parents.size - 1, first - 1, -1):
        for a in range(6):
            out[i, a] = work.frames.wrench[i, a] + work.frames.twist[i, a]
        if parents[i] >= first:
            _hand_on(i, parents[i], work)


@njit(cache=True, error_model="numpy", inline="always")
def _hand_on(i: int, parent: int, work: Work) -> None:
    """Add to a parent what a link needs."""
    frames = work.frames
    force, torque = in_parent(i, three(frames.twist, i, 0), three(frames.twist, i, 3), frames)
    for a in range(3):
        frames.twist[parent, a] += force[a]
        frames.twist[parent, 3 + a] += torque[a]


@njit(cache=True, error_model="numpy", inline="always")
def _accelerate(i: int, parent: int, model: Model, work: Work) -> None:
    """Write the acceleration of a link beside the bias: its parent's, and that of its joint."""
    frames, first = work.frames, model.structure.speed[i]
    if model.structure.joint[i] == FREE:
        for a in range(6):
            frames.acceleration[i, a] = work.acceleration[first + a]
        return
    rate = work.acceleration[first]
    own = times(three(model.links.axis, i, 0), rate)
    zero = like(rate, 0.0)
    linear, turning = (zero, zero, zero), (zero, zero, zero)
    if parent != WORLD:
        linear = three(frames.acceleration, parent, 0)
        turning = three(frames.acceleration, parent, 3)
        linear = plus(linear, cross(turning, three(frames.arm, i, 0)))
        linear, turning = (
            rotate_back(frames.turned, i, linear),
            rotate_back(frames.turned, i, turning),
        )
    if model.structure.joint[i] == REVOLUTE:
        turning = plus(turning, own)
    else:
        linear = plus(linear, own)
    put(frames.acceleration, i, 0, linear)
    put(frames.acceleration, i, 3, turning)


@njit(cache=True, error_model="numpy", inline="always")
def _write_inertia(first: int, model: Model, work: Work) -> None:
    """Write what each link by itself needs for its acceleration, over its twist."""
    frames = work.frames
    for i in range(first, model.structure.parent.size):
        linear, turning = three(frames.acceleration, i, 0), three(frames.acceleration, i, 3)
        force, torque = six_times(model.links.mass, i, linear, turning)
        put(frames.twist, i, 0, force)
        put(frames.twist, i, 3, torque)


@njit(cache=True, error_model="numpy", inline="always")
def _take_contacts(first: int, step_s: float, model: Model, state: State, work: Work) -> None:
    """Take away what contacts give to each link."""
    shapes, solving = model.shapes, work.solving
    for at in range(solving.in_use[0]):
        slot, pair = solving.used[at], solving.pair_of[at]
        force = contact_force(slot, step_s, state, work)
        point = three(work.touches.point, slot, 0)
        one, other = shapes.link[shapes.first[pair]], shapes.link[shapes.second[pair]]
        if one >= first:
            _take(one, force, point, work)
        if other >= first:
            _take(other, times(force, -1.0), point, work)


@njit(cache=True, error_model="numpy", inline="always")
def contact_force(slot: int, step_s: float, state: State, work: Work) -> Vector:
    """Return the force on the first shape in a slot in the last step, world axes [N]."""
    given = state.impulses.contact
    along = times(three(work.touches.normal, slot, 0), given[slot, 0] / step_s)
    one = times(three(work.solving.across, slot, 0), given[slot, 1] / step_s)
    two = times(three(work.solving.across, slot, 3), given[slot, 2] / step_s)
    return plus(along, plus(one, two))


@njit(cache=True, error_model="numpy", inline="always")
def _take(link: int, force: Vector, point: Vector, work: Work) -> None:
    frames = work.frames
    arm = rotate_back(frames.rotation, link, minus(point, three(frames.position, link, 0)))
    own = rotate_back(frames.rotation, link, force)
    torque = cross(arm, own)
    for a in range(3):
        frames.twist[link, a] -= own[a]
        frames.twist[link, 3 + a] -= torque[a]


@uncounted
def write_pair_forces(timing: Timing, model: Model, state: State, work: Work, out: Array) -> None:
    """Write the sum of the normal forces in each pair of shapes in the last step, (m,) [N]."""
    for pair in range(model.shapes.first.size):
        out[pair] = like(out[pair], 0.0)
        for slot in range(model.shapes.slot[pair], model.shapes.slot[pair + 1]):
            out[pair] += state.impulses.contact[slot, 0] / timing.step_s
