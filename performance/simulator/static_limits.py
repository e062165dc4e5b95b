"""The strongest steady current that the thrusters of each vehicle can hold, by its direction.

The vehicle stands still in a steady current with its bow to the north; a
linear programme says whether thrusts within their limits balance surge, sway, heave and yaw. Roll
and pitch are left to the righting moment. What the levels of currents-v2 are chosen by.
"""

import numpy as np
import scipy  # its parts are loaded when they are used

from performance.tables import markdown_table
from seamark.sim.benchmarks.currents_v2.settings import SINGLE
from seamark.sim.physics.current import Current, Pattern
from seamark.sim.physics.plant import Plant
from seamark.sim.vehicles import Vehicle, load

DIRECTIONS_DEG = tuple(range(0, 181, 15))  # from the bow, to starboard and to port
SIDES = {"starboard": 1, "port": -1}
BALANCED = [0, 1, 2, 5]  # surge, sway, heave, yaw
FASTEST_M_S = 2.0
BISECTIONS = 12  # to half a millimetre per second


def can_hold(vehicle: Vehicle, speed: float, azimuth_rad: float) -> bool:
    """Return whether the thrusters can hold the vehicle still in a steady current [m/s]."""
    pattern = Pattern(azimuth_rad=azimuth_rad, azimuth_swing_rad=0.0, speed_swing=0.0)
    plant = Plant(vehicle, Current(speed, pattern=pattern))
    mass = vehicle.mass_rigid() + vehicle.mass_added()
    needed = -(mass @ plant.acceleration())[BALANCED]
    allocation = vehicle.allocation()[BALANCED]
    forward, reverse = vehicle.curve.limits.value
    solution = scipy.optimize.linprog(
        np.zeros(allocation.shape[1]), A_eq=allocation, b_eq=needed, bounds=(-reverse, forward)
    )
    return bool(solution.success)


def limit(vehicle: Vehicle, azimuth_rad: float) -> float:
    """Return the strongest current [m/s] that can be held."""
    low, high = 0.0, FASTEST_M_S
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if can_hold(vehicle, middle, azimuth_rad) else (low, middle)
    return low


def table() -> str:
    """Return the table, in Markdown."""
    vehicles = [load(name) for name in SINGLE]
    lines = [
        [f"{degrees}°", *(limits_of(vehicle, degrees) for vehicle in vehicles)]
        for degrees in DIRECTIONS_DEG
    ]
    head = ["current from", *(f"{vehicle.title} [m/s]" for vehicle in vehicles)]
    return markdown_table(head, lines)


def limits_of(vehicle: Vehicle, degrees: float) -> str:
    """Return the limit of a direction [m/s]; of both sides, starboard first, if they differ."""
    both = [f"{limit(vehicle, side * np.radians(degrees)):.2f}" for side in SIDES.values()]
    return " / ".join(dict.fromkeys(both))
