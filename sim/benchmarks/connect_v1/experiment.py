"""connect-v1: connector and receptacle, drawn for each trial, and how far the one was plugged."""

from collections.abc import Mapping
from typing import Any

from seamark.sim.benchmarks.connect_v1 import scene
from seamark.sim.benchmarks.connect_v1.settings import ConnectConfiguration
from seamark.sim.benchmarks.intervention.experiment import Intervention
from seamark.sim.camera.target import Target
from seamark.sim.metrics import connection
from seamark.sim.multibody.workpiece import Workpiece
from seamark.sim.numerics.random_streams import streams
from seamark.sim.recording.telemetry import Rows


class Connect(Intervention[ConnectConfiguration]):
    """The connector is to be plugged and let go."""

    task = "connect"

    def attempt(self, config: ConnectConfiguration, rows: Rows) -> connection.Connection:
        """Return the rows of a level for its metrics."""
        return connection.Connection(rows, config.control_period_s)

    def drawn_work(
        self, config: ConnectConfiguration, *, seed: int, trial: int
    ) -> Mapping[str, Any]:
        """Return what is drawn of connector and panel for a trial, as plain JSON values."""
        return self._connector(config, seed, trial).as_dict()

    def target(self, config: ConnectConfiguration, *, seed: int, trial: int) -> Target:
        """Return the panel."""
        return scene.target(self._connector(config, seed, trial))

    def workpiece(
        self, config: ConnectConfiguration, *, seed: int, trial: int, level: int
    ) -> Workpiece:
        """Return the connector beside its receptacle."""
        return scene.workpiece(self._connector(config, seed, trial))

    def _connector(
        self, config: ConnectConfiguration, seed: int, trial: int
    ) -> scene.ConnectorDraw:
        return scene.draw_connector(config, streams(seed, trial, 0))


EXPERIMENT = Connect(connection.METRICS)
