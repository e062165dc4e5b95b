"""Cases with a closed form: the plant's result, the exact one, and the error.

Each case changes the vehicle so that the closed form is exact (no drag, neutral, or all centres in
one point), never the plant's code.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from performance.tables import markdown_table
from seamark.sim.numerics.arrays import Array
from seamark.sim.physics.current import Current, Pattern
from seamark.sim.physics.plant import Plant
from seamark.sim.physics.thrusters import commands_for, pack_curve
from seamark.sim.vehicles import Quantity, Vehicle, load

TITLE = "Cases with a closed form"
LARGEST_ERROR_PERCENT = 0.5
AXES = ("surge", "sway", "heave", "roll", "pitch", "yaw")
STILL = Current(0.0)
STEADY = Pattern(azimuth_swing_rad=0.0, speed_swing=0.0)
PUSH_SHARE = 0.5  # of the strongest thruster's limit, in the cases with thrust
# Straight motion is unstable (Munk moment): within a minute rounding errors turn a vehicle aside.
TERMINAL_S = 20.0
DRIFT_S, COAST_S, RISE_S = 60.0, 20.0, 120.0


class Case(NamedTuple):
    """One result of the plant and its closed form."""

    what: str
    vehicle: str
    ours: float
    expected: float
    unit: str

    @property
    def error_percent(self) -> float:
        """Return the relative error."""
        return 100.0 * abs(self.ours - self.expected) / abs(self.expected)


def _none(count: int) -> Quantity:
    return Quantity(meaning="left out", value=(0.0,) * count, unit="", tag="E", source="this case")


def neutral(vehicle: Vehicle) -> Vehicle:
    """Return the vehicle with as much buoyancy as weight."""
    return replace(vehicle, buoyancy=vehicle.weight)


def balanced(vehicle: Vehicle) -> Vehicle:
    """Return the vehicle neutral, with all centres at the origin: the axes are then decoupled."""
    centre = _none(3)
    return replace(neutral(vehicle), centre_of_gravity=centre, centre_of_buoyancy=centre)


def free(vehicle: Vehicle) -> Vehicle:
    """Return the vehicle without drag."""
    return replace(vehicle, drag_linear=(_none(6),), drag_quadratic=(_none(6),))


def terminal_speed(linear: float, quadratic: float, push: float) -> float:
    """Return the speed at which linear and quadratic drag together equal `push`."""
    root = float(np.sqrt(linear**2 + 4.0 * quadratic * abs(push)))
    size = (root - linear) / (2.0 * quadratic) if quadratic else abs(push) / linear
    return float(np.copysign(size, push))


def coasting_speed(linear: float, quadratic: float, mass: float, v0: float, t: float) -> float:
    """Return the speed after time t [s] of coasting from v0 > 0 against drag."""
    if not linear:
        return v0 / (1.0 + quadratic * v0 * t / mass)
    left = float(np.exp(-linear * t / mass))
    return linear * v0 * left / (linear + quadratic * v0 * (1.0 - left))


def commands_along(vehicle: Vehicle, axis: int) -> Array | None:
    """Return commands, (n,), for a wrench along one axis only; None if there are none."""
    matrix = vehicle.allocation()
    wanted = np.eye(6)[axis]
    share = np.linalg.pinv(matrix) @ wanted
    if not np.allclose(matrix @ share, wanted, atol=1e-9):
        return None
    force = PUSH_SHARE * min(vehicle.curve.limits.value) * share / np.abs(share).max()
    commands = np.empty(force.size)
    commands_for(force, pack_curve(vehicle.curve), commands)
    return commands


def terminal_speeds(vehicle: Vehicle) -> Iterator[Case]:
    """Yield the terminal speed of every axis that the thrusters can drive by itself."""
    plant = Plant(balanced(vehicle), STILL)
    for axis, name in enumerate(AXES):
        commands = commands_along(vehicle, axis)
        if commands is None:
            continue
        plant.reset(np.zeros(6))
        plant.advance(0, commands, round(TERMINAL_S / plant.step_s))
        push = float((vehicle.allocation() @ plant.thrust())[axis])
        drag = (float(vehicle.linear_drag()[axis]), float(vehicle.quadratic_drag()[axis]))
        unit = "m/s" if axis < 3 else "rad/s"
        ours, expected = float(plant.velocity()[axis]), terminal_speed(*drag, push)
        what = f"terminal speed, {name}, {abs(push):.1f} {'N' if axis < 3 else 'N m'}"
        yield Case(what, vehicle.name, ours, expected, unit)


def coasting(vehicle: Vehicle) -> Iterator[Case]:
    """Yield the speed left after coasting forward from 1 m/s."""
    plant = Plant(balanced(vehicle), STILL)
    plant.state[7] = 1.0
    plant.advance(0, np.zeros(len(vehicle.thrusters)), round(COAST_S / plant.step_s))
    drag = (float(vehicle.linear_drag()[0]), float(vehicle.quadratic_drag()[0]))
    mass = float((vehicle.mass_rigid() + vehicle.mass_added())[0, 0])
    expected = coasting_speed(*drag, mass, 1.0, COAST_S)
    what = f"speed after coasting {COAST_S:g} s from 1 m/s"
    yield Case(what, vehicle.name, float(plant.velocity()[0]), expected, "m/s")


def righting_periods(vehicle: Vehicle) -> Iterator[Case]:
    """Yield the period of small oscillations in roll and pitch, without drag."""
    changed = free(neutral(vehicle))
    lever = vehicle.centre_of_gravity.value[2] - vehicle.centre_of_buoyancy.value[2]
    mobility = np.linalg.inv(vehicle.mass_rigid() + vehicle.mass_added())
    for axis in (3, 4):
        # The other axes are free too, so the effective inertia follows from the inverse.
        stiffness = vehicle.weight.scalar * lever * float(mobility[axis, axis])
        expected = 2.0 * np.pi / float(np.sqrt(stiffness))
        plant, angles = Plant(changed, STILL, step_s=0.005), []
        plant.reset(0.01 * np.eye(6)[axis])
        idle = np.zeros(len(vehicle.thrusters))
        for step in range(round(2.5 * expected / plant.step_s)):
            angles.append(float(plant.pose()[axis]))
            plant.advance(step, idle, 1)
        ours = _period(np.array(angles), plant.step_s)
        yield Case(f"righting period, {AXES[axis]}", vehicle.name, ours, expected, "s")


def _period(angles: Array, step: float) -> float:
    """Return the time between the first two rising zero crossings, interpolated."""
    at = np.nonzero((angles[:-1] < 0.0) & (angles[1:] >= 0.0))[0]
    crossings = at + angles[at] / (angles[at] - angles[at + 1])
    return float(crossings[1] - crossings[0]) * step


def added_mass(vehicle: Vehicle) -> Iterator[Case]:
    """Yield the initial acceleration along the axes that the thrusters can drive: F / (m + A)."""
    changed = balanced(vehicle)
    inertia = np.diag(changed.mass_rigid() + changed.mass_added())
    for axis in (0, 1, 2, 5):
        commands = commands_along(vehicle, axis)
        if commands is None:
            continue
        plant = Plant(changed, STILL, step_s=1e-4)
        plant.advance(0, commands, round(5.0 / plant.step_s))  # until the thrust is steady
        plant.state[:13] = np.eye(13)[3]  # at rest again, upright
        plant.advance(0, commands, 1)
        push = float((vehicle.allocation() @ plant.thrust())[axis])
        unit = "m/s²" if axis < 3 else "rad/s²"
        ours = float(plant.velocity()[axis]) / plant.step_s
        what = f"initial acceleration F / (m + A), {AXES[axis]}"
        yield Case(what, vehicle.name, ours, push / float(inertia[axis]), unit)


def buoyancy(vehicle: Vehicle) -> Iterator[Case]:
    """Yield the rising speed under net buoyancy alone; nothing for a neutral vehicle."""
    net = vehicle.weight.scalar - vehicle.buoyancy.scalar
    if abs(net) < 1e-9:
        return
    # With both centres on one vertical the vehicle stays upright, as the closed form assumes.
    centre = replace(vehicle.centre_of_gravity, value=(0.0, 0.0, 0.0))
    plant = Plant(replace(vehicle, centre_of_gravity=centre, centre_of_buoyancy=_none(3)), STILL)
    plant.advance(0, np.zeros(len(vehicle.thrusters)), round(RISE_S / plant.step_s))
    drag = (float(vehicle.linear_drag()[2]), float(vehicle.quadratic_drag()[2]))
    ours, expected = float(plant.velocity()[2]), terminal_speed(*drag, net)
    yield Case(f"heave speed under {net:.2f} N net weight", vehicle.name, ours, expected, "m/s")


def drift(vehicle: Vehicle) -> Iterator[Case]:
    """Yield the speed over ground after a minute in a steady current of 0.4 m/s from astern."""
    level = 0.4
    current = Current(level, pattern=replace(STEADY, azimuth_rad=np.pi))
    plant = Plant(balanced(vehicle), current)
    plant.advance(0, np.zeros(len(vehicle.thrusters)), round(DRIFT_S / plant.step_s))
    drag = (float(vehicle.linear_drag()[0]), float(vehicle.quadratic_drag()[0]))
    mass = float((vehicle.mass_rigid() + vehicle.mass_added())[0, 0])
    expected = level - coasting_speed(*drag, mass, level, DRIFT_S)
    what = f"speed after drifting {DRIFT_S:g} s in {level:g} m/s"
    yield Case(what, vehicle.name, float(plant.velocity()[0]), expected, "m/s")


def energy_taken(vehicle: Vehicle) -> Iterator[Case]:
    """Yield the kinetic energy lost in 10 s and the separately integrated work of the drag."""
    plant = Plant(balanced(vehicle), STILL)
    mass = plant.vehicle.mass_rigid() + plant.vehicle.mass_added()
    linear, quadratic = vehicle.linear_drag(), vehicle.quadratic_drag()
    plant.state[7:13] = 0.8, -0.5, 0.3, 0.2, -0.3, 0.4
    energies, powers = [], []
    for step in range(1001):
        v = plant.velocity()
        energies.append(0.5 * float(v @ mass @ v))
        powers.append(float((linear + quadratic * np.abs(v)) @ (v * v)))
        plant.advance(step, np.zeros(len(vehicle.thrusters)), 1)
    if max(np.diff(energies)) > 0.0:
        raise RuntimeError(f"drag added energy to {vehicle.name}")
    weights = np.array([1.0, *(4.0, 2.0) * 499, 4.0, 1.0])  # Simpson's rule
    work = float(weights @ np.array(powers)) * plant.step_s / 3.0
    yield Case(
        "energy dissipated by drag in 10 s", vehicle.name, energies[0] - energies[-1], work, "J"
    )


FAMILIES: tuple[Callable[[Vehicle], Iterator[Case]], ...] = (
    terminal_speeds,
    coasting,
    righting_periods,
    added_mass,
    buoyancy,
    drift,
    energy_taken,
)


def cases(name: str) -> list[Case]:
    """Return all cases of one vehicle."""
    return [case for family in FAMILIES for case in family(load(name))]


def section(names: list[str], _figures: Path) -> str:
    """Return the section's text."""
    all_cases = [case for name in names for case in cases(name)]
    worst = max(all_cases, key=lambda case: case.error_percent)
    rows = [
        (c.vehicle, c.what, f"{c.ours:.6g}", f"{c.expected:.6g}", c.unit, f"{c.error_percent:.5f}")
        for c in all_cases
    ]
    verdict = "All" if worst.error_percent <= LARGEST_ERROR_PERCENT else "**Not all**"
    return "\n\n".join(
        [
            f"{verdict} {len(all_cases)} errors are within {LARGEST_ERROR_PERCENT:g} %. The "
            f"largest is {worst.error_percent:.3f} % ({worst.vehicle}, {worst.what}).",
            "Method: the plant of `sim/physics/plant.py` with the vehicle's own parameters and no "
            "random part. Each case simplifies the vehicle so that the closed form is exact: "
            "terminal speed, coasting, initial acceleration, drift and energy have neutral "
            "buoyancy and all centres at one point; the righting period has no drag. The thrust "
            "is half of the thrusters' weaker limit, through their curve and lag, for "
            f"{TERMINAL_S:g} s: straight motion of a body with more added mass in sway than in "
            "surge is unstable (Munk moment), and within a minute rounding errors turn it. With "
            "drag v' = -(a v + b v²) / m the terminal speed is (sqrt(a² + 4 b F) - a) / 2b and the "
            "coasting speed a v0 e / (a + b v0 (1 - e)) with e = exp(-a t / m). The righting "
            "period of an oscillation of 0.01 rad is 2 pi / sqrt(W z (M^-1)_kk). The energy never "
            "increased from one step to the next; its loss is compared with the drag power "
            "integrated by Simpson's rule. An axis that the thrusters cannot drive by itself has "
            "no row.",
            markdown_table(("vehicle", "case", "ours", "closed form", "unit", "error %"), rows),
        ]
    )
