"""Where the vehicle of a run begins to search in a level, and what its program is told.

As the scene of the level has it; where things are meanwhile, the telemetry says.
"""

import math
from typing import TYPE_CHECKING, Any

from seamark.server.runs.showing.conditions import conditions_of
from seamark.server.runs.showing.views import RunView
from seamark.server.settings import Settings
from seamark.sim import registry
from seamark.sim.metrics.mission import MARK_M
from seamark.sim.settings.search import SearchSettings

if TYPE_CHECKING:
    from seamark.sim.camera.optics import Optics
    from seamark.sim.camera.target import Target


def search_of(
    settings: Settings,
    run: RunView,
    target: "Target",
    optics: "Optics",
    *,
    trial: int,
    level: int,
) -> dict[str, Any] | None:
    """Return the start and the position that is told, both north and east [m], and their circles.

    `error` is how far the position may be from the true one, `mark` how near to the start the box
    must be brought. None where nothing has to be found.
    """
    config: Any = registry.benchmark(run.benchmark).restore(run.config)
    if not isinstance(config, SearchSettings):
        return None
    drawn = conditions_of(settings, run, trial=trial)["work"]["searches"][level]
    # The camera is off the box by what is drawn, the vehicle's origin behind it by its mount.
    heading = target.heading_rad + drawn["heading_rad"]
    forward, starboard, _down = optics.mount_m
    sine, cosine = math.sin(heading), math.cos(heading)
    off = cosine * forward - sine * starboard, sine * forward + cosine * starboard
    north, east = target.north_m, target.east_m
    (start_north, start_east), (told_north, told_east) = drawn["start_m"], drawn["told_error_m"]
    return {
        "start": [north + start_north - off[0], east + start_east - off[1]],
        "told": [north + told_north, east + told_east],
        "error": config.told_error_m,
        "mark": MARK_M,
    }
