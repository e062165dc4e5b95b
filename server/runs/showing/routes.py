"""The route that the vehicle of a run follows in a level, and how wrong its told start is.

As the plan of the trial has it; where the vehicle is meanwhile, the telemetry says.
"""

from typing import Any

from seamark.server.runs.showing.conditions import conditions_of
from seamark.server.runs.showing.views import RunView
from seamark.server.settings import Settings
from seamark.sim import registry
from seamark.sim.settings.route import RouteSettings


def route_of(settings: Settings, run: RunView, *, trial: int, level: int) -> dict[str, Any] | None:
    """Return the points of the route and the boat's transceiver, north, east, down [m].

    `told_error` is how far north and east of where the vehicle starts it is said to start [m], and
    `error` how far that may be. `pipe` is there if the route is along one: its axis, north and
    east, its radius, and from and to which lengths of the axis it is covered [m]. None where no
    route is followed.
    """
    config: Any = registry.benchmark(run.benchmark).restore(run.config)
    if not isinstance(config, RouteSettings):
        return None
    drawn = conditions_of(settings, run, trial=trial)
    route = {
        "points": drawn["routes"][level],
        "boat": drawn["boats"][level],
        "told_error": drawn["start_errors"][level],
        "error": config.start_error_m,
    }
    pipes = drawn.get("pipes")
    return route | ({"pipe": pipes[level]} if pipes else {})
