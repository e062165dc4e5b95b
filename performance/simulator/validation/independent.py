"""The plant compared with the independent reference over a free manoeuvre of a minute."""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from performance.simulator.validation.convergence import START, commands
from performance.simulator.validation.reference import Leg, Water, reference
from performance.tables import below, markdown_table
from seamark.sim.numerics.arrays import Array
from seamark.sim.physics.current import Current, Pattern
from seamark.sim.physics.plant import STEP_S, Plant
from seamark.sim.vehicles import load

TITLE = "Comparison with an independent implementation"
LEG_S = 10.0
LEG_SCALES = (1.0, -0.6, 0.3, -1.0, 0.8, 0.5)  # factor on the commands in each leg
LEVEL, AZIMUTH = 0.4, 0.5


class Difference(NamedTuple):
    """Largest differences between plant and reference at the end."""

    name: str
    law: str
    position_mm: float
    angle_rad: float
    speed_mm_s: float
    travelled_m: float


def legs_of(count: int, leg_s: float = LEG_S) -> list[Leg]:
    """Return the manoeuvre for a number of thrusters."""
    return [Leg(leg_s, scale * commands(count)) for scale in LEG_SCALES]


def plant_end(name: str, legs: list[Leg], water: Water) -> Array:
    """Return pose, velocity and thrusts of our plant after the manoeuvre, (12 + n,)."""
    pattern = Pattern(azimuth_rad=water.azimuth, law="force" if water.force else "relative")
    plant = Plant(load(name), Current(water.level, pattern=pattern))
    plant.reset(START)
    step = 0
    for leg in legs:
        steps = round(leg.seconds / plant.step_s)
        plant.advance(step, leg.command, steps)
        step += steps
    return np.concatenate((plant.pose(), plant.velocity(), plant.thrust()))


def difference(name: str, *, force: bool, leg_s: float = LEG_S) -> Difference:
    """Return the difference between the two after the manoeuvre."""
    legs = legs_of(len(load(name).thrusters), leg_s)
    water = Water(level=LEVEL, azimuth=AZIMUTH, force=force)
    ours, other = plant_end(name, legs, water), reference(load(name), START, legs, water)
    apart = np.abs(ours - other)
    turned = apart[3:6] % (2.0 * np.pi)  # the reference does not wrap angles
    return Difference(
        name=name,
        law="force" if force else "relative",
        position_mm=1e3 * float(apart[:3].max()),
        angle_rad=float(np.minimum(turned, 2.0 * np.pi - turned).max()),
        speed_mm_s=1e3 * float(apart[6:9].max()),
        travelled_m=float(np.linalg.norm(ours[:3] - START[:3])),
    )


def section(names: list[str], _figures: Path) -> str:
    """Return the section's text."""
    differences = [difference(name, force=force) for name in names for force in (False, True)]
    worst = max(entry.position_mm for entry in differences)
    rows = [
        (
            *(d.name, d.law, f"{d.travelled_m:.1f}", below(d.position_mm)),
            *(below(d.angle_rad), below(d.speed_mm_s)),
        )
        for d in differences
    ]
    header = ("vehicle", "current law", "moved m", "position mm", "angle rad", "speed mm/s")
    return "\n\n".join(
        [
            f"After {LEG_S * len(LEG_SCALES):g} s all positions differ by {below(worst)} mm. The "
            "differences are rounding errors, so only their powers of ten are given.",
            f"Method: {len(LEG_SCALES)} legs of {LEG_S:g} s in open loop with different commands "
            f"on all thrusters, from a tilted start, in a current of {LEVEL:g} m/s with both "
            "sinusoids and no gusts. The reference "
            "(`performance/simulator/validation/reference.py`) shares the vehicle parameters with "
            "the plant, and the mass and allocation matrices computed from them, but no equation "
            "of motion: Euler angles instead of a quaternion, Fossen's "
            "C(v) from the blocks of the mass matrix, thrust curves inverted by Brent's method, "
            "SciPy's DOP853 with a relative tolerance of 1e-11. "
            f"The plant's step is {1e3 * STEP_S:g} ms. A wrong parameter in a vehicle's file would "
            "be wrong in both; the last part lists their sources.",
            markdown_table(header, rows),
        ]
    )
