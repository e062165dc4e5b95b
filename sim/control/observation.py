"""What the user's program sees at each control tick, and the order in which it travels.

The layout is data: the simulator packs by it, the box unpacks by it, in every language.
Ground truth is never part of it.
"""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seamark.sim.vehicles import load

THRUSTERS = 8  # the most that a vehicle has; an observation has as many as its own vehicle

# name, count (0: one number), unit, meaning
FIELDS: tuple[tuple[str, int, str, str], ...] = (
    ("t", 0, "s", "simulated time since the trial began"),
    ("dt", 0, "s", "time from one step to the next"),
    (
        "error",
        3,
        "m",
        "how far the vehicle has to move, body frame (x forward, y starboard, z down)",
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
    ("thrust", THRUSTERS, "N", "last thrust of each thruster; as many as the vehicle has"),
)
BOOLEANS = ("target_visible", "velocity_valid")
COMMAND = ("surge", "sway", "heave", "yaw_rate")


def layout(vehicle: str) -> dict[str, Any]:
    """Return what travels to a program and back; `thrust` is as long as the vehicle's list."""
    named = [[name, count] for name, count, _unit, _meaning in FIELDS]
    named[-1] = ["thrust", len(load(vehicle).thrusters)]
    return {"observation": named, "command": list(COMMAND), "booleans": list(BOOLEANS)}


def _starts() -> dict[str, int]:
    starts, at = {}, 0
    for name, count, _unit, _meaning in FIELDS:
        starts[name] = at
        at += max(count, 1)
    return starts


STARTS = _starts()  # name -> index of its first number


def empty(thrusters: int) -> NDArray[np.float64]:
    """Return an observation of zeros for a vehicle with so many thrusters, (size,)."""
    return np.zeros(STARTS["thrust"] + thrusters)


class Observation(Mapping[str, Any]):
    """One observation by name: `observation.error` and `observation["error"]` are the same.

    Numbers are floats, vectors are tuples of floats, the two of BOOLEANS are bool. `thrust`, the
    last field, is as long as the vehicle has thrusters.
    """

    __slots__ = ("_values",)

    def __init__(self, values: NDArray[np.float64]) -> None:
        numbers = values.tolist()
        named: dict[str, Any] = {}
        for name, count, _unit, _meaning in FIELDS:
            start = STARTS[name]
            named[name] = tuple(numbers[start : start + count]) if count else numbers[start]
        # A slice ends where the numbers end: `thrust` comes last and may be shorter.
        for name in BOOLEANS:
            named[name] = named[name] != 0.0
        self._values = named

    def __getitem__(self, name: str) -> Any:  # float, bool or tuple, by the layout
        """Return a field by its name."""
        return self._values[name]

    def __getattr__(self, name: str) -> Any:
        """Return a field by its name."""
        try:
            return self._values[name]
        except KeyError:
            raise AttributeError(f"an observation has no {name}") from None

    def __iter__(self) -> Iterator[str]:
        """Return the names in the layout's order."""
        return iter(self._values)

    def __len__(self) -> int:
        """Return the number of fields."""
        return len(self._values)
