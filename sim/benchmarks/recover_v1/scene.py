"""What lies on the seabed in recover-v1, and what is drawn of it for a trial."""

from dataclasses import asdict, dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from seamark.sim.benchmarks.recover_v1.settings import SHAPE, RecoverConfiguration
from seamark.sim.camera.target import Target
from seamark.sim.multibody.assembly import Frame, Mounting
from seamark.sim.multibody.workpiece import Workpiece
from seamark.sim.numerics.libm import PI
from seamark.sim.numerics.random_streams import Streams
from seamark.sim.vehicles import Quantity
from seamark.sim.vehicles.linkage import Linkage
from seamark.sim.vehicles.linkage_reading import load_linkage
from seamark.sim.vehicles.model import Place

BOX = "black-box"
GRIP_M = (0.0, 0.0, -0.17)  # middle of the handle
_PREFIX = "work: "


@dataclass(frozen=True, slots=True, kw_only=True)
class BoxDraw:
    """What a trial draws of the box."""

    heading_rad: float = 0.0  # of its letters
    mass_kg: float = 0.0  # added to its own
    friction_factor: float = 1.0

    def as_dict(self) -> dict[str, Any]:
        """Return it as plain JSON values."""
        return asdict(self)


def draw_box(spread: RecoverConfiguration, random: Streams) -> BoxDraw:
    """Return what a trial draws; the stream must be fresh."""
    heading, mass, friction = random.trial_work.uniform(-1.0, 1.0, 3).tolist()
    return BoxDraw(
        heading_rad=PI * heading,
        mass_kg=0.5 * mass,
        friction_factor=1.0 + spread.friction_spread * friction,
    )


def target(drawn: BoxDraw) -> Target:
    """Return the box as the camera's target: where it lies at the start."""
    return Target(
        length_m=SHAPE.length_m,
        width_m=SHAPE.width_m,
        height_m=SHAPE.height_m,
        heading_rad=drawn.heading_rad,
    )


@lru_cache(maxsize=4)
def workpiece(drawn: BoxDraw) -> Workpiece:
    """Return the box on the seabed."""
    box = target(drawn)
    north, east, down = box.origin().tolist()
    place = Place(
        point=_estimate("place", north, east, down),
        turn=_estimate("turn", 0.0, 0.0, drawn.heading_rad + 0.5 * PI),
    )
    linkage = _varied(load_linkage(BOX), drawn)
    return Workpiece(
        things=(Mounting(linkage=linkage, place=place, prefix=_PREFIX),),
        link=f"{_PREFIX}box",
        shapes=tuple(f"{_PREFIX}{name}" for name in linkage.shapes()),
        grip=GRIP_M,
        face=Frame(f"{_PREFIX}box", np.array([0.0, 0.0, -0.5 * SHAPE.height_m]), np.eye(3)),
        size_m=(SHAPE.length_m, SHAPE.width_m),
    )


def _varied(box: Linkage, drawn: BoxDraw) -> Linkage:
    (link,) = box.links
    if link.body is None:
        raise ValueError("the box has no body")
    mass = replace(link.body.mass, value=(link.body.mass.scalar + drawn.mass_kg,))
    shapes = tuple(
        replace(
            shape,
            friction=replace(
                shape.friction, value=(shape.friction.scalar * drawn.friction_factor,)
            ),
        )
        for shape in link.shapes
    )
    varied = replace(link, body=replace(link.body, mass=mass), shapes=shapes)
    return replace(box, links=(varied,))


def _estimate(meaning: str, *value: float) -> Quantity:
    return Quantity(meaning=meaning, value=value, unit="SI", tag="E", source="the scene")
