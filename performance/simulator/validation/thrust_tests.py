"""Thrust: one T200 on a bench and the bollard pull of the whole BlueROV2."""

from pathlib import Path

import numpy as np

from performance.plots import COLOURS, figure
from performance.simulator.validation import analytic
from performance.simulator.validation.published import (
    BLUEROV2,
    HEADER,
    HEAVY,
    KGF_N,
    T200,
    Comparison,
)
from performance.tables import markdown_table
from seamark.sim.numerics.arrays import Array
from seamark.sim.physics.plant import Plant
from seamark.sim.physics.thrusters import pack_curve, thrust_from_command
from seamark.sim.vehicles import Vehicle, load

TITLE = "Thrust and mass of the BlueROV2"
VEHICLE = "bluerov2-heavy"
# [kgf] at 16 V, by pulse width [µs]; the command is (width - 1500) / 400.
BENCH_KGF = {
    **{1100: -4.07, 1200: -2.71, 1300: -1.44, 1400: -0.48},
    **{1600: 0.60, 1700: 1.82, 1800: 3.42, 1900: 5.25},
}
BOLLARD_KGF = {"ahead": 9.0, "abeam": 9.0}  # four horizontal thrusters
VERTICAL_KGF = 7.0 / 2  # for each of the two vertical thrusters
MASS_KG = 11.5  # in air, with ballast
AXES = {"ahead": 0, "abeam": 1, "vertical": 2}
SETTLE_S = 2.0


def command_of(pulse_us: float) -> float:
    """Return the command in [-1, 1] of a pulse width."""
    return (pulse_us - 1500.0) / 400.0


def bench_thrust(vehicle: Vehicle, pulse_us: float) -> float:
    """Return our steady thrust [N] of one thruster at a pulse width."""
    return float(thrust_from_command(command_of(pulse_us), pack_curve(vehicle.curve)))


def full_commands(vehicle: Vehicle, axis: int) -> Array:
    """Return full commands, (n,), of all thrusters that push along an axis, in its direction."""
    commands: Array = np.sign(np.round(vehicle.allocation()[axis], 9))
    return commands


def bollard_pull(vehicle: Vehicle, axis: int) -> float:
    """Return the force [N] along an axis with full commands, once the thrust is steady."""
    plant = Plant(vehicle, analytic.STILL)
    plant.advance(0, full_commands(vehicle, axis), round(SETTLE_S / plant.step_s))
    return float((vehicle.allocation() @ plant.thrust())[axis])


def comparisons() -> list[Comparison]:
    """Return all comparisons of this section."""
    vehicle = load(VEHICLE)
    quantities = [
        Comparison(
            f"T200 on the bench at {pulse} µs",
            bench_thrust(vehicle, pulse),
            KGF_N * kgf,
            "N",
            T200,
        )
        for pulse, kgf in sorted(BENCH_KGF.items())
    ]
    for name, kgf in BOLLARD_KGF.items():
        pull = bollard_pull(vehicle, AXES[name])
        quantities.append(Comparison(f"bollard pull {name}", pull, KGF_N * kgf, "N", BLUEROV2))
    upright = np.count_nonzero(full_commands(vehicle, AXES["vertical"]))
    each = bollard_pull(vehicle, AXES["vertical"]) / upright
    what = "bollard pull down, per vertical thruster"
    quantities.append(Comparison(what, each, KGF_N * VERTICAL_KGF, "N", BLUEROV2))
    quantities.append(Comparison("mass in air", vehicle.mass.scalar, MASS_KG, "kg", HEAVY))
    return quantities


def draw(out: Path) -> None:
    """Write the figure: our thrust curve and the measured one."""
    vehicle = load(VEHICLE)
    pulses = np.arange(1100, 1901, 4)
    with figure(out) as axes:
        ours = [bench_thrust(vehicle, float(pulse)) for pulse in pulses]
        axes.plot(pulses, ours, color=COLOURS[1], label="ours")
        measured = [KGF_N * kgf for kgf in BENCH_KGF.values()]
        axes.plot(list(BENCH_KGF), measured, "o", color=COLOURS[0], label="measured, 16 V")
        axes.set_xlabel("pulse width [µs]")
        axes.set_ylabel("thrust [N]")
        axes.legend()


def section(_names: list[str], figures: Path) -> str:
    """Return the section's text."""
    draw(figures / "t200.png")
    quantities = comparisons()
    partial = [c.error_percent for c in quantities if "1100" not in c.what and "1900" not in c.what]
    low = min(partial[:6])
    pulls = [c.error_percent for c in quantities if c.what.startswith("bollard")]
    return "\n\n".join(
        [
            "At full command a single thruster agrees with the bench, because its limits are taken "
            f"from there. At partial command ours is up to {-low:.0f} % too weak: our curve is a "
            "parabola, the measured one is steeper at small commands. The velocity controller "
            "inverts our curve, so position controllers see little of the difference.",
            "The assembled vehicle pulls much less than the sum of its thrusters on the bench: "
            f"our bollard pulls are {min(pulls):.0f} to {max(pulls):.0f} % too strong. We do not "
            "model losses in the frame, between the thrusters and in the battery's voltage, or "
            "the loss of thrust with the speed of the inflow.",
            markdown_table(HEADER, [c.cells() for c in quantities]),
            "![Thrust of a T200 over the pulse width](figures/t200.png)",
            "Method: full commands to every thruster that pushes along the axis, steady thrust "
            "after its lag, multiplied by the allocation matrix. The published pulls are those of "
            "the vehicle with six thrusters; the Heavy has the same four horizontal ones, and its "
            "vertical pull is compared per thruster. Our mass is that of von Benzon et al. 2022.",
        ]
    )
