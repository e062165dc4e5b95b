"""What a vehicle without an arm touches: the impulses of its hull on bottom and box.

The plant integrates the vehicle; here a step's contact impulse is found from where it has come and
how fast it would go on, with its whole mass, rigid and added. A box that can be pushed is moved
here; it has its weight in water and no drag. Things in the world, such as a dock, stand still.
"""

from collections.abc import Sequence

import numpy as np
from numba import njit

from seamark.sim.multibody.assembly import VEHICLE, Mounting, hull_shapes, standing_shapes
from seamark.sim.multibody.contacts import find_touches, place_shapes
from seamark.sim.multibody.mechanism import (
    UNTURNED,
    Link,
    Mechanism,
    Shape,
    command_for,
    state_for,
    work_for,
)
from seamark.sim.multibody.solver import Constraints, Moving, Timing, apply_impulses
from seamark.sim.multibody.step import Command, Model, State, Work, move_coordinates, move_freely
from seamark.sim.multibody.tree import place
from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.borrowed import borrowed
from seamark.sim.numerics.compilation import SameTypes
from seamark.sim.numerics.libm import sincos
from seamark.sim.physics import constants
from seamark.sim.physics.contact import TargetBox
from seamark.sim.physics.dynamics import RIGID
from seamark.sim.physics.terrain import Bottom, Mounds
from seamark.sim.vehicles import STANDARD_GRAVITY, Vehicle, load

ITERATIONS = 30


class Hull:
    """The contacts of a vehicle's hull; see `physics.contact.Engine`."""

    def __init__(
        self,
        vehicle: Vehicle,
        bottom: Bottom,
        box: TargetBox | None,
        *,
        things: Sequence[Mounting] = (),
    ) -> None:
        """Put the box where it lies, and things whose links do not move where they stand."""
        self._moves = box is not None and not box.fixed
        self._model = _mechanism(vehicle, box, things).model(constants.STEP_S.scalar)
        self._state = state_for(self._model)
        self._work = work_for(self._model)
        self._none = command_for(self._model)
        self._ground = bottom.ground()
        self._box = box
        self._push = SameTypes(push_hull)
        if self._moves and box is not None:
            s, c = sincos(0.5 * box.yaw)
            self._state.q[7:14] = *box.centre, c, 0.0, 0.0, s

    @property
    def impulses(self) -> Array:
        """Return those of the last step, from which the next one starts, (k, 3): a view."""
        return self._state.impulses.contact

    def step(self, before: Array, after: Array, step_s: float) -> Array:
        """Return the impulse of all contacts on the hull, like `Contact.impulse`."""
        out = np.empty(6)
        self._push.call(
            Timing(step_s, ITERATIONS),
            self._model,
            self._state,
            self._none,
            after,
            self._ground,
            self._work,
            out,
        )
        return out

    def box_pose(self) -> tuple[Array, Array]:
        """Return position (3,) and quaternion w x y z (4,) of the box."""
        if self._moves:
            return self._state.q[7:10].copy(), self._state.q[10:14].copy()
        if self._box is None:
            raise LookupError("there is no box")
        s, c = sincos(0.5 * self._box.yaw)
        return np.array(self._box.centre), np.array([c, 0.0, 0.0, s])

    def box_speed(self) -> float:
        """Return the largest component of the box's velocity [m/s, rad/s]; zero for a fixed one."""
        return float(np.abs(self._state.v[6:]).max()) if self._moves else 0.0

    def close(self) -> None:
        """There is nothing to release."""


def warm_up() -> None:
    """Load or compile what contacts need, so that forked processes start at once."""
    vehicle = load("bluerov2-heavy")
    hull = Hull(vehicle, Bottom(1.0), TargetBox(centre=(0.0, 0.0, 0.9)))
    state = np.zeros(RIGID)
    state[3] = 1.0
    hull.step(state, state, constants.STEP_S.scalar)


def _mechanism(vehicle: Vehicle, box: TargetBox | None, things: Sequence[Mounting]) -> Mechanism:
    friction = constants.FRICTION.scalar
    hull = hull_shapes(vehicle)
    links = [Link(name=VEHICLE, rigid=vehicle.mass_rigid(), added=vehicle.mass_added())]
    ground = Shape(name="bottom", kind="ground", friction=friction)
    shapes, touching = [*hull, ground], ["bottom"]
    pairs = []
    if box is not None:
        a, b, c = box.size
        s, cosine = sincos(box.yaw)
        half = (0.5 * a, 0.5 * b, 0.5 * c)
        if not box.fixed:
            inertia = [b * b + c * c, a * a + c * c, a * a + b * b]
            displaced = constants.WATER_DENSITY.scalar * a * b * c
            links.append(
                Link(
                    name="box",
                    rigid=box.mass * np.diag([1.0, 1.0, 1.0, *(i / 12.0 for i in inertia)]),
                    net_weight=(box.mass - displaced) * STANDARD_GRAVITY,
                )
            )
            pairs.append(("box", "bottom"))
        shapes.append(
            Shape(
                name="box",
                kind="box",
                link=None if box.fixed else "box",
                place=box.centre if box.fixed else (0.0, 0.0, 0.0),
                turn=((cosine, -s, 0.0), (s, cosine, 0.0), (0.0, 0.0, 1.0))
                if box.fixed
                else UNTURNED,
                size=half,
                friction=friction,
            )
        )
        touching.append("box")
    pairs += [(piece.name, other) for piece in hull for other in touching]
    standing = [shape for thing in things for shape in standing_shapes(thing)]
    shapes += standing
    pairs += [(shape.name, piece.name) for shape in standing for piece in hull]
    return Mechanism(links=links, shapes=shapes, pairs=pairs)


@njit(cache=True, error_model="numpy")
def push_hull(
    timing: Timing,
    model: Model,
    state: State,
    command: Command,
    after: Array,
    ground: Mounds,
    work: Work,
    out: Array,
) -> None:
    """Write the impulse on the hull, (6,) in its axes, and move the box; `after` is the plant's."""
    model, state, work = borrowed(model), borrowed(state), borrowed(work)
    step_s = timing.step_s
    q, v, frames, structure = state.q, state.v, work.frames, model.structure
    for i in range(7):
        q[i] = after[i]
    for i in range(6):
        v[i] = after[7 + i]
    place(structure, model.links, q, frames)
    move_freely(step_s, structure, model.links, v, work)
    for i in range(6):
        v[i] = after[7 + i]  # the plant has moved the vehicle
    place_shapes(model.shapes, frames, work.touches)
    find_touches(model.shapes, ground, work.touches)
    constraints = Constraints(structure, model.shapes, model.rows, state.impulses)
    moving = Moving(q, v, v, command.speed)  # no joint has friction, which asks for those before
    apply_impulses(timing, constraints, moving, frames, work.touches, work.solving)
    for i in range(6):
        out[i] = 0.0
        for j in range(6):
            out[i] += model.links.mass[0, i, j] * (v[j] - after[7 + j])
    move_coordinates(step_s, structure, state, frames)
