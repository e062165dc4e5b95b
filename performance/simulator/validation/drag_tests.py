"""Drag and top speed of the BlueROV2, against a current tank and against other identifications."""

from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from performance.plots import COLOURS, figure
from performance.simulator.validation import analytic
from performance.simulator.validation.published import (
    BLUEROV2,
    HEADER,
    KGF_N,
    LI,
    SOURCES,
    WU,
    Comparison,
    Source,
)
from performance.simulator.validation.thrust_tests import (
    BOLLARD_KGF,
    VEHICLE,
    bollard_pull,
    full_commands,
)
from performance.tables import markdown_table
from seamark.sim.physics.plant import Plant
from seamark.sim.vehicles import Quantity, Vehicle, load

TITLE = "Drag and speed of the BlueROV2"
SECOND = "bluerov2-heavy-v2"  # whose forces follow what is compared here
TOP_SPEED_M_S = 1.0
RUN_S = 5.0  # later the Munk moment has turned a vehicle without control aside
TANK = {"surge": (1.0, 45.0), "sway": (0.6, 30.0)}  # speed [m/s], force [N]
# Width of the frame [m]: the tank's vehicle has six thrusters, ours has eight. S: Blue Robotics
WIDTH_M, HEAVY_WIDTH_M = 0.338, 0.571
AXES = {"surge": 0, "sway": 1, "heave": 2}


class Identification(NamedTuple):
    """Drag coefficients of surge, sway and heave [N s/m], [N s²/m²]."""

    label: str
    linear: tuple[float, float, float]
    quadratic: tuple[float, float, float]
    source: Source

    def force(self, axis: int, speed: float) -> float:
        """Return the drag [N] at a speed [m/s]."""
        return self.linear[axis] * speed + self.quadratic[axis] * speed**2


OTHERS = (
    Identification("Wu 2018", (4.03, 6.22, 5.18), (18.18, 21.66, 36.99), WU),
    Identification("Li et al. 2020, CFD", (1.31, 9.14, 2.015), (38.17, 129.6, 243.2), LI),
)


def drag(vehicle: Vehicle, axis: int, speed: float) -> float:
    """Return our drag [N] at a speed [m/s] along one axis."""
    linear, quadratic = vehicle.linear_drag()[axis], vehicle.quadratic_drag()[axis]
    return float(linear * speed + quadratic * speed**2)


def top_speed(vehicle: Vehicle) -> float:
    """Return the highest speed ahead [m/s] within RUN_S at full command, from rest."""
    plant, commands = Plant(vehicle, analytic.STILL), full_commands(vehicle, 0)
    highest = 0.0
    for step in range(round(RUN_S / plant.step_s)):
        plant.advance(step, commands, 1)
        highest = max(highest, float(plant.velocity()[0]))
    return highest


def with_thrust_scaled(vehicle: Vehicle, factor: float) -> Vehicle:
    """Return the vehicle with all of its thrust multiplied."""

    def scaled(quantity: Quantity) -> Quantity:
        return replace(quantity, value=tuple(factor * value for value in quantity.value))

    curve = vehicle.curve
    weaker = replace(
        curve,
        forward=scaled(curve.forward),
        reverse=scaled(curve.reverse),
        limits=scaled(curve.limits),
    )
    return replace(vehicle, curve=weaker)


def with_measured_pull(vehicle: Vehicle) -> Vehicle:
    """Return the vehicle with the published bollard pull ahead."""
    measured = KGF_N * BOLLARD_KGF["ahead"]
    return with_thrust_scaled(vehicle, measured / bollard_pull(vehicle, 0))


def comparisons() -> list[Comparison]:
    """Return all comparisons of this section."""
    vehicle = load(VEHICLE)
    quantities = [
        Comparison("top speed ahead", top_speed(vehicle), TOP_SPEED_M_S, "m/s", BLUEROV2),
        Comparison(
            "top speed ahead with the published bollard pull",
            top_speed(with_measured_pull(vehicle)),
            TOP_SPEED_M_S,
            "m/s",
            BLUEROV2,
        ),
    ]
    for name, (speed, force) in TANK.items():
        ours = drag(vehicle, AXES[name], speed)
        quantities.append(Comparison(f"drag in {name} at {speed:g} m/s", ours, force, "N", LI))
    return quantities


