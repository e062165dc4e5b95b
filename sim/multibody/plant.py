"""A vehicle with an arm as a plant: moved as a mechanism, with the interface of `physics.plant`."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numba import njit

from seamark.sim.multibody.assembly import Assembly, Mounting, assemble, vehicle_link
from seamark.sim.multibody.loads import contact_force, write_loads
from seamark.sim.multibody.mechanism import command_for, work_for
from seamark.sim.multibody.solver import Timing
from seamark.sim.multibody.step import Command, Model, State, Work, place_in_water, take_step
from seamark.sim.multibody.tree import WORLD, place
from seamark.sim.multibody.vectors import Vector, cross, dot, minus, rotate, three
from seamark.sim.multibody.workpiece import (
    MEASURED,
    OTHER_MOTION,
    Workpiece,
    measure,
    points_of,
)
from seamark.sim.numerics.arrays import Array, Integers
from seamark.sim.numerics.compilation import SameTypes
from seamark.sim.numerics.uncounted import uncounted
from seamark.sim.physics.current import FORCE, Current, Water
from seamark.sim.physics.dynamics import RIGID
from seamark.sim.physics.plant import Plant
from seamark.sim.physics.terrain import Bottom, Mounds
from seamark.sim.physics.thruster_faults import ThrusterFault
from seamark.sim.physics.thrusters import steady_thrust
from seamark.sim.vehicles import Vehicle

STEP_S = 0.002  # S: measured against 1 and 4 ms, see docs/validation.md
ITERATIONS = 10  # of the contact solver; S: docs/validation.md
_FREE = 7  # coordinates of the vehicle


class Gauges(NamedTuple):
    """Where forces on a vehicle with an arm are measured, and the sums of what was."""

    link: Integers  # (1,) through whose joint the measured wrench goes, or WORLD
    point: Array  # (3,) [m] where it is measured, in the axes of that link
    turn: Array  # (3, 3) from the sensor's axes into the link's
    part: Integers  # (s,) of each shape: the number of its feeler, or one of HULL to OTHER
    loads: Array  # (k, 6) of each joint in the last step
    sums: Array  # (17 + a + f,) the fields of `Readings`, over steps
    force: Array  # (4,) on the hull, and on the arm, in one step


class Readings(NamedTuple):
    """Forces since the last call of `advance`: means, but for the peak."""

    wrench: Array  # (6,) [N, N m] in the sensor's axes: what the arm gives to its outer part there
    hull_n: Array  # (1,) magnitude of the contact force on the hull
    peak_n: Array  # (1,) contact forces on the arm from outside it, added up: most in a step
    push: Array  # (3,) [N] net contact force of the arm on the workpiece, world axes
    effort: Array  # (a,) [N m or N] of each motor
    touch_n: Array  # (f,) contact forces on each feeler, added up
    work_n: Array  # (3,) contact forces on the workpiece by arm, hull, and all else, added up
    other_n: Array  # (3,) the same on all other things that move freely


HULL, ARM, WORKPIECE, REST, OTHER = -1, -2, -3, -4, -5
_HULL, _PEAK, _PUSH, _WORK, _OTHER, _EFFORT = 6, 7, 8, 11, 14, 17


class ArmedPlant(Plant):
    """A vehicle with an arm in a current, and the things that it may touch.

    `state` is that of the vehicle, as in `Plant`; `mechanism` is the state of everything.
    """

    def __init__(
        self,
        vehicle: Vehicle,
        mountings: Sequence[Mounting],
        current: Current,
        bottom: Bottom | None,
        *,
        step_s: float,
        fault: ThrusterFault | None = None,
        thruster_gains: tuple[float, ...] | None = None,
        workpiece: Workpiece | None = None,
    ) -> None:
        """Set up a plant; without a bottom nothing touches it, but for the workpiece's things.

        `step_s` is that of sensors and commands; the mechanism moves in shorter ones.

        Raises
        ------
        ValueError
            The current does not move the water but pushes the vehicle, or an arm without a tool
            has a workpiece.
        """
        if current.water.law == FORCE:
            raise ValueError("a vehicle with an arm needs water that moves: not the force law")
        super().__init__(
            vehicle, current, step_s=step_s, fault=fault, thruster_gains=thruster_gains
        )
        things = () if workpiece is None else workpiece.things
        self.assembly = assemble(vehicle, (*mountings, *things), bottom=bottom is not None)
        self.substeps = max(1, round(step_s / STEP_S))
        self._timing = Timing(step_s / self.substeps, ITERATIONS)
        self._model = self.assembly.mechanism.model(self._timing.step_s)
        self.mechanism = self.assembly.state(self._model)
        self._start = self.mechanism.q.copy()
        self._held = command_for(self._model)
        self._parts = work_for(self._model)
        self._trim()
        self._ground = (bottom or Bottom(0.0)).ground()
        self._gauges = _gauges(self.assembly, self._model, workpiece)
        self._means = np.zeros_like(self._gauges.sums)
        self.readings = _readings(self._means, len(self.assembly.motors))
        self._move = SameTypes(advance_and_measure)
        driven = [self.assembly.mechanism.number(name) for name in self.assembly.motors]
        self._coordinates = self._model.structure.coordinate[driven]
        self._rates = self._model.structure.speed[driven]
        measured = (MEASURED + OTHER_MOTION * len(workpiece.others)) if workpiece else 0
        self.work = np.zeros(measured)  # as `measure_work` left it
        self._points = None if workpiece is None else points_of(workpiece, self.assembly)
        self.grip_m = None if workpiece is None else workpiece.grip
        self._measure = SameTypes(measure)

    def _trim(self) -> None:
        """Let the vehicle carry floats that lift as much as its arm weighs, so that it lies level.

        E: operators trim a vehicle with its arm in its home pose. These floats have no mass and are
        at the height of the body's origin.
        """
        model, frames, bare = self._model, self._parts.frames, vehicle_link(self.vehicle)
        place(model.structure, model.links, self._start, frames)
        # The parts of an arm that do not move are in the vehicle's link already.
        model.links.net_weight[0], model.links.moment[0] = bare.net_weight, bare.moment
        for i, root in enumerate(model.structure.root):
            if i == 0 or root != 0:
                continue
            weight = model.links.net_weight[i]
            moment = rotate(frames.rotation, i, three(model.links.moment, i, 0))
            model.links.net_weight[0] -= weight
            model.links.moment[0, :2] -= (np.array(moment) + weight * frames.position[i])[:2]

    def reset(self, pose: Array) -> None:
        """Put the vehicle at rest at a pose, its arm in its home pose, things where they belong."""
        super().reset(pose)
        mechanism = self.mechanism
        mechanism.q[:] = self._start
        for part in (mechanism.v, mechanism.thrust, *mechanism.impulses, self._held.speed):
            part[:] = 0.0
        mechanism.q[:_FREE] = self.state[:_FREE]
        self._means[:] = 0.0

    def drive(self, speeds: Sequence[float]) -> None:
        """Let the motors tend to these speeds, (a,) [rad/s or m/s]; with none, they hold still.

        A speed beyond what a motor reaches counts as its fastest.
        """
        limited = [
            min(max(speed, -fastest), fastest)
            for speed, fastest in zip(speeds, self.assembly.fastest, strict=False)
        ]
        self._held.speed[: len(limited)] = limited
        self._held.speed[len(limited) :] = 0.0

    def advance(self, step: int, command: Array, steps: int) -> None:
        """Advance the plant by a number of steps; see `Plant.advance`.

        Raises
        ------
        ValueError
            A command is not a number, or the gust of the current is too short.
        """
        self._take_command(step, command, steps)
        target = self._held.thrust
        if not steady_thrust(self._command, self.curve, target):
            raise ValueError(f"thruster commands must be numbers: {list(self._command)}")
        if self._fault.thruster >= 0:
            target[self._fault.thruster] = self._fault.thrust[0]
        target *= self.thruster_gains
        self._gauges.sums[:] = 0.0
        span = (step * self.substeps, steps * self.substeps)
        self._move.call(
            span,
            self._timing,
            self._model,
            self.mechanism,
            self._held,
            (self.water, self._ground),
            self._parts,
            self._gauges,
        )
        self._means[:] = self._gauges.sums / (steps * self.substeps)
        self.readings.peak_n[:] = self._gauges.sums[_PEAK]
        self._contact_force = float(self.readings.hull_n[0])
        self.state[:_FREE] = self.mechanism.q[:_FREE]
        self.state[_FREE:RIGID] = self.mechanism.v[:6]
        self.state[RIGID:] = self.mechanism.thrust

    def acceleration(self) -> Array:
        """Return the vehicle's acceleration over ground in the last step, body frame, (6,)."""
        return (self.mechanism.v[:6] - self._parts.before[:6]) / self._timing.step_s

    def measure_work(self) -> None:
        """Write where the workpiece is and how it moves to `work`, as `workpiece.measure` does."""
        if self._points is not None:
            q, v = self.mechanism.q, self.mechanism.v
            self._measure.call(self._model, q, v, self._points, self._parts.frames, self.work)

    def joints(self) -> Array:
        """Return the coordinate of each motor's joint, (a,) [rad or m]."""
        return self.mechanism.q[self._coordinates]

    def joint_rates(self) -> Array:
        """Return the speed of each motor's joint, (a,) [rad/s or m/s]."""
        return self.mechanism.v[self._rates]


