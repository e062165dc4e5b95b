"""Links in water move as Lagrange's equations say, and keep momentum and energy without water."""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray

from seamark.sim.multibody.assembly import vehicle_link
from seamark.sim.multibody.mechanism import (
    Link,
    Mechanism,
    Point,
    command_for,
    state_for,
    work_for,
)
from seamark.sim.multibody.solver import Timing
from seamark.sim.multibody.step import State, advance, place_in_water, take_step
from seamark.sim.multibody.tree import solve, write_bias
from seamark.sim.numerics.arrays import Array
from seamark.sim.physics.current import Current, Pattern, Shear
from seamark.sim.physics.hydrodynamics import write_rotation
from seamark.sim.physics.plant import Plant
from seamark.sim.physics.pose import write_pose
from seamark.sim.vehicles import load
from tests.sim.multibody.scenes import GROUND, about, vehicle_with_arm

Complex = NDArray[np.complex128]
STEP_S = 1e-15  # [s] nothing moves
STEADY = Pattern(azimuth_swing_rad=0.0, speed_swing=0.0, azimuth_rad=0.7)


def rng(seed: int) -> np.random.Generator:
    return np.random.Generator(np.random.PCG64(seed))


def positive(source: np.random.Generator, scale: float) -> Array:
    """A random symmetric positive definite matrix, (6, 6)."""
    root = source.standard_normal((6, 6))
    made: Array = scale * (root @ root.T + 6.0 * np.eye(6))
    return made


def turned(source: np.random.Generator) -> Array:
    """A random rotation."""
    matrix = np.linalg.qr(source.standard_normal((3, 3)))[0]
    made: Array = matrix * np.sign(np.linalg.det(matrix))
    return made


def random_mechanism(seed: int, *, free: bool) -> Mechanism:
    """A tree of five links with a fork, revolute and prismatic joints, and any masses at all."""
    source = rng(seed)
    links: list[Link] = []
    parents = (None, 0, 1, 1, 3)
    for k, parent in enumerate(parents):
        axis = source.standard_normal(3)
        x, y, z = axis / np.linalg.norm(axis)
        joint = ("revolute", "revolute", "prismatic", "revolute", "prismatic")[k]
        a, b, c = 0.3 * source.standard_normal(3)
        d, e, f = 2.0 * source.standard_normal(3)
        links.append(
            Link(
                name=str(k),
                parent=None if parent is None else str(parent),
                joint="free"
                if free and k == 0
                else "revolute"
                if joint == "revolute"
                else "prismatic",
                offset=(a, b, c),
                turn=turned(source).tolist(),
                axis=(x, y, z),
                rigid=positive(source, 1.0),
                added=positive(source, 0.3),
                rotor=0.05 if k == 1 else 0.0,
                net_weight=5.0 * float(source.standard_normal()),
                moment=(d, e, f),
            )
        )
    return Mechanism(links=links)


def skew(v: Complex) -> Complex:
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])


def about_axis(axis: Array, angle: complex) -> Complex:
    k = skew(axis.astype(complex))
    made: Complex = np.eye(3) + np.sin(angle) * k + (1.0 - np.cos(angle)) * (k @ k)
    return made


def euler(angles: Complex) -> Complex:
    """The rotation to world axes of roll, pitch, yaw."""
    x, y, z = np.eye(3)
    return about_axis(z, angles[2]) @ about_axis(y, angles[1]) @ about_axis(x, angles[0])


