"""Presets that the form of a station-keeping benchmark offers."""

import math

from seamark.sim.benchmarks.benchmark import StartingPoint

_PUBLISHED = {"vehicle": "girona500-uwsim", "kp": 0.5, "ki": 0.02}  # Pérez et al.
PAPER = {
    "paper-pi": StartingPoint(
        "Paper's PI",
        "PI with the published gains, on the published plant and in its current.",
        _PUBLISHED,
        "pi",
    ),
    "paper-p": StartingPoint(
        "Paper's P",
        "P with the published gain, on the published plant and in its current.",
        _PUBLISHED,
        "p",
    ),
}
HARDER = {
    "beam-current": StartingPoint(
        "Beam current",
        "The current comes from starboard instead of from ahead.",
        {"current_azimuth_rad": round(0.5 * math.pi, 4)},
    ),
    "weak-thruster": StartingPoint(
        "Weak thruster",
        "Thruster 0 produces only half of its thrust.",
        {"fault_thruster": 0, "fault_efficiency": 0.5},
    ),
    "turbid": StartingPoint(
        "Turbid water",
        "Turbid coastal water, in which the camera sees the target with less contrast.",
        {"water_type": "5C"},
    ),
    "bluerov2": StartingPoint(
        "BlueROV2",
        "A lighter vehicle with eight thrusters, with its own defaults.",
        {"vehicle": "bluerov2-heavy"},
    ),
}
