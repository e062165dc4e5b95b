"""Every vehicle's numbers, read from the vehicle itself."""

from pathlib import Path

from performance.validation.markdown import table
from seamark.sim.registry import VEHICLES
from seamark.sim.vehicles import TAGS, Quantity, Vehicle, load

TITLE = "The vehicles' numbers and where they are from"


def names() -> list[str]:
    """Return the names of all vehicles, in the order of the alphabet."""
    return sorted(VEHICLES)


def _value(quantity: Quantity) -> str:
    return ", ".join(f"{value:.6g}" for value in quantity.value)


def vehicle_text(vehicle: Vehicle) -> str:
    """Return one vehicle's heading and table."""
    rows = [
        (key.replace("_", " "), q.meaning, _value(q), q.unit, q.tag, q.source)
        for key, q in vehicle.quantities()
    ]
    header = ("number", "meaning", "value", "unit", "tag", "source")
    title = f"### `{vehicle.name}`: {vehicle.title}"
    return f"{title}\n\n{vehicle.summary}\n\n{table(header, rows)}"


def section(found: list[str], _figures: Path) -> str:
    """Return the section's text."""
    tags = "; ".join(f"**{tag}** {meaning}" for tag, meaning in TAGS.items())
    return "\n\n".join(
        [
            f"How: read from the files of `sim/vehicles`, which the simulator uses. Tags: {tags}.",
            *(vehicle_text(load(name)) for name in found),
        ]
    )
