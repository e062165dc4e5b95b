"""What stands on the seabed in connect-v1, and what is drawn of it for a trial."""

from dataclasses import asdict, dataclass, field, replace
from functools import lru_cache
from typing import Any

from seamark.sim.benchmarks.connect_v1.settings import SHAPE, ConnectConfiguration
from seamark.sim.benchmarks.intervention.things import SUNK_M, as_high, as_rough, placed
from seamark.sim.benchmarks.intervention.tilt import Tilt, tilt_of
from seamark.sim.camera.target import Target
from seamark.sim.metrics.connection import TIP_M
from seamark.sim.multibody.assembly import Mounting
from seamark.sim.multibody.workpiece import Workpiece
from seamark.sim.numerics.libm import PI, sincos
from seamark.sim.numerics.random_streams import Streams
from seamark.sim.vehicles.linkage import Linkage, LinkData
from seamark.sim.vehicles.linkage_reading import load_linkage
from seamark.sim.vehicles.matrices import applied

RECEPTACLE, CONNECTOR = "roof-receptacle", "connector"
LOWEST_M, HIGHEST_M = 0.4, 0.8  # of the panel above the seabed
LIGHTEST_KG, HEAVIEST_KG = 0.8, 1.6
PARKED_M, RAIL_M = 0.2, 0.03  # along the letters from the receptacle, and to either side of that
ASKEW_RAD = 0.15  # of the handle to either side, about the vertical
PEG_M = 0.02  # radius
_PREFIX = "work: "


@dataclass(frozen=True, slots=True, kw_only=True)
class ConnectorDraw:
    """What a trial draws of connector, receptacle and panel."""

    heading_rad: float = 0.0  # of the panel's letters
    height_m: float = SHAPE.height_m  # of the panel above the seabed
    parked_m: float = PARKED_M  # along the letters from the receptacle
    askew_rad: float = 0.0  # of the handle, from across the letters
    mass_kg: float = 1.2
    clearance_m: float = 0.005  # of the diameters
    friction_factor: float = 1.0
    tilt: Tilt = field(default_factory=Tilt)  # of the panel about the mouth of its hole

    def as_dict(self) -> dict[str, Any]:
        """Return it as plain JSON values."""
        return asdict(self)


def draw_connector(spread: ConnectConfiguration, random: Streams) -> ConnectorDraw:
    """Return what a trial draws; the stream must be fresh."""
    heading, height, parked, askew, mass, clearance, friction = random.trial_work.uniform(
        0.0, 1.0, 7
    ).tolist()
    angle, axis = random.trial_work.random(2).tolist()
    least, most = spread.clearance_least_m, spread.clearance_most_m
    return ConnectorDraw(
        heading_rad=PI * (2.0 * heading - 1.0),
        height_m=LOWEST_M + (HIGHEST_M - LOWEST_M) * height,
        parked_m=PARKED_M + RAIL_M * (2.0 * parked - 1.0),
        askew_rad=ASKEW_RAD * (2.0 * askew - 1.0),
        mass_kg=LIGHTEST_KG + (HEAVIEST_KG - LIGHTEST_KG) * mass,
        clearance_m=least + (most - least) * clearance,
        friction_factor=1.0 + spread.friction_spread * (2.0 * friction - 1.0),
        tilt=tilt_of(spread.tilt_spread_rad, (angle, axis)),
    )


def target(drawn: ConnectorDraw) -> Target:
    """Return the camera's target without the tilt: the start is above its upper face."""
    return Target(
        length_m=SHAPE.length_m,
        width_m=SHAPE.width_m,
        height_m=drawn.height_m,
        heading_rad=drawn.heading_rad,
    )


@lru_cache(maxsize=4)
def workpiece(drawn: ConnectorDraw) -> Workpiece:
    """Return the connector in its parking place beside the receptacle."""
    panel = target(drawn)
    top, yaw = panel.top_centre(), drawn.heading_rad + 0.5 * PI
    sine, cosine = sincos(yaw)
    beside = (drawn.parked_m * cosine, drawn.parked_m * sine, -TIP_M)
    parked = top + applied(drawn.tilt.matrix(), beside)
    connector = _weighed(load_linkage(CONNECTOR), drawn)
    things = (
        (_varied(load_linkage(RECEPTACLE), drawn), placed(top, drawn.tilt.attitude(yaw))),
        (connector, placed(parked, drawn.tilt.attitude(yaw + drawn.askew_rad))),
    )
    return Workpiece(
        things=tuple(
            Mounting(linkage=linkage, place=place, prefix=_PREFIX) for linkage, place in things
        ),
        link=f"{_PREFIX}connector",
        shapes=tuple(f"{_PREFIX}{name}" for name in connector.shapes()),
        grip=(0.0, 0.0, 0.0),
        face=drawn.tilt.face_of(panel),
        size_m=(SHAPE.length_m, SHAPE.width_m),
    )


def _weighed(connector: Linkage, drawn: ConnectorDraw) -> Linkage:
    """Return the connector with the mass and the friction of a trial."""
    peg, *others = connector.links
    if peg.body is None:
        raise ValueError("the connector has no body")
    mass = replace(peg.body.mass, value=(drawn.mass_kg,))
    links = (replace(peg, body=replace(peg.body, mass=mass)), *others)
    return replace(connector, links=tuple(as_rough(link, drawn.friction_factor) for link in links))


def _varied(receptacle: Linkage, drawn: ConnectorDraw) -> Linkage:
    """Return the panel as high as a trial drew it, its hole as wide, its parking as far."""
    panel, hole, parking = receptacle.links
    sunk = SUNK_M if drawn.tilt.angle_rad > 0.0 else 0.0  # under a level one there is no gap
    links = (
        as_high(panel, drawn.height_m + sunk),
        _as_wide(hole, drawn),
        _as_far(parking, drawn.parked_m),
    )
    return replace(receptacle, links=tuple(as_rough(link, drawn.friction_factor) for link in links))


def _as_wide(receptacle: LinkData, drawn: ConnectorDraw) -> LinkData:
    (hole,) = receptacle.shapes
    _, deep, funnel = hole.size.value
    size = replace(hole.size, value=(PEG_M + 0.5 * drawn.clearance_m, deep, funnel))
    return replace(receptacle, shapes=(replace(hole, size=size),))


def _as_far(parking: LinkData, parked_m: float) -> LinkData:
    place = parking.joint.place
    there = replace(place, point=replace(place.point, value=(parked_m, 0.0, 0.0)))
    return replace(parking, joint=replace(parking.joint, place=there))
