"""valve-v1: the valve on its panel, drawn for each trial, and how far it was turned."""

from collections.abc import Mapping
from typing import Any

from seamark.sim.benchmarks.intervention.experiment import Intervention
from seamark.sim.benchmarks.valve_v1 import scene
from seamark.sim.benchmarks.valve_v1.settings import ValveConfiguration
from seamark.sim.camera.target import Target
from seamark.sim.metrics import valve_turning
from seamark.sim.multibody.workpiece import Workpiece
from seamark.sim.numerics.random_streams import streams
from seamark.sim.recording.telemetry import Rows


class Valve(Intervention[ValveConfiguration]):
    """The valve is to be turned."""

    task = "valve"

    def attempt(self, config: ValveConfiguration, rows: Rows) -> valve_turning.Turning:
        """Return the rows of a level for its metrics."""
        return valve_turning.Turning(rows, config.control_period_s)

    def drawn_work(self, config: ValveConfiguration, *, seed: int, trial: int) -> Mapping[str, Any]:
        """Return what is drawn of the valve for a trial, as plain JSON values."""
        return self._valve(config, seed, trial).as_dict()

    def target(self, config: ValveConfiguration, *, seed: int, trial: int) -> Target:
        """Return the panel."""
        return scene.target(self._valve(config, seed, trial))

    def workpiece(
        self, config: ValveConfiguration, *, seed: int, trial: int, level: int
    ) -> Workpiece:
        """Return the valve on its panel."""
        return scene.workpiece(self._valve(config, seed, trial))

    def _valve(self, config: ValveConfiguration, seed: int, trial: int) -> scene.ValveDraw:
        return scene.draw_valve(config, streams(seed, trial, 0))


EXPERIMENT = Valve(valve_turning.METRICS)
