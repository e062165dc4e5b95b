"""What stands on the seabed in valve-v1, and what is drawn of it for a trial."""

from dataclasses import asdict, dataclass, field, replace
from functools import lru_cache
from typing import Any

from seamark.sim.benchmarks.intervention.things import SUNK_M, as_high, as_rough, placed
from seamark.sim.benchmarks.intervention.tilt import Tilt, tilt_of
from seamark.sim.benchmarks.valve_v1.settings import SHAPE, ValveConfiguration
from seamark.sim.camera.target import Target
from seamark.sim.multibody.assembly import Mounting
from seamark.sim.multibody.workpiece import Workpiece
from seamark.sim.numerics.libm import PI
from seamark.sim.numerics.random_streams import Streams
from seamark.sim.vehicles.linkage import Linkage
from seamark.sim.vehicles.linkage_reading import load_linkage

VALVE = "roof-valve"
LOWEST_M, HIGHEST_M = 0.4, 0.8  # of the panel above the seabed
SLIDING = (0.6, 0.9)  # torque in motion, as a share of that to break away
_PREFIX = "work: "


@dataclass(frozen=True, slots=True, kw_only=True)
class ValveDraw:
    """What a trial draws of the valve and its panel."""

    heading_rad: float = 0.0  # of the panel's letters; the handle starts along their line
    height_m: float = SHAPE.height_m  # of the panel above the seabed
    torque_n_m: float = 5.0  # to break away
    sliding_share: float = 0.8
    friction_factor: float = 1.0
    tilt: Tilt = field(default_factory=Tilt)  # of the panel about the middle of its face

    def as_dict(self) -> dict[str, Any]:
        """Return it as plain JSON values."""
        return asdict(self)


def draw_valve(spread: ValveConfiguration, random: Streams) -> ValveDraw:
    """Return what a trial draws; the stream must be fresh."""
    heading, height, torque, sliding, friction = random.trial_work.uniform(0.0, 1.0, 5).tolist()
    angle, axis = random.trial_work.random(2).tolist()
    least, most = spread.torque_least_n_m, spread.torque_most_n_m
    return ValveDraw(
        heading_rad=PI * (2.0 * heading - 1.0),
        height_m=LOWEST_M + (HIGHEST_M - LOWEST_M) * height,
        torque_n_m=least + (most - least) * torque,
        sliding_share=SLIDING[0] + (SLIDING[1] - SLIDING[0]) * sliding,
        friction_factor=1.0 + spread.friction_spread * (2.0 * friction - 1.0),
        tilt=tilt_of(spread.tilt_spread_rad, (angle, axis)),
    )


def target(drawn: ValveDraw) -> Target:
    """Return the camera's target without the tilt: the start is above its upper face."""
    return Target(
        length_m=SHAPE.length_m,
        width_m=SHAPE.width_m,
        height_m=drawn.height_m,
        heading_rad=drawn.heading_rad,
    )


@lru_cache(maxsize=4)
def workpiece(drawn: ValveDraw) -> Workpiece:
    """Return the valve on its panel."""
    panel = target(drawn)
    attitude = drawn.tilt.attitude(drawn.heading_rad + 0.5 * PI)
    place = placed(panel.top_centre(), attitude)
    linkage = _varied(load_linkage(VALVE), drawn)
    return Workpiece(
        things=(Mounting(linkage=linkage, place=place, prefix=_PREFIX),),
        link=f"{_PREFIX}handle",
        shapes=tuple(f"{_PREFIX}{name}" for name in linkage.shapes()),
        grip=(0.0, 0.0, 0.0),
        face=drawn.tilt.face_of(panel),
        size_m=(SHAPE.length_m, SHAPE.width_m),
    )


def _varied(valve: Linkage, drawn: ValveDraw) -> Linkage:
    """Return the valve with the panel's height and the handle's torque of a trial."""
    panel, handle = valve.links
    if handle.joint.friction is None:
        raise ValueError("the handle turns without friction")
    torques = drawn.torque_n_m, drawn.torque_n_m * drawn.sliding_share
    stiff = replace(handle.joint, friction=replace(handle.joint.friction, value=torques))
    links = as_high(panel, drawn.height_m + SUNK_M), replace(handle, joint=stiff)
    return replace(valve, links=tuple(as_rough(link, drawn.friction_factor) for link in links))
