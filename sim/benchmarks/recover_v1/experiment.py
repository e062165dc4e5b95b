"""recover-v1: the box on the seabed, drawn for each trial, and how far it was recovered."""

from collections.abc import Mapping
from typing import Any

from seamark.sim.benchmarks.intervention import box
from seamark.sim.benchmarks.intervention.experiment import Intervention
from seamark.sim.benchmarks.recover_v1.settings import RecoverConfiguration
from seamark.sim.camera.target import Target
from seamark.sim.metrics import recovery
from seamark.sim.multibody.workpiece import Workpiece
from seamark.sim.numerics.random_streams import streams
from seamark.sim.recording.telemetry import Rows


class Recover(Intervention[RecoverConfiguration]):
    """The box is to be lifted and held."""

    task = "recover"

    def attempt(self, config: RecoverConfiguration, rows: Rows) -> recovery.Recovery:
        """Return the rows of a level for its metrics."""
        return recovery.Recovery(rows, config.control_period_s)

    def drawn_work(
        self, config: RecoverConfiguration, *, seed: int, trial: int
    ) -> Mapping[str, Any]:
        """Return what is drawn of the box for a trial, as plain JSON values."""
        return self._box(config, seed, trial).as_dict()

    def target(self, config: RecoverConfiguration, *, seed: int, trial: int) -> Target:
        """Return where the box is at the start."""
        return box.target(self._box(config, seed, trial))

    def workpiece(
        self, config: RecoverConfiguration, *, seed: int, trial: int, level: int
    ) -> Workpiece:
        """Return the box."""
        return box.workpiece(self._box(config, seed, trial))

    def _box(self, config: RecoverConfiguration, seed: int, trial: int) -> box.BoxDraw:
        return box.draw_box(config, streams(seed, trial, 0))


EXPERIMENT = Recover(recovery.METRICS)
