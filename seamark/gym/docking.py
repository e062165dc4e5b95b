"""Entering a dock as a Gymnasium environment: a step earns what of the level's credit it gains."""

from typing import Any

import numpy as np

from seamark.gym.episodes import Episode
from seamark.gym.vehicle import VehicleEnv
from seamark.sim.benchmarks.dock_v1.experiment import strike_n
from seamark.sim.metrics.docking import Docking
from seamark.sim.recording.telemetry import DOCK_INDEX

_TRUE_DOCK: dict[str, Any] = {  # name in `info` -> columns of the telemetry
    "off_seat": slice(DOCK_INDEX["dock_ahead"], DOCK_INDEX["dock_below"] + 1),
    "dock_turn": DOCK_INDEX["dock_turn"],
    "dock_depth": DOCK_INDEX["dock_depth"],
}


class DockingEnv(VehicleEnv):
    """A vehicle that enters a dock: see `VehicleEnv` and the docs.

    The sum of what the steps of a level earn is its quality, the metric `docking`; a strike earns
    what it costs.
    """

    def _begin(self, episode: Episode) -> None:
        super()._begin(episode)
        self._rows = np.empty((self._steps, self._running.width()))
        self._strike_n = strike_n(self._config.for_trial(episode.trial))
        self._credit = self._gained = 0.0
        self._stages = 0

    def _sense(self) -> None:
        super()._sense()
        self._gained = 0.0
        if self._step < self._steps:  # a run ends before it has a row of the last state
            self._rows[self._step] = self._row
            rows = self._rows[: self._step + 1]
            docking = Docking(
                rows, self._config.control_period_s, self._strike_n, whole=self._steps
            )
            before, self._credit = self._credit, docking.quality
            self._gained, self._stages = self._credit - before, len(docking.reached)

    def _reward(self) -> float:
        return self._gained

    def _truth(self) -> dict[str, Any]:
        dock = {name: self._row[columns] + 0.0 for name, columns in _TRUE_DOCK.items()}
        return super()._truth() | dock | {"credit": self._credit, "stages": self._stages}
