"""Vehicles against measurements: writes docs/measurements.md and its figure.

Both versions of the BlueROV2 Heavy beside what is published of it, the order of entries on both,
and a verdict for every other comparison.
"""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from performance import DOCS
from performance.plots import COLOURS, figure
from performance.simulator.validation import analytic, entries
from performance.simulator.validation.drag_tests import (
    AXES,
    HEAVY_WIDTH_M,
    OTHERS,
    TANK,
    TOP_SPEED_M_S,
    WIDTH_M,
    Identification,
    drag,
    top_speed,
)
from performance.simulator.validation.published import BLUEROV2, KGF_N, LI, Source
from performance.simulator.validation.thrust_tests import BOLLARD_KGF, bollard_pull
from performance.tables import markdown_table
from seamark.sim.numerics.arrays import Array
from seamark.sim.physics.plant import Plant
from seamark.sim.physics.thrusters import commands_for
from seamark.sim.vehicles import Vehicle, load
from seamark.sim.vehicles.capabilities import response

PAGE = "measurements.md"
STEPS = {  # motion -> direction of `capabilities`, axis, unit of the speed
    "surge": ("ahead", 0, "m/s"),
    "sway": ("to starboard", 1, "m/s"),
    "heave": ("down", 2, "m/s"),
    "yaw": ("turning to starboard", 5, "rad/s"),
}
RESPONSE_S = 3.0
HALF = 0.5  # of the greatest force: a step that leaves the thrusters room for the other axes
# What the last digit of a published number leaves open: half of it.
ROUNDED_KGF, ROUNDED_M_S = 0.5, 0.05
OLDER_KGF = 14.0  # ahead and abeam, in older revisions of the maker's page


def vehicles() -> tuple[Vehicle, Vehicle]:
    """Return both versions."""
    first, second = (load(name) for name in entries.VERSIONS)
    return first, second


def step_response(vehicle: Vehicle, motion: str) -> tuple[Array, Array]:
    """Return times [s] and speeds of a step to half of the greatest force along one axis."""
    direction, axis, _ = STEPS[motion]
    plant = Plant(vehicle, analytic.STILL)
    wrench = np.zeros(6)
    wrench[axis] = HALF * response(vehicle, direction).force
    thrust = np.linalg.pinv(vehicle.allocation()) @ wrench
    command = np.zeros(len(thrust))
    commands_for(thrust, plant.curve, command)
    steps = round(RESPONSE_S / plant.step_s)
    speeds = np.zeros(steps + 1)
    for step in range(steps):
        plant.advance(step, command, 1)
        speeds[step + 1] = plant.velocity()[axis]
    return np.float64(plant.step_s) * np.arange(steps + 1, dtype=np.float64), speeds


def draw(out: Path) -> None:
    """Write the figure of the step responses."""
    with figure(out, rows=len(STEPS), height=9.0) as panels:
        for panel, (motion, (_, _, unit)) in zip(panels, STEPS.items(), strict=True):
            for vehicle, colour in zip(vehicles(), COLOURS[1:], strict=False):
                panel.plot(*step_response(vehicle, motion), label=vehicle.name, color=colour)
            panel.set_ylabel(f"{motion} [{unit}]")
        panels[0].legend()
        panels[-1].set_xlabel("time since the step [s]")


def with_drag(vehicle: Vehicle, other: Identification) -> Vehicle:
    """Return a vehicle with another identification's drag in surge, sway and heave."""
    linear, quadratic = vehicle.drag_linear, vehicle.drag_quadratic
    turning = [group for group in linear if len(group.value) == 3][-1]
    turning_quadratic = quadratic[-1]
    along = replace(linear[0], value=other.linear, spread=None)
    return replace(
        vehicle,
        drag_linear=(along, turning),
        drag_quadratic=(
            replace(along, value=other.quadratic, unit="N s²/m²"),
            turning_quadratic,
        ),
    )


def steady_rows() -> list[tuple[str, ...]]:
    """Return the rows of pull, speed and drag."""
    first, second = vehicles()
    rows = []
    for axis, (name, kgf) in enumerate(BOLLARD_KGF.items()):
        ours = [bollard_pull(one, axis) for one in (first, second)]
        spread = f"± {KGF_N * ROUNDED_KGF:.0f}; {KGF_N * OLDER_KGF:.0f} in older revisions"
        rows.append(_row(f"bollard pull {name} [N]", ours, KGF_N * kgf, spread, BLUEROV2))
    speeds = [top_speed(one) for one in (first, second)]
    rows.append(_row("top speed [m/s]", speeds, TOP_SPEED_M_S, f"± {ROUNDED_M_S:g}", BLUEROV2))
    for motion, (speed, force) in TANK.items():
        ours = [drag(one, AXES[motion], speed) for one in (first, second)]
        wider = force * HEAVY_WIDTH_M / WIDTH_M if motion == "surge" else None
        spread = "not stated" + (f"; {wider:.0f} for the Heavy's width" if wider else "")
        rows.append(_row(f"drag in {motion} at {speed:g} m/s [N]", ours, force, spread, LI))
    return rows


def _row(
    what: str, ours: Sequence[float], measured: float, spread: str, source: Source
) -> tuple[str, ...]:
    cells = [f"{one:.3g} ({100.0 * (one / measured - 1.0):+.0f} %)" for one in ours]
    number = f"[{source.name.partition(',')[0]}]({source.url})"
    return what, *cells, f"{measured:.3g}", spread, number


