"""Which runs have a map beside their charts, and of what."""

from collections.abc import Collection

KINDS = {"decoy_x": "search", "route_x": "route"}  # by a column that only its runs have


def map_of(columns: Collection[str]) -> str | None:
    """Return what the map of a run with these columns shows; None where there is none."""
    return next((kind for column, kind in KINDS.items() if column in columns), None)
