"""The Girona 500 as UWSim simulates it: the plant of the published experiment, for comparison.

A quarter of the drag in sway and heave, thrusters 50 % stronger than the real ones, and a "current"
that is a force. Its defaults select the laws of the experiment.
"""

from dataclasses import replace

from seamark.sim.vehicles import Quantity, ThrustCurve, Thruster
from seamark.sim.vehicles.girona500 import VEHICLE as REAL

_UWSIM = "underwater_simulation 7f4a276, config/dynamics_g500.yaml"

_MASS = 98.0
_WEIGHT = _MASS * 9.81
_FULL_COMMAND = 6.835e-5 * 1500.0**2  # [N] ct times full speed squared


def _uwsim(meaning: str, value: tuple[float, ...], unit: str) -> Quantity:
    return Quantity(meaning=meaning, value=value, unit=unit, tag="S", source=_UWSIM)


def _thrust(meaning: str) -> Quantity:
    value = (_FULL_COMMAND,)
    return Quantity(meaning=meaning, value=value, unit="N", tag="D", source=_UWSIM)


def _thruster(
    name: str, position: tuple[float, float, float], direction: tuple[float, float, float]
) -> Thruster:
    return Thruster(name=name, position=_uwsim("arm", position, "m"), direction=direction)


VEHICLE = replace(
    REAL,  # the hull for contacts is the real one's
    name="girona500-uwsim",
    title="Girona 500 as in UWSim (the paper's plant)",
    summary="The published experiment's plant and laws, to compare with its figures.",
    mass=_uwsim("mass", (_MASS,), "kg"),
    inertia=_uwsim("inertia about the origin", (8.0, 8.0, 8.0), "kg m²"),
    inertia_point="origin",
    added_mass=(
        _uwsim("added mass, half of the vehicle's", (49.0, 49.0, 49.0), "kg"),
        _uwsim("added inertia", (0.0, 0.0, 0.0), "kg m²"),
    ),
    drag_linear=(
        _uwsim("linear drag x, y, z", (0.0, 0.0, 0.0), "N s/m"),
        _uwsim("linear drag roll, pitch, yaw", (130.0, 130.0, 130.0), "N m s"),
    ),
    drag_quadratic=(
        _uwsim("quadratic drag x, y, z", (148.0, 148.0, 148.0), "N s²/m²"),
        _uwsim("quadratic drag roll, pitch, yaw", (180.0, 180.0, 180.0), "N m s²"),
    ),
    weight=_uwsim("weight in air", (_WEIGHT,), "N"),
    buoyancy=_uwsim("weight of the displaced water, neutral", (_WEIGHT,), "N"),
    centre_of_gravity=_uwsim("centre of gravity", (0.0, 0.0, 0.05), "m"),
    centre_of_buoyancy=_uwsim("centre of buoyancy", (0.0, 0.0, 0.0), "m"),
    thrusters=(
        _thruster("surge port", (0.0, -0.4, 0.0), (1.0, 0.0, 0.0)),
        _thruster("surge starboard", (0.0, 0.4, 0.0), (1.0, 0.0, 0.0)),
        _thruster("heave bow", (0.35, 0.0, 0.0), (0.0, 0.0, 1.0)),
        _thruster("heave stern", (-0.35, 0.0, 0.0), (0.0, 0.0, 1.0)),
        _thruster("sway", (0.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
    ),
    curve=ThrustCurve(
        kind="quadratic",
        forward=_thrust("thrust at full command"),
        reverse=_thrust("thrust at full reverse command"),
        dead_band=_uwsim("no dead band", (0.0,), "1"),
        limits=Quantity(
            meaning="greatest thrust forward, reverse",
            value=(_FULL_COMMAND, _FULL_COMMAND),
            unit="N",
            tag="D",
            source=_UWSIM,
        ),
    ),
    lag=_uwsim("time constant of the thrust", (0.2,), "s"),
    defaults={
        # UWSim adds 410 v² as a force in the body frame and drops all but a share k of it.
        "current_law": "force",
        "current_azimuth_rad": 1.5707963267948966,
        "current_wave_m_s": 0.0,
        "current_gust": 0.0,
        "velocity_law": "paper",  # u = 5 (v_ref - v) in surge and heave, 6 (...) in sway
        "reference_limit_m_s": 5.0,
        # The scene of the published experiment.
        "water_law": "uwsim",
        "water_type": "grey",
        "water_attenuation_1_m": 0.1,  # S: UWSim's default fog
        "range_from": "start",
        "level_out_tilt": False,
        "heading_hold": False,
        "depth_hold": False,
    },
)