@dataclass
class Lagrangian:
    """The energies of a mechanism in coordinates (north, east, down, roll, pitch, yaw, joints)."""

    mechanism: Mechanism
    current: Array  # (3,) [m/s]

    def rates(self, q: Complex, rate: Complex) -> list[tuple[Complex, Complex, Complex, Complex]]:
        """Rotation, position, velocity and rates in the world of each link."""
        frames: list[tuple[Complex, Complex, Complex, Complex]] = []
        at = 0
        for link in self.mechanism.links:
            if link.joint == "free":
                r = euler(q[3:6])
                _, sp, sy = np.sin(q[3:6])
                _, cp, cy = np.cos(q[3:6])
                about = np.array([[cy * cp, -sy, 0.0], [sy * cp, cy, 0.0], [-sp, 0.0, 1.0]])
                frames.append((r, q[:3], rate[:3], about @ rate[3:6]))
                at = 6
                continue
            base = (np.eye(3), np.zeros(3), np.zeros(3), np.zeros(3))
            number = self.mechanism.number(link.parent)
            r, p, v, w = base if number < 0 else frames[number]
            turn, axis = np.array(link.turn, dtype=complex), np.array(link.axis)
            arm = np.array(link.offset, dtype=complex)
            along = turn @ axis
            slides = link.joint == "prismatic"
            if slides:
                arm = arm + q[at] * along
            else:
                turn = turn @ about_axis(axis, q[at])
            reach = r @ arm
            v = v + np.cross(w, reach)
            if slides:
                v = v + rate[at] * (r @ along)
            else:
                w = w + rate[at] * (r @ along)
            frames.append((r @ turn, p + reach, v, w))
            at += 1
        return frames

    def energy(self, q: Complex, rate: Complex) -> complex:
        """The kinetic energy relative to the water, and of the rotors."""
        total, at = 0.0j, 0
        frames = self.rates(q, rate)
        for link, (r, _p, v, w) in zip(self.mechanism.links, frames, strict=True):
            twist = np.concatenate([r.T @ (v - self.current), r.T @ w])
            total += 0.5 * (twist @ ((link.rigid + link.added) @ twist))
            if link.joint != "free":
                total += 0.5 * link.rotor * rate[at] * rate[at]
            at += 6 if link.joint == "free" else 1
        return total

    def potential(self, q: Complex) -> complex:
        """The potential of weight and buoyancy; z is down."""
        total = 0.0j
        frames = self.rates(q, np.zeros_like(q))
        for link, (r, p, _v, _w) in zip(self.mechanism.links, frames, strict=True):
            total -= link.net_weight * p[2] + np.array(link.moment) @ r[2]
        return total

    def accelerations(self, q: Array, rate: Array) -> Array:
        """q'' by Lagrange's equations; derivatives by complex steps, which do not round."""
        n, h = len(q), 1e-30
        unit = np.eye(n)

        def momentum(at: Complex) -> Complex:
            # The energy is quadratic in the rates, so half of a difference is its derivative.
            moving = rate.astype(complex)
            return np.array(
                [0.5 * (self.energy(at, moving + e) - self.energy(at, moving - e)) for e in unit]
            )

        real = q.astype(complex)
        changing = momentum(real + 1j * h * rate).imag / h
        force = np.array(
            [
                (
                    self.energy(real + 1j * h * e, rate.astype(complex))
                    - self.potential(real + 1j * h * e)
                ).imag
                / h
                for e in unit
            ]
        )
        still = np.zeros(n, dtype=complex)
        mass = np.array(
            [
                [
                    self.energy(real, still + a + b)
                    - self.energy(real, still + a)
                    - self.energy(real, still + b)
                    + self.energy(real, still)
                    for b in unit
                ]
                for a in unit
            ]
        ).real
        solved: Array = np.linalg.solve(mass, force - changing)
        return solved

    def speeds(self, q: Complex, rate: Complex) -> Complex:
        """The speeds of the state: twist in the free link's axes, then the joints'."""
        if self.mechanism.links[0].joint != "free":
            return rate
        r, _p, v, w = self.rates(q, rate)[0]
        return np.concatenate([r.T @ v, r.T @ w, rate[6:]])

    def speed_changes(self, q: Array, rate: Array) -> Array:
        """The accelerations of those speeds."""
        h, found = 1e-30, self.accelerations(q, rate)
        made: Array = self.speeds(q + 1j * h * rate, rate + 1j * h * found).imag / h
        return made


def put(q: Array, lagrangian: Lagrangian, rate: Array, state: State) -> None:
    """Set a state by the Lagrangian's coordinates and rates."""
    if lagrangian.mechanism.links[0].joint == "free":
        write_pose(q[:6].copy(), state.q)
        state.q[7:] = q[6:]
    else:
        state.q[:] = q
    state.v[:] = lagrangian.speeds(q.astype(complex), rate.astype(complex)).real


def acceleration(
    mechanism: Mechanism, state: State, current: Current, middle_s: float = 0.5
) -> Array:
    """The acceleration over ground, of a free link that of its origin in its axes."""
    model, timing, water = mechanism.model(STEP_S), Timing(STEP_S, 0), current.water
    command, work = command_for(model), work_for(model)
    command.thrust[:] = state.thrust
    v = state.v.copy()
    place_in_water(middle_s, model, state, water, work)
    take_step(middle_s, timing, model, state, command, water, GROUND, work)
    # Again without its impulses, of which dividing by the step would leave rounding errors.
    write_bias(model.structure, model.links, v, work.wrench, work.frames)
    found = -work.frames.bias
    solve(model.structure, work.frames, found)
    if mechanism.links[0].joint == "free":
        found[:3] += work.frames.rotation[0].T @ work.frames.stream[0, 3:6]
    return found


def of_the_numbers(found: Array, v: Array, *, free: bool = True) -> Array:
    """How the numbers of the speeds change: those of a free link are in axes that turn."""
    made = found.copy()
    if free:
        made[:3] -= np.cross(v[3:6], v[:3])
    return made


