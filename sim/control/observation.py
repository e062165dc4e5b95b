"""The observation that a program gets at each control step, and how it is packed into numbers.

The layout is data: the simulator packs by it and the sandbox unpacks by it, in every language.
Ground truth is never part of an observation.
"""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seamark.sim.vehicles import load

PER_THRUSTER = -1  # as many numbers as the vehicle has thrusters; for the last field only

# name, count (0: a single number), unit, meaning
FIELDS: tuple[tuple[str, int, str, str], ...] = (
    ("t", 0, "s", "simulated time since the trial began"),
    ("dt", 0, "s", "time between two steps"),
    (
        "error",
        3,
        "m",
        "position error: how far to move, body frame (x forward, y starboard, z down)",
    ),
    ("error_px", 2, "px", "tracked target minus image centre (x right, y down)"),
    ("target_visible", 0, "", "whether the tracker has the target now"),
    ("target_age", 0, "s", "time since the tracker last had the target"),
    ("velocity", 3, "m/s", "last velocity over ground from the DVL, body frame"),
    ("velocity_valid", 0, "", "whether the last DVL measurement was good"),
    ("depth", 0, "m", "depth of the vehicle"),
    ("altitude", 0, "m", "height of the vehicle above the bottom"),
    ("attitude", 3, "rad", "roll, pitch, yaw"),
    ("rates", 3, "rad/s", "p, q, r"),
    ("thrust", PER_THRUSTER, "N", "last thrust of each thruster; as many as the vehicle has"),
)
BOOLEANS = ("target_visible", "velocity_valid")
COMMAND = ("surge", "sway", "heave", "yaw_rate")


def layout(vehicle: str) -> dict[str, Any]:
    """Return how observations and commands of a vehicle are packed, as plain JSON values."""
    thrusters = len(load(vehicle).thrusters)
    fields = [
        [name, thrusters if count == PER_THRUSTER else count]
        for name, count, _unit, _meaning in FIELDS
    ]
    return {"observation": fields, "command": list(COMMAND), "booleans": list(BOOLEANS)}


def _starts() -> dict[str, int]:
    starts, start = {}, 0
    for name, count, _unit, _meaning in FIELDS:
        starts[name] = start
        start += max(count, 1)
    return starts


STARTS = _starts()  # name -> index of its first number
# name -> index of a single number, or slice of a vector; that of the thrusters goes to the end
_POSITIONS: dict[str, int | slice] = {
    name: slice(STARTS[name], None if count == PER_THRUSTER else STARTS[name] + count)
    if count
    else STARTS[name]
    for name, count, _unit, _meaning in FIELDS
}


def empty(thrusters: int) -> NDArray[np.float64]:
    """Return a packed observation of zeros, (size,), for a vehicle with this many thrusters."""
    return np.zeros(STARTS["thrust"] + thrusters)


class Observation(Mapping[str, Any]):
    """One observation by name: `observation.error` and `observation["error"]` are the same.

    Numbers are floats, vectors are read-only arrays of float64, the fields in BOOLEANS are bool.
    `thrust` has one number per thruster of the vehicle. It copies the numbers, so that a
    program may keep it.
    """

    __slots__ = ("_numbers",)

    def __init__(self, values: NDArray[np.float64]) -> None:
        self._numbers = values.copy()
        self._numbers.flags.writeable = False

    def __getitem__(self, name: str) -> Any:  # float, bool or array, by the layout
        """Return a field by its name."""
        field = _POSITIONS[name]
        if isinstance(field, slice):
            return self._numbers[field]
        value = self._numbers.item(field)
        return value != 0.0 if name in BOOLEANS else value

    def __getattr__(self, name: str) -> Any:
        """Return a field by its name."""
        try:
            return self[name]
        except KeyError:
            raise AttributeError(f"an observation has no {name}") from None

    def __iter__(self) -> Iterator[str]:
        """Iterate over the names in the order of the layout."""
        return iter(_POSITIONS)

    def __len__(self) -> int:
        """Return the number of fields."""
        return len(_POSITIONS)
