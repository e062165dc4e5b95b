"""Things in the world of an intervention, as a trial draws them."""

from dataclasses import replace

from seamark.sim.benchmarks.intervention.tilt import Attitude
from seamark.sim.numerics.arrays import Array
from seamark.sim.vehicles import Quantity
from seamark.sim.vehicles.linkage import LinkData, Touchable
from seamark.sim.vehicles.model import Place

SUNK_M = 0.1  # of a panel below the seabed, so that it has no gap there when it is tilted


def placed(point: Array, attitude: Attitude) -> Place:
    """Return where a thing is: its origin, (3,) [m] NED, and its roll, pitch and yaw [rad]."""
    return Place(point=_estimate("place", *point.tolist()), turn=_estimate("turn", *attitude))


def _estimate(meaning: str, *value: float) -> Quantity:
    return Quantity(meaning=meaning, value=value, unit="SI", tag="E", source="the scene")


def as_high(panel: LinkData, height_m: float) -> LinkData:
    """Return a panel, whose origin is on its face, with this height below its face [m]."""
    (shape,), (solid,) = panel.shapes, panel.solids
    long, wide, _ = shape.size.value
    middle = (0.0, 0.0, 0.5 * height_m)
    place = replace(shape.place, point=replace(shape.place.point, value=middle))
    size = replace(shape.size, value=(long, wide, 0.5 * height_m))
    block = replace(solid, centre=middle, size=(solid.size[0], solid.size[1], height_m))
    return replace(panel, shapes=(replace(shape, place=place, size=size),), solids=(block,))


def as_rough(link: LinkData, factor: float) -> LinkData:
    """Return a link whose shapes have this many times their friction."""

    def rough(shape: Touchable) -> Touchable:
        friction = replace(shape.friction, value=(shape.friction.scalar * factor,))
        return replace(shape, friction=friction)

    return replace(link, shapes=tuple(map(rough, link.shapes)))
