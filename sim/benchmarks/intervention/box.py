"""A box on the seabed that is to be recovered, and what is drawn of it for a trial.

It lies on a flat stone, which is what is tilted: so it rests there, however it is tilted.
"""

from dataclasses import asdict, dataclass, field, replace
from functools import lru_cache
from typing import Any

import numpy as np

from seamark.sim.benchmarks.intervention.things import as_rough, placed
from seamark.sim.benchmarks.intervention.tilt import Tilt, tilt_of
from seamark.sim.camera.target import Target
from seamark.sim.multibody.assembly import Frame, Mounting
from seamark.sim.multibody.workpiece import Workpiece
from seamark.sim.numerics.libm import PI
from seamark.sim.numerics.random_streams import Streams
from seamark.sim.settings.intervention import InterventionSettings
from seamark.sim.settings.targets import RECOVERED_BOX as SHAPE
from seamark.sim.vehicles.linkage import Linkage
from seamark.sim.vehicles.linkage_reading import load_linkage

BOX, STONE = "black-box", "stone"
LINK = "box"  # of the box, after its prefix
RAISED_M = 0.06  # the middle of the stone's upper face above the seabed
GRIP_M = (0.0, 0.0, -0.17)  # middle of the handle
_PREFIX, _STONE_PREFIX = "work: ", "ground: "


@dataclass(frozen=True, slots=True, kw_only=True)
class BoxDraw:
    """What a trial draws of the box."""

    heading_rad: float = 0.0  # of its letters
    mass_kg: float = 0.0  # added to its own
    friction_factor: float = 1.0
    tilt: Tilt = field(default_factory=Tilt)  # of the stone, and so of the box

    def as_dict(self) -> dict[str, Any]:
        """Return it as plain JSON values."""
        return asdict(self)


def draw_box(spread: InterventionSettings, random: Streams) -> BoxDraw:
    """Return what a trial draws; the stream must be fresh."""
    heading, mass, friction = random.trial_work.uniform(-1.0, 1.0, 3).tolist()
    angle, axis = random.trial_work.random(2).tolist()
    return BoxDraw(
        heading_rad=PI * heading,
        mass_kg=0.5 * mass,
        friction_factor=1.0 + spread.friction_spread * friction,
        tilt=tilt_of(spread.tilt_spread_rad, (angle, axis)),
    )


def target(drawn: BoxDraw) -> Target:
    """Return the camera's target without the tilt: the start is above its upper face."""
    return Target(
        length_m=SHAPE.length_m,
        width_m=SHAPE.width_m,
        height_m=RAISED_M + SHAPE.height_m,
        heading_rad=drawn.heading_rad,
    )


@lru_cache(maxsize=4)
def workpiece(drawn: BoxDraw) -> Workpiece:
    """Return the box on its stone."""
    here = target(drawn)
    things = box_on_stone(drawn, (here.north_m, here.east_m), here.seabed_m)
    return Workpiece(
        things=things,
        link=f"{_PREFIX}{LINK}",
        shapes=shapes_of(things[0]),
        grip=GRIP_M,
        face=Frame(f"{_PREFIX}{LINK}", np.array([0.0, 0.0, -0.5 * SHAPE.height_m]), np.eye(3)),
        size_m=(SHAPE.length_m, SHAPE.width_m),
    )


def box_on_stone(
    drawn: BoxDraw,
    place_m: tuple[float, float],
    seabed_m: float,
    *,
    prefix: str = "",
    text: str = "",
) -> tuple[Mounting, Mounting]:
    """Return a box and the stone that it lies on, at a place north and east on the seabed.

    `prefix` comes before the names of its links and shapes; `text` is what it is lettered with, if
    it is not the usual one.
    """
    ground = np.array([*place_m, seabed_m - RAISED_M])
    attitude = drawn.tilt.attitude(drawn.heading_rad + 0.5 * PI)
    up = drawn.tilt.matrix()[:, 2] * (0.5 * SHAPE.height_m)
    return (
        Mounting(
            linkage=_varied(load_linkage(BOX), drawn, text),
            place=placed(ground - up, attitude),
            prefix=prefix + _PREFIX,
        ),
        Mounting(
            linkage=load_linkage(STONE),
            place=placed(ground, attitude),
            prefix=prefix + _STONE_PREFIX,
        ),
    )


def shapes_of(mounting: Mounting) -> tuple[str, ...]:
    """Return the names of a thing's shapes in the mechanism."""
    return tuple(f"{mounting.prefix}{name}" for name in mounting.linkage.shapes())


def _varied(box: Linkage, drawn: BoxDraw, text: str) -> Linkage:
    (link,) = box.links
    if link.body is None:
        raise ValueError("the box has no body")
    mass = replace(link.body.mass, value=(link.body.mass.scalar + drawn.mass_kg,))
    solids = tuple(replace(solid, text=text) if solid.lettered else solid for solid in link.solids)
    varied = replace(link, body=replace(link.body, mass=mass), solids=solids)
    return replace(box, links=(as_rough(varied, drawn.friction_factor),))
