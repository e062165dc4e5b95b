"""The parameters of every vehicle, read from its file."""

from pathlib import Path

from performance.tables import markdown_table
from seamark.sim.registry import VEHICLES
from seamark.sim.vehicles import TAGS, Quantity, Vehicle, load

TITLE = "Vehicle parameters and their sources"


def names() -> list[str]:
    """Return the names of all vehicles, in alphabetical order."""
    return sorted(VEHICLES)


def _value(quantity: Quantity) -> str:
    if quantity.spread is None:
        return ", ".join(f"{value:.6g}" for value in quantity.value)
    lows, highs = quantity.spread
    rows = zip(quantity.value, lows, highs, strict=True)
    return ", ".join(f"{value:.6g} ({low:.6g} to {high:.6g})" for value, low, high in rows)


def vehicle_text(vehicle: Vehicle) -> str:
    """Return one vehicle's heading and table."""
    rows = [
        (key.replace("_", " "), q.meaning, _value(q), q.unit, q.tag, q.source)
        for key, q in vehicle.quantities()
    ]
    header = ("parameter", "meaning", "value", "unit", "tag", "source")
    title = f"### `{vehicle.name}`: {vehicle.title}"
    return f"{title}\n\n{vehicle.summary}\n\n{markdown_table(header, rows)}"


def section(vehicles: list[str], _figures: Path) -> str:
    """Return the section's text."""
    tags = "; ".join(f"**{tag}** {meaning}" for tag, meaning in TAGS.items())
    return "\n\n".join(
        [
            f"Read from the files of `sim/vehicles`, as used by the simulator. Tags: {tags}. In "
            "brackets: the least and greatest value that sources give, where they differ much.",
            *(vehicle_text(load(name)) for name in vehicles),
        ]
    )
