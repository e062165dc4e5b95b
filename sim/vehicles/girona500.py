"""Girona 500 with realistic dynamics: three torpedo hulls, five thrusters, 143 kg dry.

The masses are those of Stonefish's parts list; drag and thrusters those of the COLA2 controller of
the real vehicle. The origin is COLA2's base link; the arms of its thruster matrix are used as
they are, so surge and heave thrusters act in the planes through the origin.
"""

from collections.abc import Iterator

from seamark.sim.vehicles import HullBox, Quantity, ThrustCurve, Thruster, Vehicle
from seamark.sim.vehicles.solids import DARK, METAL, YELLOW, Paint, Solid

_STONEFISH = "Stonefish b21eb8e1, Tests/Data/girona500auv_full.scn"
_COLA2 = "COLA2 controller parameters of the real vehicle (Iqua Robotics, ROS 2 port)"
_SIZE_OF_HULLS = "three flooded hulls as spheroids (k1 0.060, k2 0.892, k' 0.694), ±30 %"

_MASS = 143.0
_INERTIA = (24.2, 27.1, 17.8)
_CENTRE_OF_GRAVITY = (0.0, 0.0, 0.054)
# Dry mass, water inside the hulls and water moved outside them, about the origin.
_EFFECTIVE_MASS = (300.0, 540.0, 540.0)
_EFFECTIVE_INERTIA = (95.0, 110.0, 75.0)
_SHIFT = _MASS * _CENTRE_OF_GRAVITY[2] ** 2  # [kg m²] parallel axis, roll and pitch
_WEIGHT = 1403.0

# Centres of the three hulls and their common size [m]
_LOWER, _PORT, _STARBOARD = (-0.049, 0.0, 0.361), (-0.049, -0.35, -0.339), (-0.049, 0.35, -0.339)
_LENGTH, _DIAMETER = 1.507, 0.306


def _arm(meaning: str, position: tuple[float, float, float], source: str = _COLA2) -> Quantity:
    return Quantity(meaning=meaning, value=position, unit="m", tag="S", source=source)


def _hull(name: str, centre: tuple[float, float, float]) -> HullBox:
    return HullBox(
        name=name,
        centre=Quantity(
            meaning="centre of the hull", value=centre, unit="m", tag="S", source=_STONEFISH
        ),
        size=Quantity(
            meaning="box around the hull",
            value=(_LENGTH, _DIAMETER, _DIAMETER),
            unit="m",
            tag="S",
            source=_STONEFISH,
        ),
    )


def _torpedo(centre: tuple[float, float, float], paint: Paint) -> Iterator[Solid]:
    """Yield a hull with the two rings by which the frame holds it."""
    yield Solid("capsule", (_LENGTH, _DIAMETER, _DIAMETER), centre, paint)
    x, y, z = centre
    for ahead in (0.45, -0.45):
        around = 1.02 * _DIAMETER
        yield Solid("cylinder", (0.05, around, around), (x + ahead, y, z), METAL)


def _frame(x: float) -> Iterator[Solid]:
    """Yield the bars between the three hulls."""
    height = _LOWER[2] - _PORT[2]
    yield Solid("box", (0.05, _STARBOARD[1] - _PORT[1], 0.05), (x, 0.0, _PORT[2]), METAL)
    yield Solid("box", (0.05, 0.05, height), (x, 0.0, _PORT[2] + height / 2), METAL)