@pytest.mark.parametrize("speed", [0.0, 0.8])
@pytest.mark.parametrize("free", [True, False])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_accelerations_are_those_of_lagranges_equations(
    seed: int, free: bool, speed: float
) -> None:
    mechanism = random_mechanism(seed, free=free)
    current = Current(speed, pattern=STEADY)
    lagrangian = Lagrangian(mechanism, current.velocity(0.0))
    state = state_for(mechanism.model(STEP_S))
    source = rng(100 + seed)
    q, rate = 0.5 * source.standard_normal((2, len(state.v)))
    put(q, lagrangian, rate, state)

    v = state.v.copy()

    found = of_the_numbers(acceleration(mechanism, state, current), v, free=free)

    expected = lagrangian.speed_changes(q, rate)
    assert found == pytest.approx(expected, rel=0.0, abs=1e-13 * np.abs(expected).max())


@pytest.mark.parametrize("shear", [None, Shear(exponent=0.2, bottom_m=10.0, height_m=3.0)])
@pytest.mark.parametrize("name", ["girona500", "bluerov2-heavy"])
def test_a_vehicle_without_an_arm_accelerates_as_the_plant(name: str, shear: Shear | None) -> None:
    vehicle = load(name)
    current = Current(0.4, shear=shear, rng=rng(1), duration_s=5.0)
    mechanism = Mechanism(links=[vehicle_link(vehicle)], allocation=vehicle.allocation())
    plant = Plant(vehicle, current, step_s=0.5)
    plant.reset(np.array([0.3, -0.2, 8.0, 0.2, -0.1, 0.6]))
    plant.state[7:13] = 0.3, -0.2, 0.25, 0.2, 0.3, -0.4
    plant.state[13:] = 7.0
    for step in range(4):
        state = state_for(mechanism.model(STEP_S))
        state.q[:], state.v[:], state.thrust[:] = plant.state[:7], plant.state[7:13], 7.0
        v = state.v.copy()

        found = acceleration(mechanism, state, current, step + 0.5)

        plant._step = 2 * step + 1
        expected = plant.acceleration()
        assert of_the_numbers(found, v) == pytest.approx(expected, rel=0.0, abs=1e-13)


def in_vacuum(seed: int) -> Mechanism:
    """A floating tree without weight."""
    mechanism = random_mechanism(seed, free=True)
    mechanism.links = [
        replace(link, net_weight=0.0, moment=(0.0, 0.0, 0.0)) for link in mechanism.links
    ]
    return mechanism


def kinetic(mechanism: Mechanism, state: State, step_s: float) -> tuple[float, Array, Array]:
    """The kinetic energy, and linear and angular momentum in the world, but for rotors."""
    model = mechanism.model(step_s)
    work = work_for(model)
    copy = State(*(np.copy(part) for part in state[:3]), state.impulses)
    still = Current(0.0).water
    advance((0, 1), Timing(1e-12, 0), model, copy, command_for(model), still, GROUND, work)
    twists, masses = work.frames.twist, model.links.mass
    energy = sum(0.5 * twist @ mass @ twist for twist, mass in zip(twists, masses, strict=True))
    energy += float(0.5 * (model.links.rotor[1:] * state.v[6:] ** 2).sum())
    momentum, angular = np.zeros(3), np.zeros(3)
    frames = zip(work.frames.rotation, work.frames.position, twists, masses, strict=True)
    for rotation, position, twist, mass in frames:
        push = mass @ twist
        momentum += rotation @ push[:3]
        angular += rotation @ push[3:] + np.cross(position, rotation @ push[:3])
    return energy, momentum, angular


def test_energy_and_both_momenta_are_kept_to_the_first_order_of_the_step() -> None:
    drifts = []
    for step_s in (4e-3, 2e-3, 1e-3):
        mechanism = in_vacuum(4)
        for link in mechanism.links:
            link.rotor = 0.0
        model = mechanism.model(step_s)
        state = state_for(model)
        state.v[:] = 0.5 * rng(9).standard_normal(len(state.v))
        first = kinetic(mechanism, state, step_s)
        steps, still = round(2.0 / step_s), Current(0.0).water
        advance(
            (0, steps),
            Timing(step_s, 0),
            model,
            state,
            command_for(model),
            still,
            GROUND,
            work_for(model),
        )
        last = kinetic(mechanism, state, step_s)
        lost = [
            np.abs(b - a).max() / np.abs(a).max() for a, b in zip(first[1:], last[1:], strict=True)
        ]
        drifts.append((abs(last[0] / first[0] - 1.0), *lost))

    for coarse, fine in pairwise(drifts):
        assert all(b < 0.65 * a for a, b in zip(coarse, fine, strict=True))
    assert max(drifts[-1]) < 0.02