def second_comparisons() -> list[Comparison]:
    """Return the comparisons of the second version, whose thrust and drag they decided."""
    vehicle = load(SECOND)
    comparisons = [
        Comparison("top speed ahead", top_speed(vehicle), TOP_SPEED_M_S, "m/s", BLUEROV2)
    ]
    for axis, (name, kgf) in enumerate(BOLLARD_KGF.items()):
        pull = bollard_pull(vehicle, axis)
        comparisons.append(Comparison(f"bollard pull {name}", pull, KGF_N * kgf, "N", BLUEROV2))
    for name, (speed, force) in TANK.items():
        ours = drag(vehicle, AXES[name], speed)
        comparisons.append(Comparison(f"drag in {name} at {speed:g} m/s", ours, force, "N", LI))
    return comparisons


def draw(out: Path) -> None:
    """Write the figure: drag over speed of ours, of the other identifications and of the tank."""
    vehicle, speeds = load(VEHICLE), np.linspace(0.0, 1.0, 51)
    with figure(out, rows=2, height=6.0) as panels:
        for panel, (name, (speed, force)) in zip(panels, TANK.items(), strict=True):
            axis = AXES[name]
            second = [drag(load(SECOND), axis, float(v)) for v in speeds]
            panel.plot(speeds, second, "--", label="ours, second version", color=COLOURS[1])
            curves = [("ours", [drag(vehicle, axis, float(v)) for v in speeds])]
            curves += [(o.label, [o.force(axis, float(v)) for v in speeds]) for o in OTHERS]
            for (label, values), colour in zip(curves, COLOURS[1:], strict=True):
                panel.plot(speeds, values, label=label, color=colour)
            panel.plot([speed], [force], "o", color=COLOURS[0], label="current tank")
            panel.set_ylabel(f"drag in {name} [N]")
        panels[0].legend()
        panels[-1].set_xlabel("speed [m/s]")


def section(_names: list[str], figures: Path) -> str:
    """Return the section's text."""
    draw(figures / "bluerov2-drag.png")
    vehicle, quantities = load(VEHICLE), comparisons()
    rows = [
        (
            f"{other.label} [{SOURCES.index(other.source) + 1}]",
            *(f"{drag(vehicle, axis, 0.5) / other.force(axis, 0.5):.1f}" for axis in AXES.values()),
        )
        for other in OTHERS
    ]
    speed, force = TANK["surge"]
    wider = force * HEAVY_WIDTH_M / WIDTH_M
    surge = drag(vehicle, 0, speed)
    return "\n\n".join(
        [
            f"The top speed agrees to {abs(quantities[0].error_percent):.0f} %, but only because "
            "two errors compensate: our thrust is too strong and our drag too large. With the "
            f"published bollard pull our vehicle reaches {quantities[1].ours:.2f} m/s "
            f"({quantities[1].error_percent:+.0f} %).",
            markdown_table(HEADER, [c.cells() for c in quantities]),
            f"The tank's vehicle is {WIDTH_M * 1e3:g} mm wide, the Heavy {HEAVY_WIDTH_M * 1e3:g} "
            f"mm. Scaled by the width, the measured {force:g} N would be {wider:.0f} N and ours "
            f"still {100.0 * (surge / wider - 1.0):.0f} % larger. Our coefficients are those that "
            "von Benzon et al. 2022 publish.",
            "Published identifications of the BlueROV2 differ from each other by more than the "
            "factor of two between ours and the tank. Our drag at 0.5 m/s as a multiple of "
            "theirs:",
            markdown_table(("identification", *AXES), rows),
            "![Drag over speed](figures/bluerov2-drag.png)",
            f"So there is a second version, `{SECOND}`, whose thrust follows the published pull "
            "and whose drag in surge lies between the tank's force and that force scaled by the "
            "width. It stands beside the first in practice runs; benchmarks that exist keep the "
            "first. The pull abeam is less than that ahead because two of the four thrusters then "
            "push in reverse.",
            markdown_table(HEADER, [c.cells() for c in second_comparisons()]),
            "Consequence: in `currents-v2` the BlueROV2 Heavy is about as fast as the real one, "
            "with more thrust against more drag, and it reaches its speed sooner. Ranks compare "
            "programs on the same vehicle; the current held, in metres per second, is not a "
            "prediction for a real one.",
            f"Method: highest speed within {RUN_S:g} s at full command from rest, in still water, "
            "before the Munk moment turns the uncontrolled vehicle.",
        ]
    )
