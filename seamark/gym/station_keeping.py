"""Station keeping as a Gymnasium environment."""

from seamark.gym.episodes import Episode
from seamark.gym.vehicle import VehicleEnv
from seamark.sim.engine.reward import goal, reward_of


class StationKeepingEnv(VehicleEnv):
    """A vehicle that keeps its place: a step earns by the state in which it ends.

    See `sim/engine/reward.py` and `VehicleEnv`.
    """

    def _begin(self, episode: Episode) -> None:
        super()._begin(episode)
        world = self._world
        mount = world.camera.optics.mount_m
        self._goal = goal(world.plant.vehicle, world.station, mount, world.tool_m)

    def _reward(self) -> float:
        return float(reward_of(self._row, self._goal))
