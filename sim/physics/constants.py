"""Physical constants that are neither vehicle parameters nor settings, each with its source.

The simulator takes its constants from here, and the documentation shows the same table. This module
needs no compiled code.
"""

from collections.abc import Mapping

from seamark.sim.vehicles import STANDARD_GRAVITY as _GRAVITY
from seamark.sim.vehicles import Quantity, Tag

_STONEFISH = "Stonefish b21eb8e1, Tests/Data/girona500auv_full.scn"
_COLA2 = "COLA2 sim_auv_nav_sensors.yaml"
_SCENE = "uwsimbenchmarks 988deda, dynamicsTrackingScene.xml"


def _number(meaning: str, value: float, unit: str, tag: Tag, source: str) -> Quantity:
    return Quantity(meaning=meaning, value=(value,), unit=unit, tag=tag, source=source)


STANDARD_GRAVITY = _number("acceleration of gravity", _GRAVITY, "m/s²", "S", "BIPM")
WATER_DENSITY = _number("density of the water", 1000.0, "kg/m³", "S", "fresh water, as in the pool")
STEP_S = _number(
    "physics step by default", 0.01, "s", "D", "within 1e-6 mm of the limit after 600 s"
)

FORCE_PER_SPEED_SQUARED = _number(
    "body force of the published current over speed², before the share k",
    500.0 * 0.82,
    "N s²/m²",
    "S",
    "uwsimbenchmarks 988deda, BenchmarkROSInterfaces.cpp: half the density times CdA 0.82 m²",
)
GUST_GRID_S = _number(
    "grid of gusts, linearly interpolated",
    0.05,
    "s",
    "E",
    "far below the correlation time of a gust",
)
TABLE_GRID_S = _number(
    "grid of a table of currents, linearly interpolated",
    0.1,
    "s",
    "D",
    "water that moves at 0.5 m/s brings an eddy of a tenth of a metre past in two intervals",
)
CURRENT_CHANGE_S = _number(
    "time over which a lasting change of the current builds up",
    2.0,
    "s",
    "E",
    "short for a controller, long for the physics step",
)
MIN_HEIGHT_M = _number(
    "height below which a sheared current is constant",
    0.1,
    "m",
    "E",
    "the law is singular at the bottom",
)

DVL_RANGE_M = Quantity(
    meaning="range of the DVL", value=(0.5, 81.0), unit="m", tag="S", source=_STONEFISH
)
DVL_BEAM_RAD = _number(
    "angle of each of the four beams with the body's z axis", 0.5235987755982988, "rad", "S",
    _STONEFISH,
)  # fmt: skip
DVL_MOST_TILT_RAD = _number(
    "roll or pitch beyond which the DVL loses bottom lock", 0.5, "rad", "E",
    "one of four beams misses the bottom long before",
)  # fmt: skip
DVL_LEAST_BEAMS = _number(
    "fewest echoes for bottom lock", 3.0, "1", "D", "three velocity components"
)
DEPTH_PERIOD_S = _number("time between two depths or altitudes", 0.2, "s", "S", _COLA2)
AHRS_PERIOD_S = _number("time between two attitudes", 0.05, "s", "S", _COLA2)
AHRS_RATE_SIGMA = _number("noise of the angular rates", 1.7e-5, "rad/s", "S", _STONEFISH)
ALTIMETER_SIGMA_M = _number("noise of the altitude", 0.001, "m", "S", _STONEFISH)

TARGET_SIZE_M = Quantity(
    meaning="length and width of the box",
    value=(0.42, 0.13),
    unit="m",
    tag="S",
    source="benchmark_software_launcher ea65b39, visualStationKeeping.cpp",
)
TARGET_HEIGHT_M = _number("height of the box", 0.13, "m", "E", "as high as wide")
TARGET_MASS_KG = _number("mass of a movable box", 15.0, "kg", "S", "UWSim cirs.xml")
FRICTION = _number("friction of hull, box and bottom", 0.5, "1", "E", "chosen")
GATE_M = _number(
    "clearance of the hull's sphere below which contacts are computed", 0.5, "m", "E",
    "farther than anything moves in one step",
)  # fmt: skip

MOUND_LENGTHS_M = Quantity(
    meaning="shortest and longest wave of the mounds",
    value=(4.0, 10.0),
    unit="m",
    tag="E",
    source="longer than the vehicle",
)
MOUND_RISE_M = _number(
    "distance from the flat patch to mounds of full height",
    2.0,
    "m",
    "E",
    "no steeper than the waves",
)
MOUND_REACH_M = _number("radius of the mounds", 20.0, "m", "E", "the pool is 24 m long")

GROUPS: Mapping[str, tuple[Quantity, ...]] = {
    "Water and time": (STANDARD_GRAVITY, WATER_DENSITY, STEP_S),
    "Current": (
        FORCE_PER_SPEED_SQUARED,
        GUST_GRID_S,
        TABLE_GRID_S,
        CURRENT_CHANGE_S,
        MIN_HEIGHT_M,
    ),
    "Sensors": (
        DVL_RANGE_M,
        DVL_BEAM_RAD,
        DVL_MOST_TILT_RAD,
        DVL_LEAST_BEAMS,
        DEPTH_PERIOD_S,
        AHRS_PERIOD_S,
        AHRS_RATE_SIGMA,
        ALTIMETER_SIGMA_M,
    ),
    "Contacts and target": (
        TARGET_SIZE_M,
        TARGET_HEIGHT_M,
        TARGET_MASS_KG,
        FRICTION,
        GATE_M,
    ),
    "Mounds on the bottom": (MOUND_LENGTHS_M, MOUND_RISE_M, MOUND_REACH_M),
}
