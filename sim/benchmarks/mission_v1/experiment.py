"""The mission: how a level starts, and how far it got."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from seamark.sim.benchmarks.intervention import box
from seamark.sim.benchmarks.intervention.experiment import Intervention
from seamark.sim.benchmarks.mission_v1 import scene
from seamark.sim.benchmarks.mission_v1.settings import MissionConfiguration
from seamark.sim.camera.bottom.painter import Tiles
from seamark.sim.camera.target import Target
from seamark.sim.engine.world import Conditions
from seamark.sim.metrics import mission
from seamark.sim.multibody.workpiece import Workpiece
from seamark.sim.numerics.random_streams import Streams, streams
from seamark.sim.recording.telemetry import Rows


class Mission(Intervention[MissionConfiguration]):
    """The right box is to be found, recovered and brought to where the vehicle started."""

    task = "mission"
    not_tried = "The box was not found in either of the two levels with the weakest current."

    def attempt(self, config: MissionConfiguration, rows: Rows) -> mission.Mission:
        """Return the rows of a level for its metrics."""
        return mission.Mission(rows, config.control_period_s)

    def drawn_work(
        self, config: MissionConfiguration, *, seed: int, trial: int
    ) -> Mapping[str, Any]:
        """Return what is drawn of the box, and of the search in each level, as JSON values."""
        levels = range(len(config.level_values()))
        searches = [scene.draw_search(config, seed, trial, level).as_dict() for level in levels]
        return self._box(config, seed, trial).as_dict() | {"searches": searches}

    def target(self, config: MissionConfiguration, *, seed: int, trial: int) -> Target:
        """Return where the box is at the start."""
        return box.target(self._box(config, seed, trial))

    def workpiece(
        self, config: MissionConfiguration, *, seed: int, trial: int, level: int
    ) -> Workpiece:
        """Return the box and the decoy."""
        search = scene.draw_search(config, seed, trial, level)
        return scene.workpiece(self._box(config, seed, trial), search)

    def bottom(self, config: MissionConfiguration, *, seed: int, trial: int, level: int) -> Tiles:
        """Return the seabed with its litter."""
        return scene.seabed(config.litter, seed, trial, level)

    def _conditions(
        self, config: MissionConfiguration, *, seed: int, trial: int, level: int
    ) -> tuple[Conditions, Streams]:
        conditions, random = super()._conditions(config, seed=seed, trial=trial, level=level)
        search = scene.draw_search(config, seed, trial, level)
        start = replace(
            conditions.trial,
            start_offset_m=search.start_m,
            start_heading_rad=search.heading_rad,
        )
        return replace(conditions, trial=start, told_error_m=search.told_error_m), random

    def _box(self, config: MissionConfiguration, seed: int, trial: int) -> box.BoxDraw:
        return box.draw_box(config, streams(seed, trial, 0))


EXPERIMENT = Mission(mission.METRICS)