def tumbling(*, centre: Point = (0.0, 0.0, 0.0), added: float = 0.0) -> Mechanism:
    """A free body."""
    rigid = about(2.0, np.diag([0.01, 0.02, 0.025]), centre)
    water = added * np.diag([1.0, 2.0, 3.0, 0.01, 0.02, 0.03])
    return Mechanism(links=[Link(name="body", rigid=rigid, added=water)])


def run(mechanism: Mechanism, step_s: float, seconds: float, v: Array | list[float]) -> State:
    """The state after some time in still water, without contacts."""
    model = mechanism.model(step_s)
    state, still = state_for(model), Current(0.0).water
    state.v[:] = v
    span, timing, command = (0, round(seconds / step_s)), Timing(step_s, 0), command_for(model)
    advance(span, timing, model, state, command, still, GROUND, work_for(model))
    return state


@pytest.mark.parametrize("rate", [3.0, 10.0, 30.0])
def test_a_body_that_tumbles_about_its_centre_of_mass_keeps_energy_and_momenta(rate: float) -> None:
    mechanism, step_s = tumbling(), 0.002
    v = [0.5, -0.3, 0.2, 0.3 * rate, rate, 0.1 * rate]
    first = kinetic(mechanism, run(mechanism, step_s, 0.0, v), step_s)

    last = kinetic(mechanism, run(mechanism, step_s, 60.0, v), step_s)

    assert last[0] == pytest.approx(first[0], rel=4e-3)
    assert last[1] == pytest.approx(first[1], rel=0.0, abs=1e-11)
    # The speeds are those of the middle of a step, half of which the body has not turned yet.
    most = 0.5 * rate * step_s * float(np.abs(first[2]).max())
    assert last[2] == pytest.approx(first[2], rel=0.0, abs=2.0 * most)


@pytest.mark.parametrize("rate", [3.0, 10.0])
@pytest.mark.parametrize(
    ("centre", "added"), [((0.1, 0.05, -0.02), 0.0), ((0.1, 0.05, -0.02), 1.0)]
)
def test_any_body_that_tumbles_gains_no_energy(rate: float, centre: Point, added: float) -> None:
    mechanism, step_s = tumbling(centre=centre, added=added), 0.002
    v = [0.5, -0.3, 0.2, 0.3 * rate, rate, 0.1 * rate]
    first = kinetic(mechanism, run(mechanism, step_s, 0.0, v), step_s)

    off = [
        kinetic(mechanism, run(mechanism, step_s, seconds, v), step_s)
        for seconds in (5.0, 20.0, 60.0)
    ]

    for energy, momentum, _angular in off:
        assert energy == pytest.approx(first[0], rel=rate * step_s)
        assert momentum == pytest.approx(
            first[1], rel=0.0, abs=3.0 * rate * step_s * abs(first[1]).max()
        )


@pytest.mark.parametrize("size", [1.0, 1e3, 1e6])
@pytest.mark.parametrize("seed", range(5))
def test_drag_only_takes_energy_however_large_it_is(seed: int, size: float) -> None:
    mechanism, source = in_vacuum(seed), rng(50 + seed)
    for link in mechanism.links:
        link.linear, link.quadratic = (size * source.uniform(0.0, 1.0, (2, 6))).tolist()
        link.centre = tuple(0.2 * source.standard_normal(3))
    v = 3.0 * source.standard_normal(10)

    energy = [
        kinetic(mechanism, run(mechanism, 0.002, seconds, v), 0.002)[0]
        for seconds in (0.0, 0.1, 0.5, 2.0)
    ]

    assert all(later < earlier for earlier, later in pairwise(energy))


def test_a_vehicle_with_an_arm_in_absurd_drag_hardly_moves() -> None:
    mechanism = vehicle_with_arm()
    mechanism.motors, mechanism.pairs, mechanism.couplings = [], [], []
    for link in mechanism.links:
        link.linear, link.quadratic = (1e5,) * 6, (1e6,) * 6

    v = run(mechanism, 0.002, 1.0, 3.0 * rng(2).standard_normal(12)).v

    assert np.abs(v).max() < 0.02  # what its weight does


def test_a_neutral_vehicle_with_an_arm_at_rest_in_still_water_does_not_turn() -> None:
    mechanism = vehicle_with_arm()
    mechanism.links[0].net_weight -= sum(link.net_weight for link in mechanism.links)
    model = mechanism.model(0.002)
    state, work, command = state_for(model), work_for(model), command_for(model)
    state.q[2] = 5.0
    still = Current(0.0).water

    advance((0, 30_000), Timing(0.002, 10), model, state, command, still, GROUND, work)

    rotation = np.empty((3, 3))
    write_rotation(*state.q[3:7], rotation)
    assert abs(rotation[1, 0]) < 1e-9
    assert abs(rotation[2, 1]) < 1e-9
    assert np.abs(state.v).max() < 1e-6
