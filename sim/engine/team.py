"""Several programs that take part in one run together, each in a role of its own."""

from dataclasses import dataclass

from seamark.sim.detectors import Detector
from seamark.sim.engine.program import Program
from seamark.sim.trackers import Tracker


@dataclass(frozen=True, slots=True)
class Team:
    """A controller with a tracker and a detector of its user's, in place of the configured ones."""

    controller: Program
    tracker: Tracker | None = None  # None: the one of the settings
    detector: Detector | None = None
