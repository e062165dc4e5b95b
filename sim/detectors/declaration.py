"""How a detector declares itself, as a tracker does."""

from seamark.sim.detectors.interface import Detector
from seamark.sim.trackers.declaration import Declaration


class DetectorDeclaration(Declaration[Detector]):
    """A detector."""
