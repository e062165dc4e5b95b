"""currents-v1 with parts: at each control step they are shown an image, whatever they answer."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seamark.sim.benchmarks.currents_v1.definition import BENCHMARK as CURRENTS
from seamark.sim.benchmarks.station_keeping.experiment import StationKeeping
from seamark.sim.engine.closed_loop import ClosedLoop
from seamark.sim.engine.program import Command
from seamark.sim.engine.team import Team

NAME, PATH = "team-v1", f"{__name__}:BENCHMARK"
IMAGE = np.full((60, 80), 90, np.uint8)
CORNERS = np.array([[10.0, 10.0], [50.0, 10.0], [50.0, 30.0], [10.0, 30.0]])
QUICK = {"levels": [0.1], "level_duration_s": 2.0, "settle_s": 1.0}


class _Accompanied:
    """A controller whose steps show the other members of its team an image."""

    def __init__(self, team: Team) -> None:
        self._team = team

    def reset(self, level: Mapping[str, float | int]) -> None:
        self._team.controller.reset(level)
        if self._team.tracker is not None:
            self._team.tracker.start(IMAGE, CORNERS)

    def step(self, values: NDArray[np.float64]) -> Command:
        if self._team.detector is not None:
            self._team.detector.detect(IMAGE)
        if self._team.tracker is not None:
            self._team.tracker.update(IMAGE)
        return self._team.controller.step(values)


class TeamExperiment(StationKeeping[Any]):
    """Station keeping by a controller or a team."""

    def level(self, config: Any, solution: Any, **which: int) -> ClosedLoop:
        taking_part = _Accompanied(solution) if isinstance(solution, Team) else solution
        return super().level(config, taking_part, **which)


EXPERIMENT = TeamExperiment()
BENCHMARK = replace(
    CURRENTS, name=NAME, parts=("detector", "tracker"), experiment=f"{__name__}:EXPERIMENT"
)