def _readings(means: Array, motors: int) -> Readings:
    """Return views of an array of means."""
    return Readings(
        wrench=means[:_HULL],
        hull_n=means[_HULL:_PEAK],
        peak_n=means[_PEAK:_PUSH],
        push=means[_PUSH:_WORK],
        work_n=means[_WORK:_OTHER],
        other_n=means[_OTHER:_EFFORT],
        effort=means[_EFFORT : _EFFORT + motors],
        touch_n=means[_EFFORT + motors :],
    )


def _gauges(assembly: Assembly, model: Model, workpiece: Workpiece | None) -> Gauges:
    mechanism, sensor = assembly.mechanism, assembly.force_sensor
    return Gauges(
        link=np.array([WORLD if sensor is None else mechanism.number(sensor.link)]),
        point=np.zeros(3) if sensor is None else sensor.point.copy(),
        turn=np.eye(3) if sensor is None else np.ascontiguousarray(sensor.turn),
        part=np.array([_part(shape.name, assembly, workpiece) for shape in mechanism.shapes]),
        loads=np.zeros((len(mechanism.links), 6)),
        sums=np.zeros(_EFFORT + len(assembly.motors) + len(assembly.feelers)),
        force=np.zeros(4),
    )


def _part(shape: str, assembly: Assembly, workpiece: Workpiece | None) -> int:
    if shape in assembly.feelers:
        return assembly.feelers.index(shape)
    if shape in assembly.hull:
        return HULL
    if workpiece is not None and shape in workpiece.shapes:
        return WORKPIECE
    if workpiece is not None and shape in workpiece.other_shapes:
        return OTHER
    return ARM if shape in assembly.arm else REST


