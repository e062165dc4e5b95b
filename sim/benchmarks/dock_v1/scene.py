"""The dock of dock-v1: a cage of tubes that opens upwards, and what is drawn of it for a trial.

Tubes that stand beside the keel hold the vehicle and lean outwards above, so that they guide it in,
and two rails carry it. Between the rails its camera sees the marker, which stands on the seabed
with a lamp at each corner. So hovering vehicles land in the docks of Cruz et al. 2017 (MARES) and
Günzel et al. 2026 (a mini-class ROV at 90 m, by USBL and markers); the measures are estimates (E).

The axes of a dock are forward, starboard and down of a vehicle in it; their origin is in the middle
of the rails' upper side.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from seamark.sim.benchmarks.dock_v1.settings import MARKER, RAILS_M, keel_m
from seamark.sim.benchmarks.intervention.things import placed
from seamark.sim.camera.target import Target
from seamark.sim.multibody.assembly import Mounting
from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.libm import PI, sincos
from seamark.sim.vehicles import Quantity, Vehicle
from seamark.sim.vehicles.linkage import Joint, Linkage, LinkData, Touchable
from seamark.sim.vehicles.model import Place
from seamark.sim.vehicles.solids import Paint, Solid

SEABED_M = 12.0  # [m] depth, E: inshore
TUBE_M = 0.025  # E: radius
CLEARANCE_M = 0.06  # E: between keel and tubes to each side
POCKET_M = 0.25  # E: height of the upright part of the tubes
FLARE_M = 0.4  # E: how far they lean outwards above it, at 45 degrees
FRICTION = 0.3  # E: polymer on metal
MOUTH_M = POCKET_M + FLARE_M  # height of the mouth above the rails
LAMP_M = 0.05  # E: diameter
_PAINT, _LAMP, _YELLOW = Paint("#7a4a2a"), Paint("#ffffff"), Paint("#f2b61d")
_PREFIX = "dock: "


class Keel(NamedTuple):
    """The part of a hull that goes between the tubes, and how far it is from the body's origin."""

    half_length: float
    half_width: float
    ahead: float
    starboard: float


@dataclass(frozen=True, slots=True)
class _Tube:
    name: str
    start: tuple[float, float, float]
    end: tuple[float, float, float]


def keel_of(vehicle: Vehicle) -> Keel:
    """Return the part of a hull that is lower than the mouth of the dock when it is docked."""
    lowest = keel_m(vehicle)
    boxes = [
        (piece.centre.value, piece.size.value)
        for piece in vehicle.hull
        if piece.centre.value[2] + 0.5 * piece.size.value[2] > lowest - POCKET_M
    ]
    (back, front), (port, starboard) = (
        (
            min(centre[axis] - 0.5 * size[axis] for centre, size in boxes),
            max(centre[axis] + 0.5 * size[axis] for centre, size in boxes),
        )
        for axis in (0, 1)
    )
    return Keel(
        half_length=0.5 * (front - back),
        half_width=0.5 * (starboard - port),
        ahead=0.5 * (front + back),
        starboard=0.5 * (starboard + port),
    )


def target(heading_rad: float) -> Target:
    """Return the marker: its letters are upright for a vehicle in the dock."""
    return Target(
        length_m=MARKER.length_m,
        width_m=MARKER.width_m,
        height_m=MARKER.height_m,
        seabed_m=SEABED_M,
        heading_rad=heading_rad,
    )


def seat(vehicle: Vehicle) -> Array:
    """Return where the body's origin is when the vehicle is docked, (3,) [m] NED.

    The camera, below that origin, is then above the middle of the marker.
    """
    return np.array([0.0, 0.0, SEABED_M - RAILS_M - keel_m(vehicle)])


@lru_cache(maxsize=8)
def cage(keel: Keel, heading_rad: float) -> Mounting:
    """Return the dock of a vehicle with this keel on the seabed, around the marker."""
    tubes = list(_tubes(keel))
    link = LinkData(
        name="cage",
        parent=None,
        joint=Joint(kind="fixed", place=_place((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))),
        body=None,
        shapes=tuple(_touchable(tube) for tube in tubes),
    )
    looks = tuple(
        LinkData(
            name=f"look of {tube.name}",
            parent=None,
            joint=Joint(kind="fixed", place=_lying(tube)),
            body=None,
            solids=(Solid("capsule", _whole(tube), (0.0, 0.0, 0.0), _PAINT),),
        )
        for tube in tubes
    )
    linkage = Linkage(
        kind="thing",
        name="dock",
        title="Dock",
        summary="A cage of tubes that opens upwards, with rails and lamps.",
        links=(link, *looks, _marker(keel)),
        outer=tuple(tube.name for tube in tubes),
    )
    sine, cosine = sincos(heading_rad)
    middle = np.array(
        [
            cosine * keel.ahead - sine * keel.starboard,
            sine * keel.ahead + cosine * keel.starboard,
            SEABED_M - RAILS_M,
        ]
    )
    return Mounting(linkage=linkage, place=placed(middle, (0.0, 0.0, heading_rad)), prefix=_PREFIX)


