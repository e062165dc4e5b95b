"""BlueROV2 Heavy: small, eight thrusters, actuated on all six axes.

Masses and drag were identified in a towing tank, unlike those of the other vehicles; the thruster
positions are those of the simulation model that ArduSub is tested with. The origin is the centre
of gravity.
"""

from collections.abc import Iterator

from seamark.sim.vehicles import HullBox, Quantity, Tag, ThrustCurve, Thruster, Vehicle
from seamark.sim.vehicles.solids import BLUE, DARK, FOAM, GLASS, WHITE, Solid

_TANK = "von Benzon et al. 2022, J. Mar. Sci. Eng. 10(12) 1898"
_POSITIONS = "clydemcqueen/bluerov2_gz bb03343, models/bluerov2_heavy/model.sdf"
_MAKER = "Blue Robotics, T200 at 16 V: 5.25 kgf forward, 4.10 kgf reverse"
_GRAVITY = 9.82  # [m/s²] as in the source
_DIAGONAL = 0.7071067811865476
_FORWARD, _REVERSE = 51.5, 40.2
_LENGTH, _WIDTH, _HEIGHT = _FRAME_SIZE = (0.4571, 0.575, 0.2539)  # [m]


def _quantity(
    meaning: str, value: tuple[float, ...], unit: str, source: str = _TANK, tag: Tag = "S"
) -> Quantity:
    return Quantity(meaning=meaning, value=value, unit=unit, tag=tag, source=source)


def _flat(name: str, x: float, y: float, sideways: float) -> Thruster:
    """A horizontal thruster at 45 degrees; `sideways` is +1 if it pushes to starboard too."""
    position = _quantity("position of the thruster", (x, y, 0.0), "m", _POSITIONS)
    return Thruster(name=name, position=position, direction=(_DIAGONAL, sideways * _DIAGONAL, 0.0))


def _upright(name: str, x: float, y: float) -> Thruster:
    position = _quantity("position of the thruster", (x, y, -0.064), "m", _POSITIONS)
    return Thruster(name=name, position=position, direction=(0.0, 0.0, 1.0))


def _side(y: float) -> Iterator[Solid]:
    """Yield the parts at one side: -1 port, 1 starboard."""
    side = 0.17 * y
    yield Solid("box", (_LENGTH, 0.012, 0.42 * _HEIGHT), (0.0, side, 0.28 * _HEIGHT), BLUE)
    for x in (0.42 * _LENGTH, -0.42 * _LENGTH):
        yield Solid("box", (0.05, 0.012, 0.6 * _HEIGHT), (x, side, 0.0), BLUE)
    yield Solid("box", (0.82 * _LENGTH, 0.1, 0.07), (0.0, 0.12 * y, -0.4 * _HEIGHT), FOAM)
    outrigger = 0.36 * _WIDTH * y  # of the heave thrusters
    yield Solid("box", (0.5 * _LENGTH, 0.03, 0.03), (0.0, outrigger, -0.03), DARK)
    for x in (-0.118, 0.118):
        yield Solid("box", (0.03, 0.1, 0.03), (x, 0.2 * y, -0.03), DARK)


VEHICLE = Vehicle(
    name="bluerov2-heavy",
    title="BlueROV2 Heavy",
    summary="Small and fully actuated: eight thrusters, as strong sideways as ahead.",
    mass=_quantity("mass", (13.5,), "kg"),
    inertia=_quantity("inertia about the centre of gravity", (0.26, 0.23, 0.37), "kg m²"),
    inertia_point="gravity",
    added_mass=(
        _quantity("added mass", (6.3567, 7.1206, 18.6863), "kg"),
        _quantity("added inertia", (0.1858, 0.1348, 0.2215), "kg m²"),
    ),
    drag_linear=(
        _quantity("linear drag x, y, z", (13.7, 0.0, 33.0), "N s/m"),
        _quantity("linear drag roll, pitch, yaw", (0.0, 0.8, 0.0), "N m s"),
    ),
    drag_quadratic=(
        _quantity("quadratic drag x, y, z", (141.0, 217.0, 190.0), "N s²/m²"),
        _quantity("quadratic drag roll, pitch, yaw", (1.192, 0.470, 1.500), "N m s²"),
    ),
    weight=_quantity("weight in air", (13.5 * _GRAVITY,), "N"),
    buoyancy=_quantity(
        "weight of the displaced fresh water, 13.4 l", (13.4 * _GRAVITY,), "N", tag="D"
    ),
    centre_of_gravity=_quantity("centre of gravity", (0.0, 0.0, 0.0), "m"),
    centre_of_buoyancy=_quantity("centre of buoyancy", (0.0, 0.0, -0.01), "m"),
    thrusters=(
        _flat("front starboard", 0.14, 0.092, -1.0),
        _flat("front port", 0.14, -0.092, 1.0),
        _flat("rear starboard", -0.15, 0.092, 1.0),
        _flat("rear port", -0.15, -0.092, -1.0),
        _upright("heave front starboard", 0.118, 0.215),
        _upright("heave front port", 0.118, -0.215),
        _upright("heave rear starboard", -0.118, 0.215),
        _upright("heave rear port", -0.118, -0.215),
    ),
    curve=ThrustCurve(
        kind="quadratic",
        forward=_quantity("thrust at full command", (_FORWARD,), "N", _MAKER, "D"),
        reverse=_quantity("thrust at full reverse command", (_REVERSE,), "N", _MAKER, "D"),
        dead_band=_quantity(
            "commands up to this give no thrust", (0.0625,), "1", "25 of 400 µs of pulse", "E"
        ),
        limits=_quantity(
            "greatest thrust forward, reverse", (_FORWARD, _REVERSE), "N", _MAKER, "D"
        ),
    ),
    lag=_quantity("time constant of the thrust", (0.1,), "s", "half of the Girona 500's", "E"),
    hull=(
        HullBox(
            name="frame",
            centre=_quantity("centre of the frame", (0.0, 0.0, 0.0), "m", _MAKER, "E"),
            size=_quantity("box around the frame", _FRAME_SIZE, "m", "Blue Robotics, drawing"),
        ),
    ),
    solids=(
        *_side(-1.0),
        *_side(1.0),
        Solid("cylinder", (0.62 * _LENGTH, 0.114, 0.114), (0.0, 0.0, -0.02), GLASS),
        Solid("sphere", (0.114, 0.114, 0.114), (0.31 * _LENGTH, 0.0, -0.02), WHITE),
        Solid("cylinder", (0.5 * _LENGTH, 0.088, 0.088), (0.0, 0.0, 0.08), DARK),
        Solid("box", (0.8 * _LENGTH, 0.34, 0.012), (0.0, 0.0, 0.47 * _HEIGHT), BLUE),
    ),
    defaults={
        # From 0.33 m/s on the Munk moment (Z_w - X_u) u² exceeds the righting moment of 1.3 N m.
        "tilt_hold": True,
    },
)
