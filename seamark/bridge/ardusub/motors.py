"""ArduSub's motors on the thrusters of the BlueROV2 Heavy.

ArduSub's frame VECTORED_6DOF numbers them as the vehicle does here: 1 to 4 are the horizontal ones,
front starboard, front port, rear starboard, rear port; 5 to 8 the vertical ones in the same order.
A positive output pushes as its factors in libraries/AP_Motors/AP_Motors6DOF.cpp say: the front two
of the horizontal ones push backwards, the vertical ones down.
"""

from collections.abc import Sequence

import numpy as np

from seamark.sim.numerics.arrays import Array

VEHICLE = "bluerov2-heavy"
SIGNS = (-1.0, -1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0)  # of thrust along the thruster's direction
NEUTRAL_US = 1500  # [µs] no thrust
SPAN_US = 400.0  # [µs] from there to full thrust: 1100 to 1900 µs, as the T200's speed controller
NO_PULSE = 0  # while ArduPilot starts


def commands_of(pulses_us: Sequence[int]) -> Array:
    """Return the thrusters' commands, (8,) in [-1, 1]."""
    commands = np.zeros(len(SIGNS))
    for at, sign in enumerate(SIGNS):
        if pulses_us[at] != NO_PULSE:
            effort = (pulses_us[at] - NEUTRAL_US) / SPAN_US
            commands[at] = sign * min(max(effort, -1.0), 1.0)
    return commands