def _tubes(keel: Keel) -> Iterator[_Tube]:
    """Yield the tubes, whose axes they are: uprights that lean out, the rim, legs and rails."""
    long, wide = (half + CLEARANCE_M + TUBE_M for half in (keel.half_length, keel.half_width))
    sides = (-1.0, 1.0)
    beside = [
        (along * keel.half_length, side * wide, 0.0, side)
        for side in sides
        for along in (-0.7, 0.0, 0.7)
    ]
    across = [
        (end * long, along * keel.half_width, end, 0.0) for end in sides for along in (-0.6, 0.6)
    ]
    for number, (x, y, out_x, out_y) in enumerate((*beside, *across)):
        knee = (x, y, -POCKET_M)
        top = (x + FLARE_M * out_x, y + FLARE_M * out_y, -MOUTH_M)
        yield _Tube(f"upright {number}", (x, y, 0.0), knee)
        yield _Tube(f"guide {number}", knee, top)
    a, b = long + FLARE_M, wide + FLARE_M
    corners = [(-a, -b), (a, -b), (a, b), (-a, b), (-a, -b)]
    for number, ((x, y), (u, v)) in enumerate(pairwise(corners)):
        yield _Tube(f"rim {number}", (x, y, -MOUTH_M), (u, v, -MOUTH_M))
        yield _Tube(f"leg {number}", (x, y, -MOUTH_M), (x, y, RAILS_M))
    for number, end in enumerate(sides):
        x = 0.6 * end * keel.half_length
        yield _Tube(f"rail {number}", (x, -wide, TUBE_M), (x, wide, TUBE_M))


def _marker(keel: Keel) -> LinkData:
    """Return the marker with a lamp beside each corner."""
    x, y = 0.5 * MARKER.length_m + LAMP_M, 0.5 * MARKER.width_m + LAMP_M
    down = RAILS_M - MARKER.height_m
    size = (MARKER.length_m, MARKER.width_m, MARKER.height_m)
    under = (-keel.ahead, -keel.starboard, down)
    return LinkData(
        name="marker",
        parent=None,
        joint=Joint(kind="fixed", place=_place(under, (0.0, 0.0, 0.5 * PI))),  # x as letters run
        body=None,
        solids=(
            Solid("box", size, (0.0, 0.0, 0.5 * MARKER.height_m), _YELLOW, lettered=True),
            *(
                Solid("sphere", (LAMP_M,) * 3, (a, b, 0.0), _LAMP)
                for a, b in ((-x, -y), (x, -y), (x, y), (-x, y))
            ),
        ),
    )


def _length(tube: _Tube) -> float:
    square = sum((b - a) * (b - a) for a, b in zip(tube.start, tube.end, strict=True))
    return float(np.sqrt(square))


def _lying(tube: _Tube) -> Place:
    """Return the axes in the middle of a tube whose x axis is its own: no roll, pitch, yaw."""
    middle = [0.5 * (a + b) for a, b in zip(tube.start, tube.end, strict=True)]
    dx, dy, dz = (b - a for a, b in zip(tube.start, tube.end, strict=True))
    level = float(np.sqrt(dx * dx + dy * dy))
    yaw = 0.0 if level == 0.0 else _quarter(dx, dy)
    pitch = 0.5 * PI if level == 0.0 else (0.0 if dz == 0.0 else 0.25 * PI)
    return _place(middle, (0.0, pitch, yaw))


def _quarter(dx: float, dy: float) -> float:
    """Return the direction of a vector along one of the level axes [rad]."""
    if dx != 0.0:
        return 0.0 if dx > 0.0 else PI
    return 0.5 * PI if dy > 0.0 else -0.5 * PI


def _whole(tube: _Tube) -> tuple[float, float, float]:
    """Return the whole lengths of a tube with its round ends."""
    return _length(tube) + 2.0 * TUBE_M, 2.0 * TUBE_M, 2.0 * TUBE_M


def _touchable(tube: _Tube) -> Touchable:
    return Touchable(
        name=tube.name,
        kind="capsule",
        place=_lying(tube),
        size=_estimate("radius and half length", TUBE_M, 0.5 * _length(tube)),
        friction=_estimate("friction", FRICTION),
    )


def _place(point: Sequence[float], turn: Sequence[float]) -> Place:
    return Place(point=_estimate("place", *point), turn=_estimate("turn", *turn))


def _estimate(meaning: str, *value: float) -> Quantity:
    return Quantity(meaning=meaning, value=value, unit="SI", tag="E", source="the scene")
