"""Solids that a file draws something with."""

import re
from typing import Any, get_args

from seamark.sim.vehicles.fields import Fields, Table, quoted
from seamark.sim.vehicles.solids import Paint, Shape, Solid

_COLOUR = re.compile(r"#[0-9a-f]{6}")


def read_solid(fields: Fields, path: str, entry: Table) -> Solid:
    """Return a solid of a file."""
    fields.known(path, entry, ("shape", "size", "centre", "colour", "livery", "lettered"))
    shape: Any = fields.choice(f"{path}.shape", entry.get("shape"), get_args(Shape))
    size = fields.triple(f"{path}.size", entry.get("size"), above=0.0)
    centre = fields.triple(f"{path}.centre", entry.get("centre"))
    colour, livery = entry.get("colour"), entry.get("livery", False)
    lettered = entry.get("lettered", False)
    if not isinstance(colour, str) or not _COLOUR.fullmatch(colour):
        fields.wrong(
            f'{path}.colour must be # and six digits in small letters, such as "#f2b61d", not '
            f"{quoted(colour)}."
        )
    if not isinstance(livery, bool):
        fields.wrong(f"{path}.livery must be true or false.")
    if not isinstance(lettered, bool) or (lettered and shape != "box"):
        fields.wrong(f"{path}.lettered must be true or false, and true for a box only.")
    return Solid(shape, size, centre, Paint(str(colour), bool(livery)), bool(lettered))
