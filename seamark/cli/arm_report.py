"""What `seamark vehicle check` says about an arm."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from seamark.sim.vehicles.arm_check import ArmFigures
    from seamark.sim.vehicles.linkage import Linkage


def figures_of(found: ArmFigures) -> dict[str, Any]:
    """Return what follows from an arm's numbers, as plain JSON values; None: without limit."""
    return {
        "reach_m": found.reach_m,
        "mass_kg": found.mass_kg,
        "weight_in_water_n": found.weight_in_water_n,
        "payload_n": _finite(found.payload_n),
        "joints": [
            {
                "link": one.name,
                "kind": "revolute" if one.turns else "prismatic",
                "effort": one.effort,
                "speed": one.speed,
                "own_weight": one.own_weight,
                "payload_n": _finite(one.payload_n),
                "inertia": one.inertia,
            }
            for one in found.joints
        ],
    }


def lines(
    arm: Linkage, found: ArmFigures, errors: Sequence[str], warnings: Sequence[str]
) -> Iterator[str]:
    """Yield the lines of the report."""
    yield f"{arm.title} ({arm.name}), {_counted(len(found.joints), 'motor')}"
    yield from (f"error    {text}" for text in errors)
    yield from (f"warning  {text}" for text in warnings)
    yield ""
    yield f"reach    {found.reach_m:.3g} m from the first joint, level"
    yield f"mass     {found.mass_kg:.3g} kg; in water it weighs {found.weight_in_water_n:.3g} N"
    payload = f"{found.payload_n:.3g} N" if math.isfinite(found.payload_n) else "not limited"
    yield f"payload  {payload} in water at the tip, stretched out level"
    yield ""
    heads = (
        ("effort", 11),
        ("own weight", 14),
        ("payload", 11),
        ("top speed", 14),
        ("inertia", 15),
    )
    yield f"{'motor':<16}" + "".join(f"{head:>{width}}" for head, width in heads)
    for one in found.joints:
        effort, speed, inertia = ("N m", "rad/s", "kg m²") if one.turns else ("N", "m/s", "kg")
        cells = (
            f"{one.effort:.3g} {effort}",
            f"{round(one.own_weight, 3):g} {effort}",
            f"{one.payload_n:.3g} N" if math.isfinite(one.payload_n) else "-",
            f"{one.speed:.3g} {speed}",
            f"{one.inertia:.2g} {inertia}",
        )
        widths = (width for _, width in heads)
        yield f"{one.name[:15]:<16}" + "".join(
            f"{cell:>{width}}" for cell, width in zip(cells, widths, strict=True)
        )
    yield "own weight: what it takes to hold the arm in water; payload: what it holds besides."
    yield ""
    yield f"{_counted(len(errors), 'error')}, {_counted(len(warnings), 'warning')}."


def _counted(count: int, what: str) -> str:
    return f"{count} {what}" if count == 1 else f"{count} {what}s"


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
