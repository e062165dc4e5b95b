"""Following a route as a Gymnasium environment: a step earns what of the route it has followed."""

from typing import Any

from seamark.gym.episodes import Episode
from seamark.gym.vehicle import VehicleEnv
from seamark.sim.metrics.following import share_followed
from seamark.sim.recording.telemetry import ROUTE_INDEX

_TRUE_ROUTE: dict[str, Any] = {  # name in `info` -> columns of the telemetry
    "route_point": slice(ROUTE_INDEX["route_x"], ROUTE_INDEX["route_z"] + 1),
    "along": ROUTE_INDEX["route_along"],
    "cross_track": ROUTE_INDEX["cross_track"],
}


class FollowingEnv(VehicleEnv):
    """A vehicle that follows a route: see `VehicleEnv` and the docs.

    The sum of what the steps of a level earn is the share of the route that was followed, the
    metric `followed` before the power counts.
    """

    def _begin(self, episode: Episode) -> None:
        super()._begin(episode)
        self._along_m = self._gained = 0.0

    def _sense(self) -> None:
        super()._sense()
        before, self._along_m = self._along_m, float(self._row[ROUTE_INDEX["route_along"]])
        self._gained = float(share_followed(self._row[None], before)[0])

    def _reward(self) -> float:
        return self._gained

    def _truth(self) -> dict[str, Any]:
        route = {name: self._row[columns] + 0.0 for name, columns in _TRUE_ROUTE.items()}
        return super()._truth() | route
