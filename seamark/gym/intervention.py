"""Interventions as Gymnasium environments: what a step earns is credit, and the way to the work."""

from typing import Any

import numpy as np

from seamark.gym.episodes import Episode
from seamark.gym.vehicle import VehicleEnv
from seamark.sim.benchmarks.intervention.experiment import Intervention
from seamark.sim.metrics.stages import Progress
from seamark.sim.recording.telemetry import WORK_INDEX

SPARSE, DENSE = "sparse", "dense"
REWARDS = (SPARSE, DENSE)
APPROACH_1_M = 0.1  # earned for each metre by which the tool comes closer to the grip
_REACH = WORK_INDEX["reach"]
_TRUE_WORK: dict[str, Any] = {  # name in `info` -> columns of the telemetry
    "workpiece": slice(WORK_INDEX["workpiece_x"], WORK_INDEX["workpiece_yaw"] + 1),
    "workpiece_joint": WORK_INDEX["workpiece_joint"],
    "tool": slice(WORK_INDEX["tool_x"], WORK_INDEX["tool_yaw"] + 1),
    "reach": _REACH,
}
_NOTHING = Progress((), 0.0)


class InterventionEnv(VehicleEnv):
    """A vehicle whose arm works on something: see `VehicleEnv` and the docs."""

    def __init__(self, *, reward: str = DENSE, **options: Any) -> None:
        """Set up the environment.

        Parameters
        ----------
        reward
            "sparse": the credit that is gained by the state in which a step ends, so the sum over a
            level is its credit. "dense": that, and `APPROACH_1_M` for each metre by which the tool
            has come closer to the grip.
        options
            As of `VehicleEnv`.

        Raises
        ------
        ConfigurationInvalid, VehicleInvalid, ValueError
            As of `VehicleEnv`; there is no such reward.
        """
        if reward not in REWARDS:
            raise ValueError(f"reward must be one of {', '.join(REWARDS)}, not {reward!r}")
        super().__init__(**options)
        self._dense = reward == DENSE
        self._intervention: Intervention[Any] = self._experiment  # type: ignore[assignment]

    def _begin(self, episode: Episode) -> None:
        super()._begin(episode)
        self._rows = np.empty((self._steps, self._running.width()))
        self._progress, self._reach_m = _NOTHING, 0.0

    def _sense(self) -> None:
        super()._sense()
        if self._step < self._steps:  # a run ends before it has a row of the last state
            self._rows[self._step] = self._row
            rows = self._rows[: self._step + 1]
            self._gained = -self._progress.credit
            self._progress = self._intervention.attempt(self._config, rows).progress
            self._gained += self._progress.credit
        else:
            self._gained = 0.0
        reach = float(self._row[_REACH])
        self._closer_m, self._reach_m = self._reach_m - reach, reach

    def _reward(self) -> float:
        return self._gained + (APPROACH_1_M * self._closer_m if self._dense else 0.0)

    def _truth(self) -> dict[str, Any]:
        work = {name: self._row[columns] + 0.0 for name, columns in _TRUE_WORK.items()}
        progress = {"credit": self._progress.credit, "stages": len(self._progress.steps)}
        return super()._truth() | work | progress