VEHICLE = Vehicle(
    name="girona500",
    title="Girona 500",
    summary="Realistic: identified drag, real thruster curve and limits; weak in sway.",
    mass=Quantity(meaning="dry mass", value=(_MASS,), unit="kg", tag="D", source=_STONEFISH),
    inertia=Quantity(
        meaning="dry inertia about the centre of gravity",
        value=_INERTIA,
        unit="kg m²",
        tag="D",
        source=_STONEFISH,
    ),
    inertia_point="gravity",
    added_mass=(
        Quantity(
            meaning="water inside and around the hull; with the dry mass 300, 540, 540 kg",
            value=tuple(whole - _MASS for whole in _EFFECTIVE_MASS),
            unit="kg",
            tag="E",
            source=_SIZE_OF_HULLS,
        ),
        Quantity(
            meaning="water inside and around the hull; with the dry inertia 95, 110, 75 kg m²",
            value=(
                _EFFECTIVE_INERTIA[0] - _INERTIA[0] - _SHIFT,
                _EFFECTIVE_INERTIA[1] - _INERTIA[1] - _SHIFT,
                _EFFECTIVE_INERTIA[2] - _INERTIA[2],
            ),
            unit="kg m²",
            tag="E",
            source=_SIZE_OF_HULLS,
        ),
    ),
    drag_linear=(
        Quantity(
            meaning="linear drag x, y, z",
            value=(40.0, 40.0, 40.0),
            unit="N s/m",
            tag="S",
            source=_COLA2 + ", feed-forward",
        ),
        Quantity(
            meaning="linear drag roll, pitch",
            value=(30.0, 30.0),
            unit="N m s",
            tag="E",
            source="between the identified yaw and UWSim's 130",
        ),
        Quantity(
            meaning="linear drag yaw",
            value=(10.0,),
            unit="N m s",
            tag="S",
            source=_COLA2 + ", feed-forward",
        ),
    ),
    drag_quadratic=(
        Quantity(
            meaning="quadratic drag x, y, z",
            value=(163.0, 600.0, 600.0),
            unit="N s²/m²",
            tag="S",
            source=_COLA2 + ", feed-forward",
        ),
        Quantity(
            meaning="quadratic drag roll, pitch",
            value=(100.0, 100.0),
            unit="N m s²",
            tag="E",
            source="between the identified yaw and UWSim's 180",
        ),
        Quantity(
            meaning="quadratic drag yaw",
            value=(80.0,),
            unit="N m s²",
            tag="S",
            source=_COLA2 + ", feed-forward",
        ),
    ),
    weight=Quantity(
        meaning="weight in air", value=(_WEIGHT,), unit="N", tag="D", source="143.1 kg dry"
    ),
    buoyancy=Quantity(
        meaning="weight of the displaced water: floats up with 10 N",
        value=(_WEIGHT + 10.0,),
        unit="N",
        tag="D",
        source="COLA2's heave bias 0.05 of 210 N",
    ),
    centre_of_gravity=Quantity(
        meaning="centre of gravity, trimmed to the vertical axis",
        value=_CENTRE_OF_GRAVITY,
        unit="m",
        tag="D",
        source=_STONEFISH,
    ),
    centre_of_buoyancy=Quantity(
        meaning="centre of buoyancy, 0.22 m above the centre of gravity",
        value=(0.0, 0.0, _CENTRE_OF_GRAVITY[2] - 0.22),
        unit="m",
        tag="D",
        source=_STONEFISH,
    ),
    thrusters=(
        Thruster(
            name="surge port",
            position=_arm("yaw arm", (-0.3297, -0.2432, 0.0)),
            direction=(1.0, 0.0, 0.0),
        ),
        Thruster(
            name="surge starboard",
            position=_arm("yaw arm", (-0.3297, 0.2432, 0.0)),
            direction=(1.0, 0.0, 0.0),
        ),
        Thruster(
            name="heave bow",
            position=_arm("pitch arm", (0.5587, 0.0, 0.0)),
            direction=(0.0, 0.0, 1.0),
        ),
        Thruster(
            name="heave stern",
            position=_arm("pitch arm", (-0.5587, 0.0, 0.0)),
            direction=(0.0, 0.0, 1.0),
        ),
        Thruster(
            name="sway",
            position=_arm("no arm in the thruster matrix", (0.0, 0.0, 0.0)),
            direction=(0.0, 1.0, 0.0),
        ),
    ),
    curve=ThrustCurve(
        kind="polynomial",
        forward=Quantity(
            meaning="command as a polynomial of the forward thrust",
            value=(0.04997604, 0.05975017, -2.2952e-3, 4.39588388e-5, -3.9543457e-7, 1.34487e-9),
            unit="1/N^i",
            tag="S",
            source=_COLA2,
        ),
        reverse=Quantity(
            meaning="command as a polynomial of the reverse thrust",
            value=(0.0473235, 0.063145, -2.56629e-3, 5.2432528e-5, -5.0454768e-7, 1.842152e-9),
            unit="1/N^i",
            tag="S",
            source=_COLA2,
        ),
        dead_band=Quantity(
            meaning="commands up to this give no thrust",
            value=(0.05,),
            unit="1",
            tag="D",
            source="constant terms of the polynomials",
        ),
        limits=Quantity(
            meaning="greatest thrust forward, reverse",
            value=(104.659, 95.122),
            unit="N",
            tag="S",
            source=_COLA2,
        ),
    ),
    lag=Quantity(
        meaning="time constant of the thrust",
        value=(0.2,),
        unit="s",
        tag="S",
        source="UWSim dynamics_g500.yaml; the real vehicle's was not found",
    ),
    hull=(
        _hull("lower", _LOWER),
        _hull("port", _PORT),
        _hull("starboard", _STARBOARD),
    ),
    solids=(
        *_torpedo(_LOWER, DARK),
        *_torpedo(_PORT, YELLOW),
        *_torpedo(_STARBOARD, YELLOW),
        *_frame(-0.42),
        *_frame(0.32),
        Solid("box", (1.15, 0.04, 0.06), (0.0, 0.0, 0.0), METAL),
        Solid("box", (0.2, 0.03, 0.16), (-0.62, 0.0, _LOWER[2] - 0.2), YELLOW),  # tail fin
    ),
    nozzle_radius_m=0.1,
)
