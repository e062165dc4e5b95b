"""`nothing` and `random`: detectors that do not look at the image."""

import numpy as np

from seamark.sim.camera.bottom.things import KINDS
from seamark.sim.camera.optics import VISIBILITY
from seamark.sim.detectors.interface import Detection, Image, most_confident
from seamark.sim.numerics.libm import PI, cos, sin
from seamark.sim.vehicles.patterns import CLASSES

_SEED = 20261127  # a stream of its own: no other draws of a run change it, nor does it change them
_ALTITUDE_M = (1.2, 2.0)  # E: of the camera, as the benchmark's
_ANSWERS = 2  # of each class to an image, E
_NUMBERS = 7  # of an answer: centre, size, proportion, heading, altitude, confidence


class Nothing:
    """Finds nothing."""

    def detect(self, image: Image) -> list[Detection]:
        """Return no detection."""
        return []


class Random:
    """Answers with rectangles at random places; the classes' sizes are all that it knows."""

    def __init__(self) -> None:
        self._random = np.random.Generator(np.random.PCG64(_SEED))

    def detect(self, image: Image) -> list[Detection]:
        """Return the next random detections."""
        shares = self._random.random((_ANSWERS * len(CLASSES), _NUMBERS))
        labels = _ANSWERS * list(CLASSES)
        return most_confident(
            [_placed(*each) for each in zip(labels, shares.tolist(), strict=True)]
        )


def _placed(label: str, shares: list[float]) -> Detection:
    kind, optics = KINDS[label], VISIBILITY
    low, high = _ALTITUDE_M
    scale = optics.focal_px / (low + (high - low) * shares[0])
    length = scale * (kind.length[0] + (kind.length[1] - kind.length[0]) * shares[1])
    width = length * (kind.width[0] + (kind.width[1] - kind.width[0]) * shares[2])
    heading = 2.0 * PI * shares[3]
    along = 0.5 * length * np.array([cos(heading), sin(heading)])
    across = 0.5 * width * np.array([-sin(heading), cos(heading)])
    middle = np.array([optics.width * shares[4], optics.height * shares[5]])
    corners = middle + np.array([-along - across, along - across, along + across, across - along])
    return Detection(label, corners, shares[6])