def step_rows() -> list[tuple[str, ...]]:
    """Return the rows of step responses: time to 63 % and final speed at full force."""
    first, second = vehicles()
    rows = []
    for motion, (direction, axis, unit) in STEPS.items():
        own = [response(one, direction) for one in (first, second)]
        cells = [f"{one.time_s:.2f} s to 63 % of {one.speed:.2f} {unit}" for one in own]
        others = [response(with_drag(second, one), direction) for one in OTHERS] if axis < 3 else []
        said = "; ".join(
            f"{other.label}: {one.time_s:.2f} s, {one.speed:.2f} {unit}"
            for other, one in zip(OTHERS, others, strict=False)
        )
        rows.append((motion, *cells, said or "none found"))
    return rows


VERDICTS = (
    (
        "bollard pull",
        "The second version agrees with the maker's figure within 11 %; the first is 47 to 65 % "
        "too strong, because its thrusters are those of a bench.",
    ),
    (
        "top speed",
        "Both are within 20 % of a figure that is stated to one digit; the first one only because "
        "thrust and drag are too large together.",
    ),
    (
        "drag",
        "The second version lies a third above a force that belongs to a narrower vehicle, between "
        "it and its scaled value in surge; the first has two and a half to three and a half times "
        "as much.",
    ),
    (
        "step responses",
        "Not validated: no recorded step response of this vehicle was open to us, and published "
        "identifications differ by more than our two versions. `seamark identify` is how your tank "
        "day decides it.",
    ),
)


OTHER_VERDICTS = (
    (
        "Girona 500: pull, speed, step responses",
        "Ribas et al. 2012, IEEE/ASME Trans. Mechatronics 17(1), of which only the abstract was "
        "open to us",
        "No verdict: our numbers come from the configuration of the real vehicle's controller, and "
        "no independent measurement was open to us.",
    ),
    (
        "attitude of a BlueROV2 with a moving arm",
        "Kolano et al., motion of eight trials",
        "Agrees: roll and pitch within 0.7° rms in trials that nothing was fitted to "
        "([details](validation.md#a-bluerov2-that-floats-and-moves-its-arm)).",
    ),
    (
        "station keeping of a BlueROV2 in a swimming pool",
        "González-García et al. 2022, Sensors 22(12) 4347, <https://doi.org/10.3390/s22124347>: "
        "RMSE of 1 to 4 cm in depth against a thruster that pushes it aside",
        "Not comparable: that disturbance is one thruster's, and its force is not in the abstract.",
    ),
    (
        "docking",
        "Frontiers in Robotics and AI 2021, article 621755: an approach to within 2 m in 48 of 48 "
        "tries; homing by light from offsets of up to 5 m in 12 of 17",
        "Not comparable: torpedo-shaped vehicles that cannot hover, and a cone that we have not "
        "modelled.",
    ),
)
DATA_SETS = (
    (
        "Gabl et al. 2020, Data 5(3) 57, <https://doi.org/10.3390/data5030057>",
        "forces on a restrained BlueROV2 in current and waves",
        "It does not move, so there is nothing to fit: compare its forces with the drag above.",
    ),
    (
        "NTNU, <https://github.com/ntnu-arl/underwater-datasets>",
        "ROS bags of a BlueROV2 Heavy: pulse widths of the thrusters (`mavros` RC out), IMU, "
        "depth; some with motion capture",
        "Convert RC out and the velocity from motion capture to a CSV with `command_0` to "
        "`command_7`, (width - 1500) / 400, and `u` to `r`. We have not seen the bags.",
    ),
    (
        "Khanmeh et al., motion capture of a BlueROV2 and its tether (PMC12808086)",
        "motion, sensors on board, tension of the tether",
        "In the same way, if the tether is slack: a tension that is logged beside the thrusters' "
        "commands cannot be given yet. We have not seen it.",
    ),
    (
        "Schillai 2017, Delphin2, <https://doi.org/10.5258/SOTON/D1157> (CC BY)",
        "ROS bags of a hovering AUV over a lake bed",
        "Needs a vehicle's file of Delphin2, and messages of its own types as a CSV.",
    ),
)


def text() -> str:
    """Return the page."""
    return "\n\n".join(
        [
            "# Vehicles against measurements",
            "`./run performance vehicle_versions` computes this page. It puts both versions of the "
            "BlueROV2 Heavy beside what is published of the real one, then lists every other "
            "comparison with its verdict. How each number was read is on the page "
            "[Validation](validation.md), with the list of sources.",
            "## Pull, speed and drag",
            "In brackets: ours relative to the measurement. *Uncertainty* is what the source "
            "leaves open; none states an interval. Benchmarks made since then have the second "
            "version.",
            markdown_table(
                ("quantity", *entries.VERSIONS, "measured", "uncertainty", "source"), steady_rows()
            ),
            "## Step responses",
            "Full force along one axis with the others balanced, from rest, and the second "
            "version with the drag that others identified:",
            markdown_table(("motion", *entries.VERSIONS, "with the drag of others"), step_rows()),
            "![Step responses to half of the greatest force](figures/bluerov2-steps.png)",
            "## Verdicts",
            markdown_table(("BlueROV2", "verdict"), VERDICTS),
            markdown_table(("compared", "source", "verdict"), OTHER_VERDICTS),
            "## The order of entries",
            entries.text(),
            "## Repeat it with data that we cannot ship",
            "Licences, size or access keep these sets away from here. `seamark identify` reads "
            "CSV, MCAP and ROS bags ([columns](identification.md#the-log)).",
            markdown_table(("data", "has", "how"), DATA_SETS),
        ]
    )


def main(_arguments: Sequence[str]) -> int:
    """Write the page and its figure."""
    draw(DOCS / "figures" / "bluerov2-steps.png")
    (DOCS / PAGE).write_text(text() + "\n", encoding="utf-8")
    print(f"wrote {DOCS / PAGE}")
    return 0
