"""Mass and forces of a slender cylinder, where nobody has measured a part.

Every number from here is an estimate: real parts have flanges, cables and neighbours.
"""

import math
from collections.abc import Sequence

import numpy as np

from seamark.sim.vehicles.model import Quantity

FRESH_WATER = 1000.0  # [kg/m³]
# DNV-RP-H103, right circular cylinder across its axis: added mass of a length over a diameter, as
# a share of the displaced mass.
_SLENDERNESS = (0.0, 1.2, 2.5, 5.0, 9.0, 50.0)
_SHARE = (0.0, 0.62, 0.78, 0.90, 0.96, 1.0)
_DRAG = 1.1  # across the axis, below the drag crisis
_ALONG_ADDED = 0.1  # share of the displaced mass: the ends are mostly covered by neighbours
_ALONG_DRAG = 0.1  # on the area of one end


def volume_of(length: float, radius: float) -> Quantity:
    """Return the volume, (1,) [m³]."""
    return _estimate("volume", [math.pi * radius * radius * length], "m³")


def inertia_of(mass: float, length: float, radius: float, axis: int) -> Quantity:
    """Return the moments of inertia about the centre of a uniform solid, (3,) [kg m²]."""
    across = mass * (3.0 * radius * radius + length * length) / 12.0
    return _along("inertia", [0.5 * mass * radius * radius, across, across], axis, "kg m²")


def added_mass_of(length: float, radius: float, axis: int) -> Quantity:
    """Return the added mass, (3,) [kg]."""
    displaced = FRESH_WATER * math.pi * radius * radius * length
    across = displaced * _share(length, radius)
    return _along("added mass", [_ALONG_ADDED * displaced, across, across], axis, "kg")


def added_inertia_of(length: float, radius: float, axis: int) -> Quantity:
    """Return the added inertia about the centre, (3,) [kg m²]: of strips across the axis."""
    displaced = FRESH_WATER * math.pi * radius * radius * length
    across = displaced * _share(length, radius) * length * length / 12.0
    return _along("added inertia", [0.0, across, across], axis, "kg m²")


def drag_of(length: float, radius: float, axis: int) -> Quantity:
    """Return the quadratic drag, (3,) [N s²/m²]."""
    across = 0.5 * FRESH_WATER * _DRAG * 2.0 * radius * length
    along = 0.5 * FRESH_WATER * _ALONG_DRAG * math.pi * radius * radius
    return _along("quadratic drag", [along, across, across], axis, "N s²/m²")


def turning_drag_of(length: float, radius: float, axis: int) -> Quantity:
    """Return the quadratic drag of turning about the centre, (3,) [N m s²]."""
    across = 0.5 * FRESH_WATER * _DRAG * 2.0 * radius * (length * length * length * length) / 32.0
    return _along("quadratic drag of turning", [0.0, across, across], axis, "N m s²")


def _share(length: float, radius: float) -> float:
    return float(np.interp(0.5 * length / radius, _SLENDERNESS, _SHARE))


def _along(meaning: str, values: Sequence[float], axis: int, unit: str) -> Quantity:
    """Return three numbers that were meant for a cylinder along x, for one along another axis."""
    return _estimate(meaning, [values[(i - axis) % 3] for i in range(3)], unit)


def _estimate(meaning: str, values: Sequence[float], unit: str) -> Quantity:
    return Quantity(
        meaning=meaning, value=tuple(values), unit=unit, tag="E", source="theory of a cylinder"
    )