@uncounted
def advance_and_measure(
    span: tuple[int, int],
    timing: Timing,
    model: Model,
    state: State,
    command: Command,
    around: tuple[Water, Mounds],
    work: Work,
    gauges: Gauges,
) -> None:
    """Advance a mechanism as `step.advance` does, and add up what its gauges read."""
    (first, steps), (water, ground) = span, around
    for done in range(steps):
        t = (first + done) * timing.step_s + 0.5 * timing.step_s
        place_in_water(t, model, state, water, work)
        take_step(t, timing, model, state, command, water, ground, work)
        if gauges.link[0] != WORLD:
            write_loads(timing, model, state, work, gauges.loads, gauges.link[0])
            _add_wrench(gauges)
        _add_efforts(timing.step_s, command.speed.size, state, gauges)
        _add_contacts(timing.step_s, command.speed.size, model, state, work, gauges)


@uncounted
def _add_wrench(gauges: Gauges) -> None:
    link = gauges.link[0]
    force = three(gauges.loads, link, 0)
    lever = (gauges.point[0], gauges.point[1], gauges.point[2])
    torque = minus(three(gauges.loads, link, 3), cross(lever, force))
    for i in range(3):
        for j in range(3):
            gauges.sums[i] += gauges.turn[j, i] * force[j]
            gauges.sums[3 + i] += gauges.turn[j, i] * torque[j]


@uncounted
def _add_efforts(step_s: float, motors: int, state: State, gauges: Gauges) -> None:
    """Add what the motors give; their rows are the first."""
    for i in range(motors):
        gauges.sums[_EFFORT + i] += state.impulses.joint[i] / step_s


@uncounted
def _add_contacts(
    step_s: float, motors: int, model: Model, state: State, work: Work, gauges: Gauges
) -> None:
    shapes, solving, total = model.shapes, work.solving, gauges.force
    total[:] = 0.0
    for at in range(solving.in_use[0]):
        slot, pair = solving.used[at], solving.pair_of[at]
        if state.impulses.contact[slot, 0] == 0.0:
            continue
        a, b = gauges.part[shapes.first[pair]], gauges.part[shapes.second[pair]]
        force = contact_force(slot, step_s, state, work)
        size = math.sqrt(dot(force, force))
        for part in (a, b):
            if part >= 0:
                gauges.sums[_EFFORT + motors + part] += size
        sign = (1.0 if a == HULL else 0.0) - (1.0 if b == HULL else 0.0)
        for i in range(3):
            total[i] += sign * force[i]
        if _of_arm(a) != _of_arm(b):
            total[3] += size
        _add_push(a, b, force, gauges)
        _add_to(WORKPIECE, _WORK, (a, b), size, gauges)
        _add_to(OTHER, _OTHER, (a, b), size, gauges)
    gauges.sums[_HULL] += math.sqrt(total[0] * total[0] + total[1] * total[1] + total[2] * total[2])
    gauges.sums[_PEAK] = max(gauges.sums[_PEAK], total[3])


@njit(cache=True, error_model="numpy", inline="always")
def _of_arm(part: int) -> bool:
    return part >= 0 or part == ARM


@njit(cache=True, error_model="numpy", inline="always")
def _add_push(a: int, b: int, force: Vector, gauges: Gauges) -> None:
    """Add a contact force of the arm on the workpiece, if it is one."""
    if (a == WORKPIECE and _of_arm(b)) or (b == WORKPIECE and _of_arm(a)):
        sign = 1.0 if a == WORKPIECE else -1.0
        for i in range(3):
            gauges.sums[_PUSH + i] += sign * force[i]


@njit(cache=True, error_model="numpy", inline="always")
def _add_to(part: int, first: int, touching: tuple[int, int], size: float, gauges: Gauges) -> None:
    """Add the size of a contact force on a part to the sums by arm, hull, and all else."""
    a, b = touching
    if (a == part) == (b == part):
        return
    by = a if b == part else b
    if _of_arm(by):
        gauges.sums[first] += size
    elif by == HULL:
        gauges.sums[first + 1] += size
    else:
        gauges.sums[first + 2] += size
