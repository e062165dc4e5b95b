"""What lies on the seabed in mission-v1, and where the vehicle starts; all of it for each level.

The right box is where the targets of all benchmarks are; start, decoy and litter are drawn around
it. What a program saw in one level does not help it in the next.
"""

import math
from dataclasses import asdict, dataclass, replace
from functools import lru_cache
from typing import Any

from seamark.sim.benchmarks.intervention import box
from seamark.sim.benchmarks.intervention.box import BoxDraw
from seamark.sim.benchmarks.intervention.tilt import tilt_of
from seamark.sim.benchmarks.mission_v1.settings import MissionConfiguration
from seamark.sim.camera.bottom.field import draw_field
from seamark.sim.camera.bottom.painter import Tiles
from seamark.sim.camera.lettering import other_text
from seamark.sim.multibody.workpiece import Workpiece
from seamark.sim.numerics.libm import PI, polar
from seamark.sim.numerics.random_streams import streams
from seamark.sim.vehicles.patterns import CLASSES, DECOYS, MARKERS

LEAST_START = 0.6  # share of the largest distance of the start
LITTER = tuple(
    name for name in (*CLASSES, *DECOYS) if name not in {*MARKERS, "false-marker"}
)  # what may lie around; markers would be landmarks
_DECOY_PREFIX = "decoy "
Point = tuple[float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class SearchDraw:
    """What a level draws of the search; places are north and east of the box [m]."""

    start_m: Point  # of the camera
    heading_rad: float  # of the vehicle, from that of the box
    told_error_m: Point  # of the position that programs are told
    decoy_m: Point
    decoy: BoxDraw
    text: str  # on the decoy

    def as_dict(self) -> dict[str, Any]:
        """Return it as plain JSON values."""
        return asdict(self)


@lru_cache(maxsize=16)
def draw_search(config: MissionConfiguration, seed: int, trial: int, level: int) -> SearchDraw:
    """Return what a level draws, which depends on these values only."""
    random = streams(seed, trial, level).search
    share = random.random(11).tolist()
    most = config.start_offset_m
    start = polar(most * (LEAST_START + (1.0 - LEAST_START) * share[0]), share[1])
    near, far = config.decoy_least_m, config.decoy_most_m
    return SearchDraw(
        start_m=start,
        heading_rad=config.start_heading_rad * (2.0 * share[2] - 1.0),
        told_error_m=polar(config.told_error_m * math.sqrt(share[3]), share[4]),
        decoy_m=polar(near + (far - near) * share[5], share[6]),
        decoy=BoxDraw(
            heading_rad=PI * (2.0 * share[7] - 1.0),
            friction_factor=1.0 + config.friction_spread * (2.0 * share[8] - 1.0),
            tilt=tilt_of(config.tilt_spread_rad, (share[9], share[10])),
        ),
        text=other_text(random),
    )


@lru_cache(maxsize=4)
def workpiece(drawn: BoxDraw, search: SearchDraw) -> Workpiece:
    """Return the box on its stone, and the decoy on another."""
    alone, here = box.workpiece(drawn), box.target(drawn)
    place = here.north_m + search.decoy_m[0], here.east_m + search.decoy_m[1]
    decoy = box.box_on_stone(
        search.decoy, place, here.seabed_m, prefix=_DECOY_PREFIX, text=search.text
    )
    return replace(
        alone,
        things=(*alone.things, *decoy),
        others=(f"{decoy[0].prefix}{box.LINK}",),
        other_shapes=box.shapes_of(decoy[0]),
    )


@lru_cache(maxsize=2)
def seabed(share: float, seed: int, trial: int, level: int) -> Tiles:
    """Return the seabed of a level, of whose places this share has litter."""
    return draw_field(streams(seed, trial, level).things, LITTER, share=share)
